//! What can be told to an integrator, a sampler, a material: properties with their names, ranges and defaults, and
//! what it was told. Scene files, `measure` and the documentation all read the same tables, each of which
//! stands beside the code that it is about.

mod default;
pub mod given;
pub mod kind;
pub mod named;

pub use default::Default;
pub use given::{At, Given, Nothing, Refusal};
pub use kind::{Bounds, Kind, Value};
pub use named::Named;

/// A property.
#[derive(Debug)]
pub struct PropertyInfo {
    /// Its `name`.
    pub name: &'static str,
    /// The values that it takes.
    pub kind: Kind,
    /// What holds if it is not given.
    pub default: Default,
    /// What it means, in a sentence.
    pub help: &'static str,
}

/// A property in one line of the tables.
pub(crate) const fn property(
    name: &'static str,
    kind: Kind,
    default: Default,
    help: &'static str,
) -> PropertyInfo {
    PropertyInfo { name, kind, default, help }
}
