//! Smooth plastic.

use std::f32::consts::FRAC_1_PI;

use super::{Flags, Material, Place, Scattered, choose, fresnel, mirrored};
use crate::math::real::{Lanes, Mask, Real, Select};
use crate::math::vector::{Vec2, Vec3};
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
    #[inline(always)]
    pub(super) fn specular<R: Real>(&self, place: &Place<R>) -> Vec3<R> {
        self.specular_reflectance.at(place.uv)
    }

    /// What leaves the base over what enters through the coat, per solid angle inside, times π: all that is
    /// scattered by the base and thrown back by the coat, which lets `escaping` of it pass each time, in a
    /// geometric series.
    #[inline(always)]
    pub(super) fn diffuse<R: Real>(&self, place: &Place<R>, escaping: f32) -> Vec3<R> {
        let base = self.diffuse_reflectance.at(place.uv);
        let series = if self.nonlinear {
            // Without 1 − base·(1 − escaping), which is lost for a white base under a mirror.
            base.map(|base| base / (base.one_minus() + base * escaping))
        } else {
            base / escaping
        };
        series / (self.eta * self.eta)
    }

    /// The probability of a specular sample where the coat reflects the fraction `reflected`.
    #[inline(always)]
    pub(super) fn specular_probability<R: Real>(&self, reflected: R) -> R {
        let specular = reflected * self.specular_share;
        let diffuse = reflected.one_minus() * (1.0 - self.specular_share);
        // 0/0 where neither lobe has anything.
        (specular / (specular + diffuse)).max(0.0)
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

    #[inline(always)]
    fn reflected<R: Real>(&self, w: Vec3<R>) -> R {
        fresnel::dielectric(w.z, self.coat.eta).reflectance
    }

    /// π f of the base as seen from `wi`, without what leaves towards `wo`.
    #[inline(always)]
    fn diffuse<R: Real>(&self, place: &Place<R>, reflected: R) -> Vec3<R> {
        self.coat.diffuse(place, self.escaping) * reflected.one_minus()
    }
}

impl Material for Plastic {
    #[inline(always)]
    fn evaluate<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, wo: Vec3<R>) -> (Vec3<R>, R) {
        let above = wi.z.gt(0.0) & wo.z.gt(0.0);
        let reflected = self.reflected(wi);
        let leaving = self.reflected(wo).one_minus() * FRAC_1_PI * wo.z;
        let value = self.diffuse(place, reflected) * leaving;
        let share = self.coat.specular_probability(reflected).one_minus();
        let pdf = share * warp::square_to_cosine_hemisphere_pdf(wo);
        (value.only_where(above), R::select(above, pdf, 0.0))
    }

    #[inline(always)]
    fn sample<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, u: Vec2<R>) -> Scattered<R> {
        let everywhere = R::Mask::splat(wi.token(), true);
        let reflected = self.reflected(wi);
        let probability = self.coat.specular_probability(reflected);
        let (specular, rest) = choose(probability, u.x);
        let weight = self.coat.specular(place) * (reflected / probability);
        let mirrored = Scattered::delta(everywhere, mirrored(wi), weight, probability);
        let share = probability.one_minus();
        let wo = warp::square_to_cosine_hemisphere(Vec2::new(rest, u.y));
        let pdf = share * warp::square_to_cosine_hemisphere_pdf(wo);
        let weight = self.diffuse(place, reflected) * (self.reflected(wo).one_minus() / share);
        let diffuse = Scattered::smooth(pdf.gt(0.0), wo, weight, pdf);
        Scattered::selected(specular, mirrored, diffuse).only_where(wi.z.gt(0.0))
    }

    fn flags(&self) -> Flags {
        self.coat.flags(Flags::DIFFUSE.union(Flags::DELTA))
    }

    fn albedo(&self, place: &Place, wi: Vec3) -> Vec3 {
        let reflected = self.reflected(wi);
        let diffuse = self.diffuse(place, reflected) * self.entering;
        (self.coat.specular(place) * reflected + diffuse).only_where(wi.z > 0.0)
    }

    fn interface(&self) -> Option<f32> {
        Some(1.0)
    }
}
