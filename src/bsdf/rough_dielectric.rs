//! Rough glass.

use super::dielectric::Factors;
use super::microfacet::{Microfacets, Roughness};
use super::rough_conductor::reflected_pdf;
use super::twosided::turned;
use super::{Flags, Material, Place, Scattered, fresnel, is_usable, reflect};
use crate::math::Rgb;
use crate::math::real::{Lanes, Mask, Real};
use crate::math::vector::{Vec2, Vec3};
use crate::texture::Textured;

/// Reflection and refraction by microfacets at the interface of two dielectrics, without light that is
/// scattered twice: Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (2007).
#[derive(Clone, Debug)]
pub struct RoughDielectric {
    /// Index inside (side of −z) over index outside.
    eta: f32,
    roughness: Roughness,
    factors: Factors,
}

/// Directions seen from the side of `wi`, which is made the side of +z.
struct Side<R: Real> {
    wi: Vec3<R>,
    /// Whether z was turned around for that.
    below: R::Mask,
    /// Index of the other side over that of this one.
    eta: R,
    facets: Microfacets<R>,
}

impl RoughDielectric {
    /// `eta` is the index on the side that the normal points away from over that on the other, > 0 and
    /// not 1; the two factors scale what is reflected and transmitted and are 1 for real glass.
    /// `None` if `eta` is 1: where nothing is refracted, no normal can be told from the directions.
    #[must_use]
    pub fn new(
        eta: f32,
        roughness: Roughness,
        specular_reflectance: impl Into<Textured<Rgb>>,
        specular_transmittance: impl Into<Textured<Rgb>>,
    ) -> Option<Self> {
        (eta != 1.0).then(|| Self {
            eta,
            roughness,
            factors: Factors::new(specular_reflectance, specular_transmittance),
        })
    }

    #[inline(always)]
    fn side<R: Real>(&self, place: &Place<R>, wi: Vec3<R>) -> Side<R> {
        let below = wi.z.lt(0.0);
        let eta = R::select(below, R::splat(wi.token(), 1.0 / self.eta), self.eta);
        Side { wi: turned(below, wi), below, eta, facets: self.roughness.at(place) }
    }
}

impl<R: Real> Side<R> {
    /// The normal that reflects or refracts `wi` to `wo`, on the side of `wi`, and whether there is one.
    #[inline(always)]
    fn normal(&self, wo: Vec3<R>) -> (Vec3<R>, R::Mask) {
        let eta = R::select(wo.z.gt(0.0), 1.0, self.eta);
        let (m, exists) = (self.wi + wo * eta).try_normalize();
        (Vec3::select(m.z.lt(0.0), -m, m), exists)
    }

    /// Density of `wo` if it comes from facets with the normal `m`, in sr⁻¹; 0 if they cannot send it
    /// there.
    #[inline(always)]
    fn pdf(&self, wo: Vec3<R>, m: Vec3<R>) -> R {
        let (cos_i, cos_o) = (self.wi.dot(m), wo.dot(m));
        // Each side of the facet has to be seen from the same side of the surface.
        let seen = cos_i.gt(0.0) & (cos_o * wo.z).gt(0.0);
        let reflectance = fresnel::dielectric(cos_i, self.eta).reflectance;
        let reflected = reflectance * reflected_pdf(&self.facets, self.wi, m);
        // Walter et al., equation 17, on the side of `wi`.
        let across = cos_i + self.eta * cos_o;
        let jacobian = self.eta * self.eta * cos_o.abs() / (across * across);
        let visible = self.facets.visible_pdf_over_cosine(self.wi, m) * cos_i;
        let refracted = reflectance.one_minus() * visible * jacobian;
        R::select(seen, R::select(wo.z.gt(0.0), reflected, refracted), 0.0)
    }
}

/// Two numbers from one: it itself, rounded to the middle of one of 4096 intervals, and where it stood in the
/// interval. The latter decides between reflection and refraction once the normal is known.
#[inline(always)]
fn split<R: Real>(u: R) -> (R, R) {
    const INTERVALS: f32 = 4096.0;
    let scaled = u * INTERVALS;
    let interval = scaled.floor();
    ((interval + 0.5) / INTERVALS, scaled - interval)
}

impl Material for RoughDielectric {
    #[inline(always)]
    fn evaluate<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, wo: Vec3<R>) -> (Vec3<R>, R) {
        let side = self.side(place, wi);
        let wo = turned(side.below, wo);
        let (m, exists) = side.normal(wo);
        let pdf = R::select(exists & !wi.z.eq(0.0), side.pdf(wo, m), 0.0);
        let factor = self.factors.at(place, wo.z.gt(0.0), side.eta);
        (factor * (pdf * side.facets.g1(wo, m)), pdf)
    }

    /// Chooses a normal, then between reflection and refraction in proportion to what they carry, so that
    /// only the shadowing of `wo` is left in the weight.
    #[inline(always)]
    fn sample<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, u: Vec2<R>) -> Scattered<R> {
        let side = self.side(place, wi);
        let (azimuth, choice) = split(u.x);
        let m = side.facets.sample_visible(side.wi, Vec2::new(azimuth, u.y));
        let cos_i = side.wi.dot(m);
        let f = fresnel::dielectric(cos_i, side.eta);
        let reflects = choice.lt(f.reflectance);
        let refracted = m * (cos_i / f.eta + f.cos_t) - side.wi / f.eta;
        let (wo, exists) = Vec3::select(reflects, reflect(side.wi, m), refracted).try_normalize();
        let on_its_side = (reflects ^ wo.z.lt(0.0)) & !wo.z.eq(0.0);
        let exists = exists & on_its_side & !wi.z.eq(0.0);
        // From the rounded direction, as `evaluate` will find it; or from the facet itself where the indices
        // are so close to each other that rounding hides the normal.
        let (normal, has_normal) = side.normal(wo);
        let pdf = side.pdf(wo, normal);
        let found = has_normal & is_usable(pdf);
        let pdf = (found | !exists).either(
            #[inline(always)]
            || pdf,
            #[inline(always)]
            || side.pdf(wo, m),
        );
        let weight = self.factors.at(place, reflects, f.eta) * side.facets.g1(wo, m);
        let wo = turned(side.below, wo);
        let eta = R::select(reflects, 1.0, f.eta);
        Scattered { eta, ..Scattered::smooth(exists & is_usable(pdf), wo, weight, pdf) }
    }

    fn flags(&self) -> Flags {
        self.roughness.flags(self.factors.flags(Flags::SMOOTH.transmitting()))
    }

    fn albedo(&self, place: &Place, wi: Vec3) -> Vec3 {
        let reflected = fresnel::dielectric(wi.z, self.eta).reflectance;
        self.factors.albedo(place, reflected)
    }

    fn interface(&self) -> Option<f32> {
        Some(self.eta)
    }
}
