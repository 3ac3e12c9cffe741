//! Smooth metals and ideal mirrors.

use glam::{Vec2, Vec3A};

use super::{Bsdf, BsdfSample, Flags, Lobe, Place, fresnel};
use crate::math::Rgb;
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
    pub(super) fn reflectance(&self, place: &Place, cos: f32) -> Rgb {
        let fresnel = self.index.as_ref().map_or(Rgb::ONE, |(eta, k)| {
            fresnel::conductor(cos, eta.at(place.uv).into(), k.at(place.uv).into())
        });
        fresnel * Rgb::from(self.specular_reflectance.at(place.uv))
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

impl Bsdf for Conductor {
    fn eval(&self, _place: &Place, _wi: Vec3A, _wo: Vec3A) -> Rgb {
        Rgb::ZERO
    }

    fn pdf(&self, _place: &Place, _wi: Vec3A, _wo: Vec3A) -> f32 {
        0.0
    }

    fn sample(&self, place: &Place, wi: Vec3A, _u: Vec2) -> Option<BsdfSample> {
        (wi.z > 0.0).then(|| BsdfSample {
            wo: Vec3A::new(-wi.x, -wi.y, wi.z),
            weight: self.albedo(place, wi),
            pdf: 1.0,
            lobe: Lobe::Delta,
            eta: 1.0,
        })
    }

    fn flags(&self) -> Flags {
        self.metal.flags(Flags::DELTA)
    }

    fn albedo(&self, place: &Place, wi: Vec3A) -> Rgb {
        if wi.z > 0.0 { self.metal.reflectance(place, wi.z) } else { Rgb::ZERO }
    }

    fn interface(&self) -> Option<f32> {
        Some(1.0)
    }
}
