//! Smooth metals and ideal mirrors.

use glam::{Vec2, Vec3A};

use super::{Bsdf, BsdfSample, fresnel};
use crate::math::Rgb;

/// Specular reflection with the Fresnel reflectance of a metal; one-sided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    index: Option<ComplexIndex>,
    specular_reflectance: Rgb,
}

/// A complex index of refraction `eta + i k`, per channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComplexIndex {
    /// Real part.
    pub eta: Rgb,
    /// Imaginary part (extinction).
    pub k: Rgb,
}

impl Conductor {
    /// A metal of the given index in vacuum, or with `None` a mirror that reflects everything; both
    /// scaled by `specular_reflectance` in `[0, 1]`.
    #[must_use]
    pub fn new(index: Option<ComplexIndex>, specular_reflectance: Rgb) -> Self {
        Self { index, specular_reflectance }
    }
}

impl Bsdf for Conductor {
    fn eval(&self, _wi: Vec3A, _wo: Vec3A) -> Rgb {
        Rgb::ZERO
    }

    fn pdf(&self, _wi: Vec3A, _wo: Vec3A) -> f32 {
        0.0
    }

    fn sample(&self, wi: Vec3A, _u: Vec2) -> Option<BsdfSample> {
        (wi.z > 0.0).then(|| BsdfSample {
            wo: Vec3A::new(-wi.x, -wi.y, wi.z),
            weight: self.albedo(wi),
            pdf: 1.0,
            delta: true,
            eta: 1.0,
        })
    }

    fn is_delta(&self) -> bool {
        true
    }

    fn transmits(&self) -> bool {
        false
    }

    fn albedo(&self, wi: Vec3A) -> Rgb {
        if wi.z <= 0.0 {
            return Rgb::ZERO;
        }
        let fresnel = self.index.map_or(Rgb::ONE, |i| fresnel::conductor(wi.z, i.eta, i.k));
        fresnel * self.specular_reflectance
    }
}
