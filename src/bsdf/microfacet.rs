//! Rough surfaces as many small mirrors: how their normals are distributed, and how they hide each other.
//!
//! All directions are local and above the surface (z > 0) unless said otherwise. Heitz, "Understanding the
//! Masking-Shadowing Function in Microfacet-Based BRDFs" (JCGT 2014), is where the equations stand.

use std::f32::consts::{FRAC_1_PI, FRAC_2_SQRT_PI, PI};

use glam::{Vec2, Vec3A};

use super::{Flags, Needs, Place};
use crate::math::special::{erf, erf_inverse};
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
    pub(super) fn at(&self, place: &Place) -> Microfacets {
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

/// The distribution of normals at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microfacets {
    distribution: Distribution,
    /// Along x and y.
    alpha: Vec2,
}

impl Microfacets {
    /// `alpha` along x and y; see [`LEAST_ALPHA`].
    #[must_use]
    pub fn new(distribution: Distribution, alpha: Vec2) -> Self {
        // NaN becomes the least too.
        Self { distribution, alpha: alpha.max(Vec2::splat(LEAST_ALPHA)) }
    }

    /// D(m): area of normals `m` per solid angle and area of the surface, in sr⁻¹.
    #[must_use]
    pub fn d(&self, m: Vec3A) -> f32 {
        if m.z <= 0.0 {
            return 0.0;
        }
        let slopes = (m.truncate() / self.alpha).length_squared();
        let scale = FRAC_1_PI / (self.alpha.x * self.alpha.y);
        let cos2 = m.z * m.z;
        match self.distribution {
            // Where the square underflows, so does the exponential, and much earlier.
            Distribution::Beckmann if cos2 * cos2 < f32::MIN_POSITIVE => 0.0,
            Distribution::Beckmann => scale * (-slopes / cos2).exp() / (cos2 * cos2),
            // Without tan θ or 1 − cos²θ, which lose all digits for narrow lobes.
            Distribution::Ggx => scale / (slopes + cos2).powi(2),
        }
    }

    /// G₁(v, m): the visible fraction of normals `m` as seen from `v`, both on either side; 0 if `m` is seen
    /// from behind.
    #[must_use]
    pub fn g1(&self, v: Vec3A, m: Vec3A) -> f32 {
        if v.dot(m) * v.z > 0.0 { self.g1_unmasked(v) } else { 0.0 }
    }

    fn g1_unmasked(&self, v: Vec3A) -> f32 {
        let stretched = (v.truncate() * self.alpha).length_squared();
        if stretched == 0.0 {
            return 1.0;
        }
        match self.distribution {
            // 1 / (1 + Λ) with Heitz 2014, equation 66. Not the fit of Walter et al. 2007: the density of
            // visible normals, which has G₁ as a factor, would not integrate to 1.
            Distribution::Beckmann => {
                let a = v.z.abs() / stretched.sqrt();
                let lambda = 0.5 * (erf(a) - 1.0 + (-a * a).exp() * FRAC_1_SQRT_PI / a);
                1.0 / (1.0 + lambda.max(0.0))
            }
            // 2 / (1 + √(1 + tan²)), multiplied by the cosine so that nothing is divided by it.
            Distribution::Ggx => {
                let z = v.z.abs();
                2.0 * z / (z + (z * z + stretched).sqrt())
            }
        }
    }

    /// Density of [`Microfacets::sample_visible`] divided by |wi·m|, in sr⁻¹: D·G₁(wi)/cosθᵢ.
    #[must_use]
    pub fn visible_pdf_over_cosine(&self, wi: Vec3A, m: Vec3A) -> f32 {
        self.d(m) * self.g1(wi, m) / wi.z
    }

    /// A normal, chosen by the area that is seen from `wi`: density G₁(wi, m)·|wi·m|·D(m)/cosθᵢ.
    ///
    /// For GGX, Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps" (2023), listing 3.
    /// For Beckmann, slopes of the surface stretched to roughness 1 (Heitz and d'Eon 2014), the first
    /// by inverting its distribution (Jakob, "An Improved Visible Normal Sampling Routine for the
    /// Beckmann Distribution", 2014).
    #[must_use]
    pub fn sample_visible(&self, wi: Vec3A, u: Vec2) -> Vec3A {
        let stretched = (wi.truncate() * self.alpha).extend(wi.z).normalize();
        match self.distribution {
            Distribution::Ggx => {
                let z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z;
                let (sin, cos) = (2.0 * PI * u.x).sin_cos();
                let radius = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
                let half = Vec2::new(radius * cos, radius * sin) + stretched.truncate();
                unit(half * self.alpha, z + stretched.z)
            }
            Distribution::Beckmann => {
                let across = stretched.truncate();
                let sin = across.length();
                let azimuth = if sin > 0.0 { across / sin } else { Vec2::X };
                let slopes = beckmann_visible_slopes(stretched.z, sin, u);
                unit(-azimuth.rotate(slopes) * self.alpha, 1.0)
            }
        }
    }
}

fn unit(xy: Vec2, z: f32) -> Vec3A {
    Vec3A::from(xy.extend(z.max(0.0))).try_normalize().unwrap_or(Vec3A::Z)
}

/// Slopes of a Beckmann surface of roughness 1 as seen under the angle with this cosine and sine, towards the
/// viewer and across.
fn beckmann_visible_slopes(cos: f32, sin: f32, u: Vec2) -> Vec2 {
    let inside = |u: f32| u.clamp(1e-6, 1.0 - 1e-6);
    let (u0, across) = (inside(u.x), erf_inverse(2.0 * inside(u.y) - 1.0));
    if sin < 1e-4 * cos {
        // From above all slopes are visible alike; below, tan and cot would be far apart.
        return Vec2::new(erf_inverse(2.0 * u0 - 1.0), across);
    }
    let (tan, cot) = (sin / cos, cos / sin);
    // In x = erf(slope), from −1 to where the facets turn away from the viewer.
    let largest = erf(cot);
    let total = 1.0 + largest + FRAC_1_SQRT_PI * tan * (-cot * cot).exp();
    let target = u0 * total;
    // The distribution function rises from 0 to `total`, so the root is enclosed; Newton's step is taken
    // where it stays inside.
    let (mut low, mut high) = (-1.0, largest);
    let mut x = largest - (largest + 1.0) * erf((-u0.ln()).sqrt());
    for _ in 0..10 {
        if !(x > low && x < high) {
            x = 0.5 * (low + high);
        }
        let slope = erf_inverse(x);
        let excess = 1.0 + x + FRAC_1_SQRT_PI * tan * (-slope * slope).exp() - target;
        if excess > 0.0 {
            high = x;
        } else {
            low = x;
        }
        if excess.abs() < 1e-5 * total {
            break;
        }
        x -= excess / (1.0 - slope * tan);
    }
    Vec2::new(erf_inverse(x.clamp(-1.0 + 1e-6, 1.0 - 1e-6)), across)
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
                let facets = Microfacets::new(distribution, Vec2::new(alpha, 2.0 * alpha));
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
                        sum += f64::from(facets.d(m.as_vec3a())) * cos * area;
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
            let facets = Microfacets::new(Distribution::Ggx, Vec2::splat(alpha));
            assert_eq!(facets.alpha, Vec2::splat(LEAST_ALPHA));
        }
    }
}
