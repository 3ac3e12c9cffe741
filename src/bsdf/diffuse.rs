//! Ideal diffuse reflection.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3A};

use super::{Bsdf, BsdfSample};
use crate::math::{Rgb, warp};

/// Lambert's law: f = reflectance/π on the side of the normal, nothing on the other side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diffuse {
    reflectance: Rgb,
}

impl Diffuse {
    /// `reflectance` in `[0, 1]` per channel.
    #[must_use]
    pub fn new(reflectance: Rgb) -> Self {
        Self { reflectance }
    }
}

impl Bsdf for Diffuse {
    fn eval(&self, wi: Vec3A, wo: Vec3A) -> Rgb {
        if wi.z > 0.0 && wo.z > 0.0 { self.reflectance * (FRAC_1_PI * wo.z) } else { Rgb::ZERO }
    }

    fn pdf(&self, wi: Vec3A, wo: Vec3A) -> f32 {
        if wi.z > 0.0 { warp::square_to_cosine_hemisphere_pdf(wo) } else { 0.0 }
    }

    fn sample(&self, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        let wo = warp::square_to_cosine_hemisphere(u);
        let pdf = warp::square_to_cosine_hemisphere_pdf(wo);
        // The cosine and π cancel in the weight.
        (wi.z > 0.0 && pdf > 0.0).then_some(BsdfSample {
            wo,
            weight: self.reflectance,
            pdf,
            delta: false,
            eta: 1.0,
        })
    }

    fn is_delta(&self) -> bool {
        false
    }

    fn transmits(&self) -> bool {
        false
    }

    fn albedo(&self, wi: Vec3A) -> Rgb {
        if wi.z > 0.0 { self.reflectance } else { Rgb::ZERO }
    }
}
