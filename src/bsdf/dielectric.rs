//! Smooth glass.

use glam::{Vec2, Vec3A};

use super::{Bsdf, BsdfSample, fresnel};
use crate::math::Rgb;

/// Specular reflection and refraction at the interface of two dielectrics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Index inside (side of −z) over index outside.
    eta: f32,
    specular_reflectance: Rgb,
    specular_transmittance: Rgb,
}

impl Dielectric {
    /// `int_ior` on the side that the normal points away from, `ext_ior` on the other, both > 0; the
    /// two factors scale what is reflected and transmitted and are 1 for real glass.
    #[must_use]
    pub fn new(
        int_ior: f32,
        ext_ior: f32,
        specular_reflectance: Rgb,
        specular_transmittance: Rgb,
    ) -> Self {
        Self { eta: int_ior / ext_ior, specular_reflectance, specular_transmittance }
    }
}

impl Bsdf for Dielectric {
    fn eval(&self, _wi: Vec3A, _wo: Vec3A) -> Rgb {
        Rgb::ZERO
    }

    fn pdf(&self, _wi: Vec3A, _wo: Vec3A) -> f32 {
        0.0
    }

    /// Chooses between the two in proportion to what they carry, so that the Fresnel term leaves the
    /// weight.
    fn sample(&self, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        if wi.z == 0.0 {
            return None;
        }
        let f = fresnel::dielectric(wi.z, self.eta);
        if u.x < f.reflectance {
            return Some(BsdfSample {
                wo: Vec3A::new(-wi.x, -wi.y, wi.z),
                weight: self.specular_reflectance,
                pdf: f.reflectance,
                delta: true,
                eta: 1.0,
            });
        }
        let wo = Vec3A::new(-wi.x / f.eta, -wi.y / f.eta, f.cos_t).try_normalize()?;
        Some(BsdfSample {
            wo,
            // Radiance is squeezed into a smaller cone on the denser side (Veach 1997, section 5.2).
            weight: self.specular_transmittance / (f.eta * f.eta),
            pdf: 1.0 - f.reflectance,
            delta: true,
            eta: f.eta,
        })
    }

    fn is_delta(&self) -> bool {
        true
    }

    fn transmits(&self) -> bool {
        true
    }

    fn albedo(&self, wi: Vec3A) -> Rgb {
        let reflected = fresnel::dielectric(wi.z, self.eta).reflectance;
        self.specular_reflectance * reflected + self.specular_transmittance * (1.0 - reflected)
    }
}
