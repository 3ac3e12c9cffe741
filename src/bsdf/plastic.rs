//! Smooth plastic.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3A};

use super::{Bsdf, BsdfSample, Flags, Lobe, Place, choose, fresnel};
use crate::math::{Rgb, warp};
use crate::texture::Textured;

/// A diffuse base under a smooth dielectric coat; one-sided. Light that the coat throws back to the base is
/// scattered again, however often.
#[derive(Clone, Debug)]
pub struct Plastic {
    coat: Coat,
    /// The fraction of diffuse light that passes the coat from inside.
    escaping: f32,
    /// The same from outside.
    entering: f32,
}

/// What smooth and rough plastic have in common.
#[derive(Clone, Debug)]
pub struct Coat {
    /// Index inside over index outside.
    pub(super) eta: f32,
    diffuse_reflectance: Textured<Rgb>,
    specular_reflectance: Textured<Rgb>,
    nonlinear: bool,
    /// The share of specular samples where as much light is reflected as enters.
    specular_share: f32,
}

impl Coat {
    /// `int_ior` of the coat, `ext_ior` outside, both > 0; the base reflects `diffuse_reflectance`, what the
    /// coat reflects is scaled by `specular_reflectance`, which is 1 in nature. With `nonlinear` colours get
    /// more saturated each time that light is thrown back to the base.
    #[must_use]
    pub fn new(
        int_ior: f32,
        ext_ior: f32,
        diffuse_reflectance: impl Into<Textured<Rgb>>,
        specular_reflectance: impl Into<Textured<Rgb>>,
        nonlinear: bool,
    ) -> Self {
        let (diffuse, specular) = (diffuse_reflectance.into(), specular_reflectance.into());
        let share = specular.mean() / (diffuse.mean() + specular.mean());
        Self {
            eta: int_ior / ext_ior,
            diffuse_reflectance: diffuse,
            specular_reflectance: specular,
            nonlinear,
            // 0/0 where nothing is reflected at all.
            specular_share: if share.is_nan() { 0.5 } else { share.clamp(0.0, 1.0) },
        }
    }

    /// The colour of what the coat reflects.
    pub(super) fn specular(&self, place: &Place) -> Rgb {
        self.specular_reflectance.at(place.uv).into()
    }

    /// What leaves the base over what enters through the coat, per solid angle inside, times π: all that is
    /// scattered by the base and thrown back by the coat, which lets `escaping` of it pass each time, in a
    /// geometric series.
    pub(super) fn diffuse(&self, place: &Place, escaping: f32) -> Rgb {
        let base = Rgb::from(self.diffuse_reflectance.at(place.uv));
        // Without 1 − base·(1 − escaping), which is lost for a white base under a mirror.
        let lost = Rgb::splat(escaping) * if self.nonlinear { base } else { Rgb::ONE };
        let absorbed = if self.nonlinear { Rgb::ONE - base } else { Rgb::ZERO };
        base / (absorbed + lost) / (self.eta * self.eta)
    }

    /// The probability of a specular sample where the coat reflects the fraction `reflected`.
    pub(super) fn specular_probability(&self, reflected: f32) -> f32 {
        let specular = reflected * self.specular_share;
        let diffuse = (1.0 - reflected) * (1.0 - self.specular_share);
        let probability = specular / (specular + diffuse);
        // 0/0 where neither lobe has anything.
        if probability.is_nan() { 0.0 } else { probability }
    }

    pub(super) fn flags(&self, flags: Flags) -> Flags {
        flags.textured(&self.diffuse_reflectance).textured(&self.specular_reflectance)
    }
}

impl Plastic {
    /// Plastic with this coat.
    #[must_use]
    pub fn new(coat: Coat) -> Self {
        let escaping = fresnel::dielectric_mean_transmittance(1.0 / coat.eta);
        let entering = fresnel::dielectric_mean_transmittance(coat.eta);
        Self { coat, escaping, entering }
    }

    fn reflected(&self, w: Vec3A) -> f32 {
        fresnel::dielectric(w.z, self.coat.eta).reflectance
    }

    /// π f of the base as seen from `wi`, without what leaves towards `wo`.
    fn diffuse(&self, place: &Place, reflected: f32) -> Rgb {
        self.coat.diffuse(place, self.escaping) * (1.0 - reflected)
    }
}

impl Bsdf for Plastic {
    fn eval(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> Rgb {
        if !(wi.z > 0.0 && wo.z > 0.0) {
            return Rgb::ZERO;
        }
        let diffuse = self.diffuse(place, self.reflected(wi));
        diffuse * ((1.0 - self.reflected(wo)) * FRAC_1_PI * wo.z)
    }

    fn pdf(&self, _place: &Place, wi: Vec3A, wo: Vec3A) -> f32 {
        if !(wi.z > 0.0 && wo.z > 0.0) {
            return 0.0;
        }
        let diffuse = 1.0 - self.coat.specular_probability(self.reflected(wi));
        diffuse * warp::square_to_cosine_hemisphere_pdf(wo.into())
    }

    fn sample(&self, place: &Place, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        if wi.z <= 0.0 {
            return None;
        }
        let reflected = self.reflected(wi);
        let probability = self.coat.specular_probability(reflected);
        let (specular, rest) = choose(probability, u.x);
        if specular {
            return Some(BsdfSample {
                wo: Vec3A::new(-wi.x, -wi.y, wi.z),
                weight: self.coat.specular(place) * (reflected / probability),
                pdf: probability,
                lobe: Lobe::Delta,
                eta: 1.0,
            });
        }
        let wo = Vec3A::from(warp::square_to_cosine_hemisphere(Vec2::new(rest, u.y).into()));
        let pdf = self.pdf(place, wi, wo);
        (pdf > 0.0).then(|| BsdfSample {
            wo,
            weight: self.diffuse(place, reflected)
                * ((1.0 - self.reflected(wo)) / (1.0 - probability)),
            pdf,
            lobe: Lobe::Smooth,
            eta: 1.0,
        })
    }

    fn flags(&self) -> Flags {
        self.coat.flags(Flags::SMOOTH.union(Flags::DELTA))
    }

    fn albedo(&self, place: &Place, wi: Vec3A) -> Rgb {
        if wi.z <= 0.0 {
            return Rgb::ZERO;
        }
        let reflected = self.reflected(wi);
        self.coat.specular(place) * reflected + self.diffuse(place, reflected) * self.entering
    }

    fn interface(&self) -> Option<f32> {
        Some(1.0)
    }
}
