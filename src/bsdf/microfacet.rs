//! Rough surfaces as many small mirrors: how their normals are distributed, and how they hide each other.
//!
//! All directions are local and above the surface (z > 0) unless said otherwise. Heitz, "Understanding the
//! Masking-Shadowing Function in Microfacet-Based BRDFs" (JCGT 2014), is where the equations stand.

use std::f32::consts::{FRAC_1_PI, FRAC_2_SQRT_PI, PI};

use super::{Flags, Needs, Place};
use crate::math::real::{Lanes, Mask, Real};
use crate::math::special::{erf, erf_inverse};
use crate::math::vector::{Vec2, Vec3};
use crate::texture::Textured;

/// Roughness below this is raised to it: the lobe would be narrower than f32 directions can tell.
pub const LEAST_ALPHA: f32 = 1e-4;

const FRAC_1_SQRT_PI: f32 = 0.5 * FRAC_2_SQRT_PI;

/// How the normals of a rough surface are distributed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distribution {
    /// A Gaussian of the slopes (Beckmann and Spizzichino 1963).
    Beckmann,
    /// Long tails: Trowbridge and Reitz 1975; GGX in Walter et al. 2007.
    Ggx,
}

/// The roughness of a surface.
#[derive(Clone, Debug)]
pub struct Roughness {
    distribution: Distribution,
    /// Along the tangent and across; `None` for the same.
    alpha: (Textured<f32>, Option<Textured<f32>>),
}

impl Roughness {
    /// The same roughness in all directions: `alpha` is √2 times the root mean square slope.
    #[must_use]
    pub fn new(distribution: Distribution, alpha: impl Into<Textured<f32>>) -> Self {
        Self { distribution, alpha: (alpha.into(), None) }
    }

    /// Roughness of its own along the first texture coordinate, and across.
    #[must_use]
    pub fn anisotropic(
        distribution: Distribution,
        alpha_u: impl Into<Textured<f32>>,
        alpha_v: impl Into<Textured<f32>>,
    ) -> Self {
        Self { distribution, alpha: (alpha_u.into(), Some(alpha_v.into())) }
    }

    /// The distribution at a place.
    #[inline(always)]
    pub(super) fn at<R: Real>(&self, place: &Place<R>) -> Microfacets<R> {
        let u = self.alpha.0.at(place.uv);
        let v = self.alpha.1.as_ref().map_or(u, |alpha| alpha.at(place.uv));
        Microfacets::new(self.distribution, Vec2::new(u, v))
    }

    /// Those of a material of this roughness.
    pub(super) fn flags(&self, flags: Flags) -> Flags {
        let flags = flags.textured(&self.alpha.0);
        if self.alpha.1.is_some() { flags.needing(Needs::Tangents) } else { flags }
    }
}

/// The distribution of normals at a place, in each lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microfacets<R = f32> {
    distribution: Distribution,
    /// Along x and y.
    alpha: Vec2<R>,
}

impl<R: Real> Microfacets<R> {
    /// `alpha` along x and y; see [`LEAST_ALPHA`].
    #[inline(always)]
    #[must_use]
    pub fn new(distribution: Distribution, alpha: Vec2<R>) -> Self {
        // NaN becomes the least too.
        Self { distribution, alpha: alpha.map(|alpha| alpha.max(LEAST_ALPHA)) }
    }

    /// D(m): area of normals `m` per solid angle and area of the surface, in sr⁻¹.
    #[inline(always)]
    #[must_use]
    pub fn d(&self, m: Vec3<R>) -> R {
        let slopes = m.truncate().over(self.alpha).length_squared();
        let scale = R::splat(m.token(), FRAC_1_PI) / (self.alpha.x * self.alpha.y);
        let cos2 = m.z * m.z;
        let d = match self.distribution {
            // Where the square underflows, so does the exponential, and much earlier.
            Distribution::Beckmann => {
                let cos4 = cos2 * cos2;
                R::select(cos4.lt(f32::MIN_POSITIVE), 0.0, scale * (-slopes / cos2).exp() / cos4)
            }
            // Without tan θ or 1 − cos²θ, which lose all digits for narrow lobes.
            Distribution::Ggx => {
                let spread = slopes + cos2;
                scale / (spread * spread)
            }
        };
        R::select(m.z.gt(0.0), d, 0.0)
    }

