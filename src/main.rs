//! The `telamon` command.
fn main() {}
