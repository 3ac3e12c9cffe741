//! Ideal diffuse reflection.

use super::{Flags, Material, Place, Scattered};
use crate::math::real::Real;
use crate::math::vector::{Vec2, Vec3};
use crate::math::{Rgb, warp};
use crate::texture::Textured;

/// Lambert's law: f = reflectance/π on the side of the normal, nothing on the other side.
#[derive(Clone, Debug)]
pub struct Diffuse {
    reflectance: Textured<Rgb>,
}

impl Diffuse {
    /// `reflectance` in `[0, 1]` per channel.
    #[must_use]
    pub fn new(reflectance: impl Into<Textured<Rgb>>) -> Self {
        Self { reflectance: reflectance.into() }
    }
}

impl Material for Diffuse {
    #[inline(always)]
    fn evaluate<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, wo: Vec3<R>) -> (Vec3<R>, R) {
        let pdf = R::select(wi.z.gt(0.0), warp::square_to_cosine_hemisphere_pdf(wo), 0.0);
        // The cosine and 1/π are the density's too.
        (self.reflectance.at(place.uv) * pdf, pdf)
    }

    #[inline(always)]
    fn sample<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, u: Vec2<R>) -> Scattered<R> {
        let wo = warp::square_to_cosine_hemisphere(u);
        let pdf = warp::square_to_cosine_hemisphere_pdf(wo);
        // The cosine and π cancel in the weight.
        let weight = self.reflectance.at(place.uv);
        Scattered::smooth(wi.z.gt(0.0) & pdf.gt(0.0), wo, weight, pdf)
    }

    fn flags(&self) -> Flags {
        Flags::DIFFUSE.textured(&self.reflectance)
    }

    fn albedo(&self, place: &Place, wi: Vec3) -> Vec3 {
        self.reflectance.at(place.uv) * f32::from(u8::from(wi.z > 0.0))
    }
}
