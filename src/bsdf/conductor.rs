//! Smooth metals and ideal mirrors.

use super::{Flags, Material, Place, Scattered, fresnel, mirrored};
use crate::math::Rgb;
use crate::math::real::{Lanes, Real};
use crate::math::vector::{Vec2, Vec3};
use crate::texture::Textured;

/// Specular reflection with the Fresnel reflectance of a metal; one-sided.
#[derive(Clone, Debug)]
pub struct Conductor {
    metal: Metal,
}

/// A complex index of refraction `eta + i k`, per channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComplexIndex {
    /// Real part.
    pub eta: Rgb,
    /// Imaginary part (extinction).
    pub k: Rgb,
}

/// What a metal reflects.
#[derive(Clone, Debug)]
pub struct Metal {
    index: Option<(Textured<Rgb>, Textured<Rgb>)>,
    specular_reflectance: Textured<Rgb>,
}

impl Metal {
    /// A metal of the given index (real and imaginary part) in vacuum, or with `None` a mirror that
    /// reflects everything; both scaled by `specular_reflectance` in `[0, 1]`.
    #[must_use]
    pub fn new(
        index: Option<(Textured<Rgb>, Textured<Rgb>)>,
        specular_reflectance: impl Into<Textured<Rgb>>,
    ) -> Self {
        Self { index, specular_reflectance: specular_reflectance.into() }
    }

    /// The reflected fraction at the cosine `cos` > 0.
    #[inline(always)]
    pub(super) fn reflectance<R: Real>(&self, place: &Place<R>, cos: R) -> Vec3<R> {
        let scale = self.specular_reflectance.at(place.uv);
        match &self.index {
            Some((eta, k)) => {
                fresnel::conductor(cos, eta.at(place.uv), k.at(place.uv)).times(scale)
            }
            None => scale,
        }
    }

    /// As [`Bsdf::albedo`](super::Bsdf::albedo) of a surface that is smooth or counts as smooth.
    pub(super) fn albedo(&self, place: &Place, wi: Vec3) -> Vec3 {
        self.reflectance(place, wi.z).only_where(wi.z > 0.0)
    }

    /// Those of a material with this metal.
    pub(super) fn flags(&self, flags: Flags) -> Flags {
        let flags = flags.textured(&self.specular_reflectance);
        match &self.index {
            Some((eta, k)) => flags.textured(eta).textured(k),
            None => flags,
        }
    }
}

impl Conductor {
    /// A smooth surface of `metal`.
    #[must_use]
    pub fn new(metal: Metal) -> Self {
        Self { metal }
    }

    /// A mirror that reflects the fraction `specular_reflectance` of the light.
    #[must_use]
    pub fn mirror(specular_reflectance: impl Into<Textured<Rgb>>) -> Self {
        Self::new(Metal::new(None, specular_reflectance))
    }
}

impl Material for Conductor {
    #[inline(always)]
    fn sample<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, _u: Vec2<R>) -> Scattered<R> {
        let (weight, one) = (self.metal.reflectance(place, wi.z), R::splat(wi.token(), 1.0));
        Scattered::delta(wi.z.gt(0.0), mirrored(wi), weight, one)
    }

    fn flags(&self) -> Flags {
        self.metal.flags(Flags::DELTA)
    }

    fn albedo(&self, place: &Place, wi: Vec3) -> Vec3 {
        self.metal.albedo(place, wi)
    }

    fn interface(&self) -> Option<f32> {
        Some(1.0)
    }
}
