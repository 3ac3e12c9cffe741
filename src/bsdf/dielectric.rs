//! Smooth glass.
//!
//! Where the shading normal is not that of the geometry, total reflection is not quite total: the fraction sin² δ goes
//! straight on, with the angle δ between the two normals. True facets keep the volume of light in phase space (positions by
//! directions, weighted with the cosine), so what got in comes out again. Reflection by a normal that leans does not: it
//! draws light together, on a coarse mesh into cycles of total reflection that nothing leaves, however the normals are
//! bent. They all lean somewhere, so none of them keeps its light; on a mesh that is fine enough for its normals, where
//! δ is a few degrees, nobody sees the difference.

use super::fresnel::{self, DielectricFresnel};
use super::{Flags, Material, Place, Scattered, mirrored};
use crate::math::Rgb;
use crate::math::real::{Lanes, Real};
use crate::math::vector::{Vec2, Vec3};
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

    /// The weight of light that is reflected where `reflects` is set, and elsewhere refracted into the index `eta`
    /// times that of where it comes from.
    #[inline(always)]
    pub(super) fn at<R: Real>(&self, place: &Place<R>, reflects: R::Mask, eta: R) -> Vec3<R> {
        let (reflected, transmitted) =
            (self.reflectance.at(place.uv), self.transmittance.at(place.uv));
        // Radiance is squeezed into a smaller cone on the denser side (Veach 1997, section 5.2).
        Vec3::select(reflects, reflected, transmitted / (eta * eta))
    }

    /// What is scattered where the fraction `reflected` is reflected and the rest transmitted.
    pub(super) fn albedo(&self, place: &Place, reflected: f32) -> Vec3 {
        self.reflectance.at(place.uv) * reflected
            + self.transmittance.at(place.uv) * (1.0 - reflected)
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

    /// What happens to light from `wi`, and whether Fresnel's equations have it reflected totally, where the rest of the
    /// reflectance goes straight on.
    #[inline(always)]
    fn fresnel<R: Real>(&self, place: &Place<R>, wi: Vec3<R>) -> (DielectricFresnel<R>, R::Mask) {
        let f = fresnel::dielectric(wi.z, self.eta);
        let total = f.cos_t.eq(0.0);
        let cosine = place.geometric_normal.z;
        let reflectance = R::select(total, (cosine * cosine).min(1.0), f.reflectance);
        (DielectricFresnel { reflectance, ..f }, total)
    }
}

impl Material for Dielectric {
    /// Chooses between the two in proportion to what they carry, so that the Fresnel term leaves the
    /// weight.
    #[inline(always)]
    fn sample<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, u: Vec2<R>) -> Scattered<R> {
        let (f, total) = self.fresnel(place, wi);
        let reflects = u.x.lt(f.reflectance);
        let refracted = Vec3::new(-wi.x / f.eta, -wi.y / f.eta, f.cos_t);
        let (refracted, refracts) = Vec3::select(total, -wi, refracted).try_normalize();
        let exists = (reflects | refracts) & !wi.z.eq(0.0);
        let wo = Vec3::select(reflects, mirrored(wi), refracted);
        let weight = self.factors.at(place, reflects, f.eta);
        let probability = R::select(reflects, f.reflectance, f.reflectance.one_minus());
        let eta = R::select(reflects, 1.0, f.eta);
        Scattered { eta, ..Scattered::delta(exists, wo, weight, probability) }
    }

    fn flags(&self) -> Flags {
        self.factors.flags(Flags::DELTA.transmitting())
    }

    fn albedo(&self, place: &Place, wi: Vec3) -> Vec3 {
        self.factors.albedo(place, self.fresnel(place, wi).0.reflectance)
    }

    fn interface(&self) -> Option<f32> {
        Some(self.eta)
    }
}