    /// G₁(v, m): the visible fraction of normals `m` as seen from `v`, both on either side; 0 if `m` is seen
    /// from behind.
    #[inline(always)]
    #[must_use]
    pub fn g1(&self, v: Vec3<R>, m: Vec3<R>) -> R {
        R::select((v.dot(m) * v.z).gt(0.0), self.g1_unmasked(v), 0.0)
    }

    #[inline(always)]
    fn g1_unmasked(&self, v: Vec3<R>) -> R {
        let stretched = v.truncate().times(self.alpha).length_squared();
        let z = v.z.abs();
        let visible = match self.distribution {
            // 1 / (1 + Λ) with Heitz 2014, equation 66. Not the fit of Walter et al. 2007: the density of
            // visible normals, which has G₁ as a factor, would not integrate to 1.
            Distribution::Beckmann => {
                let a = z / stretched.sqrt();
                let lambda = (erf(a) - 1.0 + (-a * a).exp() * FRAC_1_SQRT_PI / a) * 0.5;
                (lambda.max(0.0) + 1.0).recip()
            }
            // 2 / (1 + √(1 + tan²)), multiplied by the cosine so that nothing is divided by it.
            Distribution::Ggx => z * 2.0 / (z + (z * z + stretched).sqrt()),
        };
        R::select(stretched.eq(0.0), 1.0, visible)
    }

    /// Density of [`Microfacets::sample_visible`] divided by |wi·m|, in sr⁻¹: D·G₁(wi)/cosθᵢ.
    #[inline(always)]
    #[must_use]
    pub fn visible_pdf_over_cosine(&self, wi: Vec3<R>, m: Vec3<R>) -> R {
        self.d(m) * self.g1(wi, m) / wi.z
    }

    /// A normal, chosen by the area that is seen from `wi`: density G₁(wi, m)·|wi·m|·D(m)/cosθᵢ.
    ///
    /// For GGX, Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps" (2023), listing 3.
    /// For Beckmann, slopes of the surface stretched to roughness 1 (Heitz and d'Eon 2014), the first
    /// by inverting its distribution (Jakob, "An Improved Visible Normal Sampling Routine for the
    /// Beckmann Distribution", 2014).
    #[inline(always)]
    #[must_use]
    pub fn sample_visible(&self, wi: Vec3<R>, u: Vec2<R>) -> Vec3<R> {
        let stretched = wi.truncate().times(self.alpha).extend(wi.z).normalize();
        match self.distribution {
            Distribution::Ggx => {
                let z = u.y.one_minus() * (stretched.z + 1.0) - stretched.z;
                let (sin, cos) = (u.x * (2.0 * PI)).sin_cos();
                let radius = (z.one_minus() * (z + 1.0)).max(0.0).sqrt();
                let half = Vec2::new(radius * cos, radius * sin) + stretched.truncate();
                unit(half.times(self.alpha), z + stretched.z)
            }
            Distribution::Beckmann => {
                let across = stretched.truncate();
                let sin = across.length();
                let (zero, one) = (R::splat(wi.token(), 0.0), R::splat(wi.token(), 1.0));
                let azimuth = Vec2::select(sin.gt(0.0), across / sin, Vec2::new(one, zero));
                let slopes = beckmann_visible_slopes(stretched.z, sin, u);
                let turned = Vec2::new(
                    azimuth.x * slopes.x - azimuth.y * slopes.y,
                    azimuth.y * slopes.x + azimuth.x * slopes.y,
                );
                unit(-turned.times(self.alpha), one)
            }
        }
    }
}

#[inline(always)]
fn unit<R: Real>(xy: Vec2<R>, z: R) -> Vec3<R> {
    let (zero, one) = (R::splat(z.token(), 0.0), R::splat(z.token(), 1.0));
    let (unit, exists) = xy.extend(z.max(zero)).try_normalize();
    Vec3::select(exists, unit, Vec3::new(zero, zero, one))
}

