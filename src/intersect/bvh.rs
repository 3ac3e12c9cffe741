//! placeholder
/// Rust engine.
#[derive(Debug)]
pub struct Bvh;
