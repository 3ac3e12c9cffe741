//! Rough metals.

use glam::{Vec2, Vec3A};

use super::conductor::Metal;
use super::microfacet::{Microfacets, Roughness};
use super::{Bsdf, BsdfSample, Flags, Lobe, Place, reflect};
use crate::math::Rgb;

/// Reflection by microfacets of metal that hide each other, without light that is reflected twice (Cook and
/// Torrance 1982; Walter et al. 2007); one-sided.
#[derive(Clone, Debug)]
pub struct RoughConductor {
    metal: Metal,
    roughness: Roughness,
}

impl RoughConductor {
    /// A surface of `metal` with `roughness`.
    #[must_use]
    pub fn new(metal: Metal, roughness: Roughness) -> Self {
        Self { metal, roughness }
    }
}

/// Density of directions that are reflected by visible facets with the normal `m`, in sr⁻¹.
pub(super) fn reflected_pdf(facets: &Microfacets, wi: Vec3A, m: Vec3A) -> f32 {
    0.25 * facets.visible_pdf_over_cosine(wi, m)
}

/// The normal that reflects `wi` to `wo`, both above the surface; `None` unless they are.
pub(super) fn half_vector(wi: Vec3A, wo: Vec3A) -> Option<Vec3A> {
    if wi.z > 0.0 && wo.z > 0.0 { (wi + wo).try_normalize() } else { None }
}

impl Bsdf for RoughConductor {
    fn eval(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> Rgb {
        let Some(m) = half_vector(wi, wo) else { return Rgb::ZERO };
        let facets = self.roughness.at(place);
        let value = reflected_pdf(&facets, wi, m) * facets.g1(wo, m);
        self.metal.reflectance(place, wi.dot(m)) * value
    }

    fn pdf(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> f32 {
        half_vector(wi, wo).map_or(0.0, |m| reflected_pdf(&self.roughness.at(place), wi, m))
    }

    fn sample(&self, place: &Place, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        if wi.z <= 0.0 {
            return None;
        }
        let facets = self.roughness.at(place);
        let wo = reflect(wi, facets.sample_visible(wi, u))?;
        // The normal again, as `pdf` will find it from the rounded direction.
        let m = half_vector(wi, wo)?;
        let pdf = reflected_pdf(&facets, wi, m);
        (pdf > 0.0 && pdf.is_finite()).then(|| BsdfSample {
            wo,
            // The density of the normals cancels.
            weight: self.metal.reflectance(place, wi.dot(m)) * facets.g1(wo, m),
            pdf,
            lobe: Lobe::Smooth,
            eta: 1.0,
        })
    }

    fn flags(&self) -> Flags {
        self.roughness.flags(self.metal.flags(Flags::SMOOTH))
    }

    fn albedo(&self, place: &Place, wi: Vec3A) -> Rgb {
        if wi.z > 0.0 { self.metal.reflectance(place, wi.z) } else { Rgb::ZERO }
    }

    fn interface(&self) -> Option<f32> {
        Some(1.0)
    }
}
