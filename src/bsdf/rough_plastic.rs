//! Rough plastic.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3A};
use rayon::prelude::*;

use super::microfacet::{Distribution, Microfacets};
use super::plastic::Coat;
use super::rough_conductor::{half_vector, reflected_pdf};
use super::{Bsdf, BsdfSample, Flags, Lobe, Place, choose, fresnel, reflect};
use crate::math::special::gauss_legendre;
use crate::math::{Rgb, warp};

/// A diffuse base under a rough dielectric coat; one-sided.
#[derive(Clone, Debug)]
pub struct RoughPlastic {
    coat: Coat,
    facets: Microfacets,
    /// The fraction of light that passes the coat from outside, at equally spaced cosines from 0 to 1.
    transmittance: Vec<f32>,
    /// The fraction of diffuse light that passes the coat from inside.
    escaping: f32,
    /// The same from outside, as if the coat were smooth.
    entering: f32,
}

/// Entries of the table of transmittances. As many as Mitsuba has, because the mean over them, which gives
/// the reflectance from inside, is part of the material's definition there.
const ENTRIES: usize = 64;

impl RoughPlastic {
    /// Plastic with this coat, whose roughness is `alpha` in all directions; see
    /// [`super::microfacet::Roughness::new`].
    #[must_use]
    pub fn new(coat: Coat, distribution: Distribution, alpha: f32) -> Self {
        let facets = Microfacets::new(distribution, Vec2::splat(alpha));
        let cosines: Vec<f32> =
            (0..ENTRIES).map(|i| (i as f32 / (ENTRIES - 1) as f32).max(1e-6)).collect();
        let scattered = |eta: f32, refracted: bool| -> Vec<f64> {
            // The integrand has a kink where total reflection begins.
            let rule = gauss_legendre(if eta > 1.0 { 32 } else { 96 });
            cosines
                .par_iter()
                .map(|&cos| directional(&facets, cos, eta, refracted, &rule))
                .collect()
        };
        let entering = fresnel::dielectric_mean_transmittance(coat.eta);
        let transmittance = scattered(coat.eta, true);
        let thrown_back = scattered(1.0 / coat.eta, false);
        let sum: f64 = thrown_back.iter().zip(&cosines).map(|(r, &cos)| r * f64::from(cos)).sum();
        Self {
            coat,
            facets,
            transmittance: transmittance.into_iter().map(|t| t as f32).collect(),
            // Never quite nothing, which rounding could make it.
            escaping: (1.0 - 2.0 * sum / ENTRIES as f64).max(1e-6) as f32,
            entering,
        }
    }

    /// The fraction of light that passes the coat at the cosine `cos` in `[0, 1]`.
    fn passes(&self, cos: f32) -> f32 {
        let x = cos.clamp(0.0, 1.0) * (ENTRIES - 1) as f32;
        let i = (x as usize).min(ENTRIES - 2);
        let t = x - i as f32;
        self.transmittance[i] * (1.0 - t) + self.transmittance[i + 1] * t
    }

    fn value(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> Rgb {
        let Some(m) = half_vector(wi, wo) else { return Rgb::ZERO };
        let fresnel = fresnel::dielectric(wi.dot(m), self.coat.eta).reflectance;
        let specular = reflected_pdf(&self.facets, wi, m) * self.facets.g1(wo, m) * fresnel;
        let diffuse = FRAC_1_PI * wo.z * self.passes(wi.z) * self.passes(wo.z);
        self.coat.specular(place) * specular + self.coat.diffuse(place, self.escaping) * diffuse
    }
}

/// The fraction of light from a direction with this cosine that the interface reflects or, with `refracted`,
/// lets through, scattered once: an integral over the numbers that choose a visible normal.
fn directional(
    facets: &Microfacets,
    cos: f32,
    eta: f32,
    refracted: bool,
    rule: &[(f64, f64)],
) -> f64 {
    let wi = Vec3A::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let mut sum = 0.0;
    for (x, weight_x) in rule {
        for (y, weight_y) in rule {
            let u = Vec2::new(0.5 + 0.5 * *x as f32, 0.5 + 0.5 * *y as f32);
            let m = facets.sample_visible(wi, u);
            let cos_i = wi.dot(m);
            let f = fresnel::dielectric(cos_i, eta);
            let (wo, fraction) = if refracted {
                (m * (cos_i / f.eta + f.cos_t) - wi / f.eta, 1.0 - f.reflectance)
            } else {
                (m * (2.0 * cos_i) - wi, f.reflectance)
            };
            if (wo.z < 0.0) == refracted {
                sum += f64::from(facets.g1(wo, m) * fraction) * weight_x * weight_y * 0.25;
            }
        }
    }
    sum
}

impl Bsdf for RoughPlastic {
    fn eval(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> Rgb {
        self.value(place, wi, wo)
    }

    fn pdf(&self, _place: &Place, wi: Vec3A, wo: Vec3A) -> f32 {
        let Some(m) = half_vector(wi, wo) else { return 0.0 };
        let specular = self.coat.specular_probability(1.0 - self.passes(wi.z));
        specular * reflected_pdf(&self.facets, wi, m)
            + (1.0 - specular) * warp::square_to_cosine_hemisphere_pdf(wo.into())
    }

    fn sample(&self, place: &Place, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        if wi.z <= 0.0 {
            return None;
        }
        let probability = self.coat.specular_probability(1.0 - self.passes(wi.z));
        let (specular, rest) = choose(probability, u.x);
        let u = Vec2::new(rest, u.y);
        let wo = if specular {
            reflect(wi, self.facets.sample_visible(wi, u))?
        } else {
            Vec3A::from(warp::square_to_cosine_hemisphere(u.into()))
        };
        // Both lobes may send light there.
        let pdf = self.pdf(place, wi, wo);
        (pdf > 0.0 && pdf.is_finite()).then(|| BsdfSample {
            wo,
            weight: self.value(place, wi, wo) / pdf,
            pdf,
            lobe: Lobe::Smooth,
            eta: 1.0,
        })
    }

    fn flags(&self) -> Flags {
        self.coat.flags(Flags::SMOOTH)
    }

    fn albedo(&self, place: &Place, wi: Vec3A) -> Rgb {
        if wi.z <= 0.0 {
            return Rgb::ZERO;
        }
        let passes = self.passes(wi.z);
        self.coat.specular(place) * (1.0 - passes)
            + self.coat.diffuse(place, self.escaping) * (passes * self.entering)
    }

    fn interface(&self) -> Option<f32> {
        Some(1.0)
    }
}