/// Slopes of a Beckmann surface of roughness 1 as seen under the angle with this cosine and sine, towards the
/// viewer and across.
#[inline(always)]
fn beckmann_visible_slopes<R: Real>(cos: R, sin: R, u: Vec2<R>) -> Vec2<R> {
    const LARGEST: f32 = 1.0 - 1e-6;
    let u = u.map(|u| u.clamp(1e-6, LARGEST));
    // From above all slopes are visible alike; below, tan and cot would be far apart.
    let from_above = sin.lt(cos * 1e-4);
    let (tan, cot) = (sin / cos, cos / sin);
    // In x = erf(slope), from −1 to where the facets turn away from the viewer.
    let largest = erf(cot);
    let total = largest + 1.0 + tan * FRAC_1_SQRT_PI * (-cot * cot).exp();
    let target = u.x * total;
    // The distribution function rises from 0 to `total`, so the root is enclosed; Newton's step is taken
    // where it stays inside.
    let (mut low, mut high) = (R::splat(cos.token(), -1.0), largest);
    let mut x = largest - (largest + 1.0) * erf((-u.x.ln()).sqrt());
    let mut found = from_above;
    for _ in 0..10 {
        let inside = x.gt(low) & x.lt(high);
        x = R::select(inside | found, x, (low + high) * 0.5);
        let slope = erf_inverse(x);
        let excess = x + 1.0 + tan * FRAC_1_SQRT_PI * (-slope * slope).exp() - target;
        let beyond = excess.gt(0.0);
        (low, high) = (R::select(beyond, low, x), R::select(beyond, x, high));
        found |= excess.abs().lt(total * 1e-5);
        if found.all() {
            break;
        }
        x = R::select(found, x, x - excess / (slope * tan).one_minus());
    }
    let x = R::select(from_above, u.x * 2.0 - 1.0, x.clamp(-LARGEST, LARGEST));
    Vec2::new(erf_inverse(x), erf_inverse(u.y * 2.0 - 1.0))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// ∫ D cosθ dω = 1: the projected area of all facets is that of the surface. In steps of log tanθ and of
    /// azimuth, which for functions that vanish at the ends converges faster than any power.
    #[test]
    fn facets_cover_the_surface_once() {
        const STEPS: i32 = 4000;
        const TURNS: i32 = 64;
        for distribution in [Distribution::Beckmann, Distribution::Ggx] {
            for alpha in [1e-4, 1e-3, 1e-2, 0.1, 0.5, 1.0] {
                let facets = Microfacets::<f32>::new(distribution, Vec2::new(alpha, 2.0 * alpha));
                let step = 30.0 / f64::from(STEPS);
                let mut sum = 0.0;
                for i in 0..STEPS {
                    // tanθ from e⁻¹⁵ α to e¹⁵ α.
                    let tan = f64::from(alpha) * (step * f64::from(i) - 15.0).exp();
                    let cos = 1.0 / (1.0 + tan * tan).sqrt();
                    for turn in 0..TURNS {
                        let (sin_phi, cos_phi) =
                            (TAU * f64::from(turn) / f64::from(TURNS)).sin_cos();
                        let m = glam::DVec3::new(cos_phi * tan, sin_phi * tan, 1.0) * cos;
                        // dω = sinθ dθ dφ and dθ = cos²θ dtanθ.
                        let area = tan * cos * cos * cos * tan * step * TAU / f64::from(TURNS);
                        sum += f64::from(facets.d(m.as_vec3().into())) * cos * area;
                    }
                }
                // f32 directions carry 6e-8 / α of the width of the lobe.
                let tolerance = 1e-5 + 2e-7 / f64::from(alpha);
                assert!((sum - 1.0).abs() < tolerance, "{distribution:?} {alpha}: {sum}");
            }
        }
    }

    #[test]
    fn roughness_has_a_least_value() {
        for alpha in [0.0, -1.0, f32::NAN, 1e-5] {
            let facets = Microfacets::<f32>::new(Distribution::Ggx, Vec2::new(alpha, alpha));
            assert_eq!(facets.alpha, Vec2::new(LEAST_ALPHA, LEAST_ALPHA));
        }
    }
}
