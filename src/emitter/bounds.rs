//! Where emitters are and which way they shine, bounded: what a light BVH is built from.
//!
//! Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting" (2018), section 4.1.

use std::f32::consts::FRAC_PI_2;

use glam::Vec3A;

use crate::math::{Aabb, Cone};

/// A box around emitters, a cone around the normals of all their points, and how far from a normal they shine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmitterBounds {
    /// A box around all points that emit, world space.
    pub space: Aabb,
    /// The normals of those points.
    pub normals: Cone,
    /// Largest angle between a normal and a direction of its light, in `[0, π]`.
    pub emission: f32,
    /// About the largest radiant intensity in one direction, in W/sr, as luminance; 0 if it is dark.
    pub intensity: f64,
}

impl EmitterBounds {
    /// Those of a point that shines within `normals` and up to an angle of `emission` from there.
    #[must_use]
    pub fn point(position: Vec3A, normals: Cone, emission: f32, intensity: f64) -> Self {
        let space = Aabb { min: position.into(), max: position.into() };
        Self { space, normals, emission, intensity }
    }

    /// Those of a surface that shines to its front.
    #[must_use]
    pub fn surface(space: Aabb, normals: Cone, intensity: f64) -> Self {
        Self { space, normals, emission: FRAC_PI_2, intensity }
    }

    /// Bounds around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            space: self.space.union(other.space),
            normals: self.normals.union(&other.normals),
            emission: self.emission.max(other.emission),
            intensity: self.intensity + other.intensity,
        }
    }
}
