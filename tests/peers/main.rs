//! peers
#[path = "../support/mod.rs"]
mod support;
