//! Engines that answer ray queries, and the choice among them.
//!
//! An engine is built once over the shapes of a scene and is then shared by all threads. A ray for
//! which [`Ray::is_traceable`] is false hits nothing. Hits at exactly `t_min` or `t_max` may go either
//! way. A ray that leaves or reaches a surface ([`Ray::start`], [`Ray::end`]) meets what the ray between the exact
//! points meets: hits close to an end that rounding makes up are passed over. Neither engine changes how the processor treats denormal numbers: they are kept, in both.

use std::fmt::{self, Debug, Display, Formatter};
use std::str::FromStr;
use std::sync::Arc;

use crate::ray::{Hit, Ray, Rays};
use crate::shape::Shape;

pub mod accel;
pub mod bvh;
#[cfg(feature = "embree")]
pub mod embree;
pub(crate) mod groups;
pub mod recorder;
mod spurious;
mod triangle;

pub use accel::Accel;
pub use bvh::Bvh;
#[cfg(feature = "embree")]
pub use embree::Embree;
pub use recorder::Recorder;

/// Answers ray queries over the shapes that it was built from.
pub trait Intersector: Debug + Send + Sync {
    /// The nearest hit within the ray's segment.
    fn closest_hit(&self, ray: &Ray) -> Option<Hit>;

    /// Whether anything lies within the ray's segment.
    fn occluded(&self, ray: &Ray) -> bool;

    /// [`Intersector::closest_hit`] of each ray, written to the same place of `hits`, which an engine may find sooner
    /// together. The answers are the same.
    ///
    /// # Panics
    /// If the lengths differ.
    fn closest_hits(&self, rays: &Rays, hits: &mut [Option<Hit>]);

    /// [`Intersector::occluded`] of each ray, written to the same place of `occluded`.
    ///
    /// # Panics
    /// If the lengths differ.
    fn occluded_many(&self, rays: &Rays, occluded: &mut [bool]);

    /// Bytes that the acceleration structure occupies, without the shapes' own buffers.
    fn bytes(&self) -> usize;

    /// Name and version, as shown in reports: `"Embree 3.13.5"`.
    fn name(&self) -> String;
}

/// An engine by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// Debian's Embree, by default in robust mode.
    #[cfg(feature = "embree")]
    Embree,
    /// The BVH of this crate.
    Rust,
}

impl Backend {
    /// The engines that this build contains, the default first.
    pub const AVAILABLE: &'static [Self] = &[
        #[cfg(feature = "embree")]
        Self::Embree,
        Self::Rust,
    ];

    /// Its name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree => "embree",
            Self::Rust => "rust",
        }
    }
}

impl Default for Backend {
    fn default() -> Self {
        Self::AVAILABLE[0]
    }
}

impl Display for Backend {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Backend {
    type Err = UnknownBackend;

    fn from_str(name: &str) -> Result<Self, UnknownBackend> {
        let found = Self::AVAILABLE.iter().find(|b| b.name() == name);
        found.copied().ok_or_else(|| UnknownBackend { name: name.to_owned() })
    }
}

/// A name that no engine of this build has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no backend `{name}` in this build (expected one of: {})", available_names())]
pub struct UnknownBackend {
    name: String,
}

fn available_names() -> String {
    let names: Vec<_> = Backend::AVAILABLE.iter().map(|b| b.name()).collect();
    names.join(", ")
}

/// Why an engine could not be built.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BuildError {
    /// Embree refused, in its own words.
    #[cfg(feature = "embree")]
    #[error("Embree: {0}")]
    Embree(String),
    /// A scene too large for the Rust engine.
    #[error("more than {limit} primitives, which the Rust engine cannot number")]
    TooManyPrimitives {
        /// How many it can.
        limit: usize,
    },
}

/// Builds an engine over `shapes`; a hit's `shape` is an index into them. A [`Backend`] stands for the
/// engine in its default modes.
///
/// # Errors
/// What the engine itself refuses, such as a build that runs out of memory.
pub fn build(
    accel: impl Into<Accel>,
    shapes: &[Arc<dyn Shape>],
) -> Result<Box<dyn Intersector>, BuildError> {
    match accel.into() {
        #[cfg(feature = "embree")]
        Accel::Embree(modes) => Ok(Box::new(Embree::new(modes, shapes)?)),
        Accel::Rust(modes) => Ok(Box::new(Bvh::new(modes, shapes)?)),
    }
}

/// The largest coordinate, in magnitude, of anything that an engine has to intersect.
fn reach(shapes: &[Arc<dyn Shape>]) -> f32 {
    let bounds = shapes.iter().map(|shape| shape.bounds()).filter(|bounds| !bounds.is_empty());
    bounds.map(|b| b.min.abs().max(b.max.abs()).max_element()).fold(0.0, f32::max)
}

/// Answers a batch ray by ray.
fn for_each_ray<T>(rays: &Rays, answers: &mut [T], answer: impl Fn(&Ray) -> T) {
    assert_eq!(rays.len(), answers.len(), "one answer for each ray");
    for (ray, slot) in rays.iter().zip(answers) {
        *slot = answer(&ray);
    }
}
