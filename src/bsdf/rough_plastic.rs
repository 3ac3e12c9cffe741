//! Rough plastic.

use std::f32::consts::FRAC_1_PI;

use rayon::prelude::*;

use super::microfacet::{Distribution, Microfacets, Roughness};
use super::plastic::Coat;
use super::rough_conductor::{half_vector, reflected_pdf};
use super::{Flags, Material, Place, Scattered, choose, fresnel, is_usable, reflect};
use crate::math::real::{Lanes, Level, Real, Simd, Task, f32x8};
use crate::math::special::gauss_legendre;
use crate::math::vector::{Vec2, Vec3};
use crate::math::warp;

/// A diffuse base under a rough dielectric coat; one-sided.
#[derive(Clone, Debug)]
pub struct RoughPlastic {
    coat: Coat,
    roughness: Roughness,
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
    /// Plastic with this coat, whose roughness is `alpha` in all directions; see [`Roughness::new`].
    #[must_use]
    pub fn new(coat: Coat, distribution: Distribution, alpha: f32) -> Self {
        let roughness = Roughness::new(distribution, alpha);
        let level = Level::detect();
        let cosines: Vec<f32> =
            (0..ENTRIES).map(|i| (i as f32 / (ENTRIES - 1) as f32).max(1e-6)).collect();
        let scattered = |eta: f32, refracted: bool| -> Vec<f64> {
            // The integrand has a kink where total reflection begins.
            let rule = gauss_legendre(if eta > 1.0 { 32 } else { 96 });
            let (nodes, _) = rule.as_chunks::<LANES>();
            let directional =
                |&cos: &f32| Directional { distribution, alpha, cos, eta, refracted, nodes };
            cosines.par_iter().map(|cos| level.run(directional(cos))).collect()
        };
        let entering = fresnel::dielectric_mean_transmittance(coat.eta);
        let transmittance = scattered(coat.eta, true);
        let thrown_back = scattered(1.0 / coat.eta, false);
        let sum: f64 = thrown_back.iter().zip(&cosines).map(|(r, &cos)| r * f64::from(cos)).sum();
        Self {
            coat,
            roughness,
            transmittance: transmittance.into_iter().map(|t| t as f32).collect(),
            // Never quite nothing, which rounding could make it.
            escaping: (1.0 - 2.0 * sum / ENTRIES as f64).max(1e-6) as f32,
            entering,
        }
    }

    /// Plastic with a mixture of the tables of others, each with its weight: as good as its own, where theirs are near.
    #[must_use]
    pub(crate) fn mixed(
        coat: Coat,
        distribution: Distribution,
        alpha: f32,
        parts: &[(f32, &Self)],
    ) -> Self {
        let of_all = |value: &dyn Fn(&Self) -> f32| -> f32 {
            parts.iter().map(|(weight, plastic)| weight * value(plastic)).sum()
        };
        Self {
            entering: fresnel::dielectric_mean_transmittance(coat.eta),
            coat,
            roughness: Roughness::new(distribution, alpha),
            transmittance: (0..ENTRIES).map(|i| of_all(&|p| p.transmittance[i])).collect(),
            escaping: of_all(&|p| p.escaping),
        }
    }

    /// The same with another coat of the same index, which has the same tables: they take hundredths of a second to compute.
    #[must_use]
    pub fn with_coat(&self, coat: Coat) -> Self {
        assert!(coat.eta == self.coat.eta, "the tables are for one index");
        Self { coat, ..self.clone() }
    }

    /// The fraction of light that passes the coat at the cosine `cos` in `[0, 1]`.
    #[inline(always)]
    fn passes<R: Real>(&self, cos: R) -> R {
        let x = cos.clamp(0.0, 1.0) * (ENTRIES - 1) as f32;
        // Of NaN the last, too.
        let first = x.floor().min((ENTRIES - 2) as f32);
        let entry = |offset: usize| {
            R::from_fn(cos.token(), |lane| self.transmittance[first.lane(lane) as usize + offset])
        };
        let t = x - first;
        entry(0) * t.one_minus() + entry(1) * t
    }

    /// The probability of a specular sample as seen from `wi`.
    #[inline(always)]
    fn specular_probability<R: Real>(&self, wi: Vec3<R>) -> R {
        self.coat.specular_probability(self.passes(wi.z).one_minus())
    }
}

