//! How the next direction of a path is chosen.

use super::knobs::Needs;
use super::shading::Shading;
use crate::bsdf::{Flags, Scattered};
use crate::math::real::Real;
use crate::math::vector::{Vec2, Vec3};
use crate::math::warp;
use crate::property::named::names;
use crate::property::{Default, Kind, Named, PropertyInfo, property};

/// How the next direction of a path is chosen at a surface that is no ideal mirror or glass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DirectionSampling {
    /// By the material, in proportion to what it scatters as far as possible.
    Bsdf,
    /// Cosine-weighted in the hemisphere.
    CosineHemisphere,
    /// Uniform in the hemisphere.
    UniformHemisphere,
}

impl Named for DirectionSampling {
    const ALL: &'static [(&'static str, Self)] = &[
        ("bsdf", Self::Bsdf),
        ("cosine", Self::CosineHemisphere),
        ("uniform", Self::UniformHemisphere),
    ];
}

/// The property of integrators that let it be chosen.
pub(super) const DIRECTIONS: PropertyInfo = property(
    "directions",
    Kind::Choice(&names::<_, 3>(DirectionSampling::ALL)),
    Default::Text(DirectionSampling::ALL[0].0),
    "how directions are chosen: by the material, cosine-weighted or uniform in the hemisphere",
);

/// Why the knob may change nothing.
pub(super) const NEEDS: Needs = Needs::Reason("integrator `direct_uniform` has only one way");

impl DirectionSampling {
    /// A direction to go on; see [`Bsdf::sample`](crate::bsdf::Bsdf::sample), which is asked where this is
    /// [`DirectionSampling::Bsdf`] and for all materials with delta lobes, that no hemisphere would find.
    #[inline(always)]
    pub(super) fn sample<R: Real>(self, shading: &Shading<'_, R>, u: Vec2<R>) -> Scattered<R> {
        match self.unless_delta(shading.flags) {
            Self::Bsdf => shading.bsdf.scatter(&shading.place, shading.wi, u),
            hemisphere => hemisphere.sample_hemisphere(shading, u),
        }
    }

    /// f·|cosθ| towards `wo`, and the density with which [`DirectionSampling::sample`] chooses that, in sr⁻¹.
    #[inline(always)]
    pub(super) fn evaluate<R: Real>(self, shading: &Shading<'_, R>, wo: Vec3<R>) -> (Vec3<R>, R) {
        let Shading { bsdf, flags, place, wi, .. } = shading;
        let (value, of_material) = bsdf.evaluate(place, *wi, wo);
        let pdf = match self.unless_delta(*flags) {
            Self::Bsdf => of_material,
            hemisphere if flags.transmits => hemisphere.hemisphere_pdf(wo) * 0.5,
            hemisphere => {
                let reflected = (wi.z * wo.z).gt(0.0);
                R::select(reflected, hemisphere.hemisphere_pdf(wo), 0.0)
            }
        };
        (value, pdf)
    }

    /// The technique that is used for a material.
    fn unless_delta(self, flags: Flags) -> Self {
        if flags.delta { Self::Bsdf } else { self }
    }

    #[inline(always)]
    fn sample_hemisphere<R: Real>(self, shading: &Shading<'_, R>, u: Vec2<R>) -> Scattered<R> {
        let Shading { bsdf, flags, place, wi, .. } = shading;
        let warp = |u| match self {
            Self::UniformHemisphere => warp::square_to_uniform_hemisphere(u),
            Self::Bsdf | Self::CosineHemisphere => warp::square_to_cosine_hemisphere(u),
        };
        let (mut wo, mut choice) = (warp(u), 1.0);
        if flags.transmits {
            // Both hemispheres, one half of the numbers each.
            choice = 0.5;
            let doubled = u.x * 2.0;
            wo = warp(Vec2::new(doubled - doubled.floor(), u.y));
            wo.z = R::select(u.x.lt(0.5), wo.z, -wo.z);
        }
        wo.z = wo.z.copysign(wo.z * wi.z);
        let pdf = self.hemisphere_pdf(wo) * choice;
        let (value, _) = bsdf.evaluate(place, *wi, wo);
        Scattered::smooth(pdf.gt(0.0), wo, value / pdf, pdf)
    }

    /// Density in the hemisphere of `wo`.
    #[inline(always)]
    fn hemisphere_pdf<R: Real>(self, wo: Vec3<R>) -> R {
        let above = Vec3::new(wo.x, wo.y, wo.z.abs());
        match self {
            Self::UniformHemisphere => warp::square_to_uniform_hemisphere_pdf(above),
            Self::Bsdf | Self::CosineHemisphere => warp::square_to_cosine_hemisphere_pdf(above),
        }
    }
}
