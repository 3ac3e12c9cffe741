//! Smooth glass.

use glam::{Vec2, Vec3A};

use super::{Bsdf, BsdfSample, Flags, Lobe, Place, fresnel};
use crate::math::Rgb;
use crate::texture::Textured;

/// Specular reflection and refraction at the interface of two dielectrics.
#[derive(Clone, Debug)]
pub struct Dielectric {
    /// Index inside (side of −z) over index outside.
    eta: f32,
    factors: Factors,
}

/// Factors of what an interface reflects and transmits.
#[derive(Clone, Debug)]
pub(super) struct Factors {
    pub(super) reflectance: Textured<Rgb>,
    pub(super) transmittance: Textured<Rgb>,
}

impl Factors {
    pub(super) fn new(
        reflectance: impl Into<Textured<Rgb>>,
        transmittance: impl Into<Textured<Rgb>>,
    ) -> Self {
        Self { reflectance: reflectance.into(), transmittance: transmittance.into() }
    }

    /// Those of a material with these factors.
    pub(super) fn flags(&self, flags: Flags) -> Flags {
        flags.textured(&self.reflectance).textured(&self.transmittance)
    }

    /// What is scattered where the fraction `reflected` is reflected and the rest transmitted.
    pub(super) fn albedo(&self, place: &Place, reflected: f32) -> Rgb {
        Rgb::from(self.reflectance.at(place.uv)) * reflected
            + Rgb::from(self.transmittance.at(place.uv)) * (1.0 - reflected)
    }
}

impl Dielectric {
    /// `int_ior` on the side that the normal points away from, `ext_ior` on the other, both > 0; the
    /// two factors scale what is reflected and transmitted and are 1 for real glass.
    #[must_use]
    pub fn new(
        int_ior: f32,
        ext_ior: f32,
        specular_reflectance: impl Into<Textured<Rgb>>,
        specular_transmittance: impl Into<Textured<Rgb>>,
    ) -> Self {
        Self {
            eta: int_ior / ext_ior,
            factors: Factors::new(specular_reflectance, specular_transmittance),
        }
    }
}

impl Bsdf for Dielectric {
    fn eval(&self, _place: &Place, _wi: Vec3A, _wo: Vec3A) -> Rgb {
        Rgb::ZERO
    }

    fn pdf(&self, _place: &Place, _wi: Vec3A, _wo: Vec3A) -> f32 {
        0.0
    }

    /// Chooses between the two in proportion to what they carry, so that the Fresnel term leaves the
    /// weight.
    fn sample(&self, place: &Place, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        if wi.z == 0.0 {
            return None;
        }
        let f = fresnel::dielectric(wi.z, self.eta);
        if u.x < f.reflectance {
            return Some(BsdfSample {
                wo: Vec3A::new(-wi.x, -wi.y, wi.z),
                weight: self.factors.reflectance.at(place.uv).into(),
                pdf: f.reflectance,
                lobe: Lobe::Delta,
                eta: 1.0,
            });
        }
        let wo = Vec3A::new(-wi.x / f.eta, -wi.y / f.eta, f.cos_t).try_normalize()?;
        Some(BsdfSample {
            wo,
            // Radiance is squeezed into a smaller cone on the denser side (Veach 1997, section 5.2).
            weight: Rgb::from(self.factors.transmittance.at(place.uv)) / (f.eta * f.eta),
            pdf: 1.0 - f.reflectance,
            lobe: Lobe::Delta,
            eta: f.eta,
        })
    }

    fn flags(&self) -> Flags {
        self.factors.flags(Flags::DELTA.transmitting())
    }

    fn albedo(&self, place: &Place, wi: Vec3A) -> Rgb {
        let reflected = fresnel::dielectric(wi.z, self.eta).reflectance;
        self.factors.albedo(place, reflected)
    }

    fn interface(&self) -> Option<f32> {
        Some(self.eta)
    }
}
