//! How the next direction of a path is chosen.

use glam::{Vec2, Vec3A};

use super::knobs::Needs;
use super::tracer::Shading;
use crate::bsdf::{Bsdf, BsdfSample, Flags, Lobe, Place};
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
    /// A direction to go on; see [`Bsdf::sample`], which is asked where this is [`DirectionSampling::Bsdf`]
    /// and for all materials with delta lobes, that no hemisphere would find.
    // Inlined, so that the shading need not be in memory.
    #[inline(always)]
    pub(super) fn sample(self, shading: &Shading<'_>, u: Vec2) -> Option<BsdfSample> {
        let Shading { bsdf, flags, wi, .. } = *shading;
        match self.unless_delta(flags) {
            Self::Bsdf => bsdf.sample(&shading.place, wi, u),
            hemisphere => hemisphere.sample_hemisphere(bsdf, flags, &shading.place, wi, u),
        }
    }

    /// Density with which [`DirectionSampling::sample`] chooses `wo`, in sr⁻¹.
    #[inline(always)]
    pub(super) fn pdf(self, shading: &Shading<'_>, wo: Vec3A) -> f32 {
        match self.unless_delta(shading.flags) {
            Self::Bsdf => shading.bsdf.pdf(&shading.place, shading.wi, wo),
            hemisphere if shading.flags.transmits => 0.5 * hemisphere.hemisphere_pdf(wo),
            hemisphere if shading.wi.z * wo.z > 0.0 => hemisphere.hemisphere_pdf(wo),
            _ => 0.0,
        }
    }

    /// The technique that is used for a material.
    fn unless_delta(self, flags: Flags) -> Self {
        if flags.delta { Self::Bsdf } else { self }
    }

    #[inline(never)]
    fn sample_hemisphere(
        self,
        bsdf: &dyn Bsdf,
        flags: Flags,
        place: &Place,
        wi: Vec3A,
        u: Vec2,
    ) -> Option<BsdfSample> {
        let warp = match self {
            Self::UniformHemisphere => warp::square_to_uniform_hemisphere,
            Self::Bsdf | Self::CosineHemisphere => warp::square_to_cosine_hemisphere,
        };
        let (mut wo, mut choice) = (Vec3A::from(warp(u.into())), 1.0);
        if flags.transmits {
            // Both hemispheres, one half of the numbers each.
            choice = 0.5;
            wo = warp(Vec2::new((2.0 * u.x).fract(), u.y).into()).into();
            wo.z = if u.x < 0.5 { wo.z } else { -wo.z };
        }
        wo.z = wo.z.copysign(wo.z * wi.z);
        let pdf = self.hemisphere_pdf(wo) * choice;
        (pdf > 0.0).then(|| BsdfSample {
            wo,
            weight: bsdf.eval(place, wi, wo) / pdf,
            pdf,
            lobe: Lobe::Smooth,
            eta: 1.0,
        })
    }

    /// Density in the hemisphere of `wo`.
    fn hemisphere_pdf(self, wo: Vec3A) -> f32 {
        let above = Vec3A::new(wo.x, wo.y, wo.z.abs());
        match self {
            Self::UniformHemisphere => warp::square_to_uniform_hemisphere_pdf(above.into()),
            Self::Bsdf | Self::CosineHemisphere => {
                warp::square_to_cosine_hemisphere_pdf(above.into())
            }
        }
    }
}
