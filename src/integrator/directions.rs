//! How the next direction of a path is chosen.

use glam::{Vec2, Vec3A};

use crate::bsdf::{Bsdf, BsdfSample};
use crate::math::warp;
use crate::scene::settings::DirectionSampling;

impl DirectionSampling {
    /// A direction to go on from `wi`; see [`Bsdf::sample`], which is asked where this is
    /// [`DirectionSampling::Bsdf`] and for ideal mirrors and glass, that no hemisphere would find.
    pub(super) fn sample(self, bsdf: &dyn Bsdf, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        let warp = match self {
            Self::Bsdf => return bsdf.sample(wi, u),
            _ if bsdf.is_delta() => return bsdf.sample(wi, u),
            Self::CosineHemisphere => warp::square_to_cosine_hemisphere,
            Self::UniformHemisphere => warp::square_to_uniform_hemisphere,
        };
        let (mut wo, mut choice) = (warp(u), 1.0);
        if bsdf.transmits() {
            // Both hemispheres, one half of the numbers each.
            choice = 0.5;
            wo = warp(Vec2::new((2.0 * u.x).fract(), u.y));
            wo.z = if u.x < 0.5 { wo.z } else { -wo.z };
        }
        wo.z = wo.z.copysign(wo.z * wi.z);
        let pdf = self.hemisphere_pdf(wo) * choice;
        (pdf > 0.0).then(|| BsdfSample {
            wo,
            weight: bsdf.eval(wi, wo) / pdf,
            pdf,
            delta: false,
            eta: 1.0,
        })
    }

    /// Density with which [`DirectionSampling::sample`] chooses `wo`, in sr⁻¹.
    pub(super) fn pdf(self, bsdf: &dyn Bsdf, wi: Vec3A, wo: Vec3A) -> f32 {
        match self {
            Self::Bsdf => bsdf.pdf(wi, wo),
            _ if bsdf.is_delta() => 0.0,
            _ if bsdf.transmits() => 0.5 * self.hemisphere_pdf(wo),
            _ if wi.z * wo.z > 0.0 => self.hemisphere_pdf(wo),
            _ => 0.0,
        }
    }

    /// Density in the hemisphere of `wo`.
    fn hemisphere_pdf(self, wo: Vec3A) -> f32 {
        let above = Vec3A::new(wo.x, wo.y, wo.z.abs());
        match self {
            Self::UniformHemisphere => warp::square_to_uniform_hemisphere_pdf(above),
            Self::Bsdf | Self::CosineHemisphere => warp::square_to_cosine_hemisphere_pdf(above),
        }
    }
}
