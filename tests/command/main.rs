//! The command as a user meets it: the real program, run in a fresh folder.

mod inspect;
mod meshes;
mod render;
#[path = "../support/mod.rs"]
mod support;
mod usage;
