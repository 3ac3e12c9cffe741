//! Ideal diffuse reflection.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3A};

use super::{Bsdf, BsdfSample, Flags, Lobe, Place};
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

impl Bsdf for Diffuse {
    fn eval(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> Rgb {
        if wi.z > 0.0 && wo.z > 0.0 {
            self.reflectance.at(place.uv) * (FRAC_1_PI * wo.z)
        } else {
            Rgb::ZERO
        }
    }

    fn pdf(&self, _place: &Place, wi: Vec3A, wo: Vec3A) -> f32 {
        if wi.z > 0.0 { warp::square_to_cosine_hemisphere_pdf(wo.into()) } else { 0.0 }
    }

    fn sample(&self, place: &Place, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        let wo = Vec3A::from(warp::square_to_cosine_hemisphere(u.into()));
        let pdf = warp::square_to_cosine_hemisphere_pdf(wo.into());
        // The cosine and π cancel in the weight.
        (wi.z > 0.0 && pdf > 0.0).then(|| BsdfSample {
            wo,
            weight: self.reflectance.at(place.uv),
            pdf,
            lobe: Lobe::Smooth,
            eta: 1.0,
        })
    }

    fn flags(&self) -> Flags {
        Flags::SMOOTH.textured(&self.reflectance)
    }

    fn albedo(&self, place: &Place, wi: Vec3A) -> Rgb {
        if wi.z > 0.0 { self.reflectance.at(place.uv) } else { Rgb::ZERO }
    }
}
