//! Rough glass.

use glam::{Vec2, Vec3A};

use super::dielectric::Factors;
use super::microfacet::{Microfacets, Roughness};
use super::rough_conductor::reflected_pdf;
use super::{Bsdf, BsdfSample, Flags, Lobe, Place, fresnel, reflect};
use crate::math::Rgb;
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
struct Side {
    wi: Vec3A,
    /// Turns z around if it has to be.
    mirror: Vec3A,
    /// Index of the other side over that of this one.
    eta: f32,
    facets: Microfacets,
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

    fn side(&self, place: &Place, wi: Vec3A) -> Option<Side> {
        let below = wi.z < 0.0;
        let mirror = Vec3A::new(1.0, 1.0, if below { -1.0 } else { 1.0 });
        let eta = if below { 1.0 / self.eta } else { self.eta };
        let facets = self.roughness.at(place);
        (wi.z != 0.0).then_some(Side { wi: wi * mirror, mirror, eta, facets })
    }
}

impl Side {
    /// The normal that reflects or refracts `wi` to `wo`, on the side of `wi`.
    fn normal(&self, wo: Vec3A) -> Option<Vec3A> {
        let eta = if wo.z > 0.0 { 1.0 } else { self.eta };
        let m = (self.wi + wo * eta).try_normalize()?;
        Some(if m.z < 0.0 { -m } else { m })
    }

    /// Density of `wo` if it comes from facets with the normal `m`, in sr⁻¹; 0 if they cannot send it
    /// there.
    fn pdf(&self, wo: Vec3A, m: Vec3A) -> f32 {
        let (cos_i, cos_o) = (self.wi.dot(m), wo.dot(m));
        // Each side of the facet has to be seen from the same side of the surface.
        if !(cos_i > 0.0 && cos_o * wo.z > 0.0) {
            return 0.0;
        }
        let reflectance = fresnel::dielectric(cos_i, self.eta).reflectance;
        if wo.z > 0.0 {
            return reflectance * reflected_pdf(&self.facets, self.wi, m);
        }
        // Walter et al., equation 17, on the side of `wi`.
        let jacobian = self.eta * self.eta * cos_o.abs() / (cos_i + self.eta * cos_o).powi(2);
        (1.0 - reflectance) * self.facets.visible_pdf_over_cosine(self.wi, m) * cos_i * jacobian
    }
}

/// Two numbers from one: it itself, rounded to the middle of one of 4096 intervals, and where it stood in the
/// interval. The latter decides between reflection and refraction once the normal is known.
fn split(u: f32) -> (f32, f32) {
    const INTERVALS: f32 = 4096.0;
    let scaled = u * INTERVALS;
    ((scaled.floor() + 0.5) / INTERVALS, scaled.fract())
}

impl Bsdf for RoughDielectric {
    fn eval(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> Rgb {
        let Some(side) = self.side(place, wi) else { return Rgb::ZERO };
        let wo = wo * side.mirror;
        let Some(m) = side.normal(wo) else { return Rgb::ZERO };
        let scale = side.pdf(wo, m) * side.facets.g1(wo, m);
        if wo.z > 0.0 {
            Rgb::from(self.factors.reflectance.at(place.uv)) * scale
        } else {
            Rgb::from(self.factors.transmittance.at(place.uv)) * (scale / (side.eta * side.eta))
        }
    }

    fn pdf(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> f32 {
        let Some(side) = self.side(place, wi) else { return 0.0 };
        let wo = wo * side.mirror;
        side.normal(wo).map_or(0.0, |m| side.pdf(wo, m))
    }

    /// Chooses a normal, then between reflection and refraction in proportion to what they carry, so that
    /// only the shadowing of `wo` is left in the weight.
    fn sample(&self, place: &Place, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        let side = self.side(place, wi)?;
        let (azimuth, choice) = split(u.x);
        let m = side.facets.sample_visible(side.wi, Vec2::new(azimuth, u.y));
        let cos_i = side.wi.dot(m);
        let f = fresnel::dielectric(cos_i, side.eta);
        let (wo, weight, eta) = if choice < f.reflectance {
            (reflect(side.wi, m)?, self.factors.reflectance.at(place.uv).into(), 1.0)
        } else {
            let refracted = m * (cos_i / f.eta + f.cos_t) - side.wi / f.eta;
            // Radiance is squeezed into a smaller cone on the denser side (Veach 1997, section 5.2).
            let weight = Rgb::from(self.factors.transmittance.at(place.uv)) / (f.eta * f.eta);
            (refracted.try_normalize()?, weight, f.eta)
        };
        if (wo.z > 0.0) != (eta == 1.0) || wo.z == 0.0 {
            return None;
        }
        // From the rounded direction, as `pdf` will find it; or from the facet itself where the indices
        // are so close to each other that rounding hides the normal.
        let usable = |pdf: &f32| *pdf > 0.0 && pdf.is_finite();
        let pdf = side.normal(wo).map(|m| side.pdf(wo, m)).filter(usable);
        let pdf = pdf.or_else(|| Some(side.pdf(wo, m)).filter(usable))?;
        let weight = weight * side.facets.g1(wo, m);
        Some(BsdfSample { wo: wo * side.mirror, weight, pdf, lobe: Lobe::Smooth, eta })
    }

    fn flags(&self) -> Flags {
        self.roughness.flags(self.factors.flags(Flags::SMOOTH.transmitting()))
    }

    fn albedo(&self, place: &Place, wi: Vec3A) -> Rgb {
        let reflected = fresnel::dielectric(wi.z, self.eta).reflectance;
        self.factors.albedo(place, reflected)
    }

    fn interface(&self) -> Option<f32> {
        Some(self.eta)
    }
}
