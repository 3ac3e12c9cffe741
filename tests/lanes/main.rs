//! One lane and eight: the same bits at every level, for all that a path asks.

#[path = "../support/mod.rs"]
mod support;

mod cameras;
mod materials;
mod pictures;
mod samplers;
mod surfaces;
