//! Rough metals.

use super::conductor::Metal;
use super::microfacet::{Microfacets, Roughness};
use super::{Flags, Material, Place, Scattered, is_usable, reflect};
use crate::math::real::Real;
use crate::math::vector::{Vec2, Vec3};

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
#[inline(always)]
pub(super) fn reflected_pdf<R: Real>(facets: &Microfacets<R>, wi: Vec3<R>, m: Vec3<R>) -> R {
    facets.visible_pdf_over_cosine(wi, m) * 0.25
}

/// The normal that reflects `wi` to `wo`, and whether there is one: whether both are above the surface.
#[inline(always)]
pub(super) fn half_vector<R: Real>(wi: Vec3<R>, wo: Vec3<R>) -> (Vec3<R>, R::Mask) {
    let (m, exists) = (wi + wo).try_normalize();
    (m, exists & wi.z.gt(0.0) & wo.z.gt(0.0))
}

impl Material for RoughConductor {
    #[inline(always)]
    fn evaluate<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, wo: Vec3<R>) -> (Vec3<R>, R) {
        let (m, exists) = half_vector(wi, wo);
        let facets = self.roughness.at(place);
        let pdf = reflected_pdf(&facets, wi, m);
        let value = self.metal.reflectance(place, wi.dot(m)) * (pdf * facets.g1(wo, m));
        (value.only_where(exists), R::select(exists, pdf, 0.0))
    }

    #[inline(always)]
    fn sample<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, u: Vec2<R>) -> Scattered<R> {
        let facets = self.roughness.at(place);
        let (wo, reflects) = reflect(wi, facets.sample_visible(wi, u)).try_normalize();
        // The normal again, as `evaluate` will find it from the rounded direction.
        let (m, exists) = half_vector(wi, wo);
        let pdf = reflected_pdf(&facets, wi, m);
        // The density of the normals cancels.
        let weight = self.metal.reflectance(place, wi.dot(m)) * facets.g1(wo, m);
        Scattered::smooth(reflects & exists & is_usable(pdf), wo, weight, pdf)
    }

    fn flags(&self) -> Flags {
        self.roughness.flags(self.metal.flags(Flags::SMOOTH))
    }

    fn albedo(&self, place: &Place, wi: Vec3) -> Vec3 {
        self.metal.albedo(place, wi)
    }

    fn interface(&self) -> Option<f32> {
        Some(1.0)
    }
}
