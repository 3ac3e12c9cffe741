//! Engines that answer ray queries, and the choice among them.
//!
//! An engine is built once over the shapes of a scene and is then shared by all threads. A ray for
//! which [`Ray::is_traceable`] is false hits nothing. Hits at exactly `t_min` or `t_max` may go either
//! way. Neither engine changes how the processor treats denormal numbers: they are kept, in both.

use std::fmt::Debug;
use std::sync::Arc;

use crate::ray::{Hit, Ray};
use crate::shape::Shape;

pub mod bvh;
mod moller_trumbore;

pub use bvh::Bvh;

/// Answers ray queries over the shapes that it was built from.
pub trait Intersector: Debug + Send + Sync {
    /// The nearest hit within the ray's segment.
    fn closest_hit(&self, ray: &Ray) -> Option<Hit>;

    /// Whether anything lies within the ray's segment.
    fn occluded(&self, ray: &Ray) -> bool;

    /// [`Intersector::closest_hit`] of each ray, written to the same place of `hits`.
    ///
    /// # Panics
    /// If the lengths differ.
    fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]);

    /// [`Intersector::occluded`] of each ray, written to the same place of `occluded`.
    ///
    /// # Panics
    /// If the lengths differ.
    fn occluded_many(&self, rays: &[Ray], occluded: &mut [bool]);

    /// Bytes that the acceleration structure occupies, without the shapes' own buffers.
    fn bytes(&self) -> usize;

    /// Name and version, as shown in reports: `"Embree 3.13.5"`.
    fn name(&self) -> String;
}

/// An engine by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// Debian's Embree, in robust mode.
    #[cfg(feature = "embree")]
    Embree,
    /// The BVH of this crate, with Möller–Trumbore triangles.
    Rust,
}