/// Nodes of a quadrature that are taken at once.
const LANES: usize = 8;

/// The fraction of light from a direction with this cosine that the interface reflects or, with `refracted`,
/// lets through, scattered once: an integral over the numbers that choose a visible normal.
struct Directional<'a> {
    distribution: Distribution,
    alpha: f32,
    cos: f32,
    eta: f32,
    refracted: bool,
    /// Nodes and weights from -1 to 1, the same for both numbers.
    nodes: &'a [[(f64, f64); LANES]],
}

impl Directional<'_> {
    #[inline(always)]
    fn integral<R: Real>(&self, token: R::Token) -> f64 {
        let Self { distribution, alpha, cos, eta, refracted, nodes } = *self;
        let splat = |value: f32| R::splat(token, value);
        let facets = Microfacets::new(distribution, Vec2::new(splat(alpha), splat(alpha)));
        let wi = Vec3::new(splat((1.0 - cos * cos).sqrt()), splat(0.0), splat(cos));
        let number = |x: f64| 0.5 + 0.5 * x as f32;
        let mut sum = 0.0;
        for (x, weight_x) in nodes.as_flattened() {
            for eight in nodes {
                let y = R::from_fn(token, |lane| number(eight[lane].0));
                let m = facets.sample_visible(wi, Vec2::new(splat(number(*x)), y));
                let cos_i = wi.dot(m);
                let f = fresnel::dielectric(cos_i, eta);
                let (wo, fraction) = if refracted {
                    (m * (cos_i / f.eta + f.cos_t) - wi / f.eta, f.reflectance.one_minus())
                } else {
                    (reflect(wi, m), f.reflectance)
                };
                let below = wo.z.lt(0.0);
                let counts = if refracted { below } else { !below };
                let part = R::select(counts, facets.g1(wo, m) * fraction, 0.0);
                for (lane, (_, weight_y)) in eight.iter().enumerate() {
                    sum += f64::from(part.lane(lane)) * weight_x * weight_y * 0.25;
                }
            }
        }
        sum
    }
}

impl Task for Directional<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> f64 {
        self.integral::<f32x8<S>>(simd)
    }
}

impl Material for RoughPlastic {
    #[inline(always)]
    fn evaluate<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, wo: Vec3<R>) -> (Vec3<R>, R) {
        let (m, exists) = half_vector(wi, wo);
        let facets = self.roughness.at(place);
        let fresnel = fresnel::dielectric(wi.dot(m), self.coat.eta).reflectance;
        let mirrored = reflected_pdf(&facets, wi, m);
        let specular = mirrored * facets.g1(wo, m) * fresnel;
        let diffuse = wo.z * FRAC_1_PI * self.passes(wi.z) * self.passes(wo.z);
        let value = self.coat.specular(place) * specular
            + self.coat.diffuse(place, self.escaping) * diffuse;
        let probability = self.specular_probability(wi);
        let pdf = probability * mirrored
            + probability.one_minus() * warp::square_to_cosine_hemisphere_pdf(wo);
        (value.only_where(exists), R::select(exists, pdf, 0.0))
    }

    #[inline(always)]
    fn sample<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, u: Vec2<R>) -> Scattered<R> {
        let (specular, rest) = choose(self.specular_probability(wi), u.x);
        let u = Vec2::new(rest, u.y);
        let m = self.roughness.at(place).sample_visible(wi, u);
        let (mirrored, reflects) = reflect(wi, m).try_normalize();
        let wo = Vec3::select(specular, mirrored, warp::square_to_cosine_hemisphere(u));
        // Both lobes may send light there.
        let (value, pdf) = self.evaluate(place, wi, wo);
        let exists = is_usable(pdf) & (reflects | !specular);
        Scattered::smooth(exists, wo, value / pdf, pdf)
    }

    fn flags(&self) -> Flags {
        self.coat.flags(Flags::SMOOTH)
    }

    fn albedo(&self, place: &Place, wi: Vec3) -> Vec3 {
        let passes = self.passes(wi.z);
        let diffuse = self.coat.diffuse(place, self.escaping) * (passes * self.entering);
        (self.coat.specular(place) * (1.0 - passes) + diffuse).only_where(wi.z > 0.0)
    }

    fn interface(&self) -> Option<f32> {
        Some(1.0)
    }
}
