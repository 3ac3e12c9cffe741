//! Fresnel reflectance for unpolarised light at a smooth interface.

use crate::math::real::{Double, Float, Lanes, Lift, Real};
use crate::math::special::gauss_legendre;
use crate::math::vector::Vec3;

/// What a dielectric interface does to light, in each lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DielectricFresnel<R = f32> {
    /// Reflected fraction of the power.
    pub reflectance: R,
    /// Cosine of the refracted direction, on the other side from `cos_i`: negative where that is
    /// positive. 0 at total internal reflection.
    pub cos_t: R,
    /// Index of the side of the refracted direction over that of the incident one.
    pub eta: R,
}

/// Reflection and refraction at an interface whose index on the side of −z over that on the side of
/// +z is `eta`, for a direction with cosine `cos_i` of either sign.
///
/// Born and Wolf, *Principles of Optics*, section 1.5.2; Snell's law in f64, because sin² of the
/// refracted angle is rounded to either side of 1 near total reflection.
#[inline(always)]
#[must_use]
pub fn dielectric<R: Real>(cos_i: R, eta: impl Lift<R>) -> DielectricFresnel<R> {
    let (above, eta) = (cos_i.ge(0.0), eta.lift(cos_i.token()).widen());
    let one = R::Double::splat(cos_i.token(), 1.0);
    let eta_it = R::Double::select(above, eta, one / eta);
    let cos_i = cos_i.abs().min(1.0).widen();
    let cos_t_squared = one - (one - cos_i * cos_i) / (eta_it * eta_it);
    let total = cos_t_squared.le(0.0);
    let cos_t = cos_t_squared.sqrt();
    let s = (cos_i - eta_it * cos_t) / (cos_i + eta_it * cos_t);
    let p = (eta_it * cos_i - cos_t) / (eta_it * cos_i + cos_t);
    // With eta 1 both differences are 0 but for the rounding of cos_t.
    let partial = R::Double::select(eta_it.eq(1.0), 0.0, (s * s + p * p) * 0.5);
    DielectricFresnel {
        reflectance: R::select(total, 1.0, partial.narrow()),
        cos_t: R::select(total, 0.0, R::Double::select(above, -cos_t, cos_t).narrow()),
        eta: eta_it.narrow(),
    }
}

/// The fraction of diffuse light that passes the interface: 1 − 2∫F(μ)μ dμ with the reflectance F of
/// [`dielectric`].
///
/// From the denser side it follows from the other one, since as much light crosses in both directions:
/// (1 − F₋) η² = 1 − F₊ (Duntley 1942). With fits in place of the integral, white plastic would not keep the
/// energy.
#[must_use]
pub fn dielectric_mean_transmittance(eta: f32) -> f32 {
    let denser = eta.max(1.0 / eta);
    // With μ = t² the nodes crowd at grazing angles, where F is steep.
    let mean: f64 = gauss_legendre(128)
        .into_iter()
        .map(|(x, weight)| {
            let t = 0.5 + 0.5 * x;
            let passing = 1.0 - f64::from(dielectric((t * t) as f32, denser).reflectance);
            2.0 * passing * t.powi(3) * weight
        })
        .sum();
    let denser = f64::from(denser);
    (if eta < 1.0 { mean / (denser * denser) } else { mean }) as f32
}

/// Reflectance of a conductor with complex index `eta + i k` per channel, seen from vacuum at the
/// cosine `cos_i` ≥ 0.
///
/// The exact equations for unpolarised light as in Lagarde, "Memo on Fresnel equations" (2013).
#[inline(always)]
#[must_use]
pub fn conductor<R: Real>(cos_i: R, eta: Vec3<R>, k: Vec3<R>) -> Vec3<R> {
    // In f64, where the square of the flattest cosine is not 0.
    let cos = cos_i.clamp(0.0, 1.0).widen();
    let cos2 = cos * cos;
    let sin2 = R::Double::splat(cos_i.token(), 1.0) - cos2;
    let (eta, k, angle) = (eta.widen(), k.widen(), [cos, cos2, sin2]);
    let x = conductor_channel(angle, eta.x, k.x);
    let y = conductor_channel(angle, eta.y, k.y);
    let z = conductor_channel(angle, eta.z, k.z);
    Vec3::new(x, y, z).narrow()
}

/// One channel of [`conductor`] for the cosine, its square and that of the sine.
#[inline(always)]
fn conductor_channel<D: Double>([cos, cos2, sin2]: [D; 3], eta: D, k: D) -> D {
    let t0 = eta * eta - k * k - sin2;
    let a2_plus_b2 = (t0 * t0 + eta * eta * k * k * 4.0).sqrt();
    let a2 = (a2_plus_b2 + t0) * 0.5;
    let a = D::select(a2.gt(0.0), a2, 0.0).sqrt();
    let t1 = a2_plus_b2 + cos2;
    let t2 = cos * a * 2.0;
    let r_s = (t1 - t2) / (t1 + t2);
    let t3 = cos2 * a2_plus_b2 + sin2 * sin2;
    let t4 = t2 * sin2;
    // Both are 0 for an index of 0 seen straight on, where the two polarisations are one.
    let r_p = D::select((t3 + t4).gt(0.0), r_s * (t3 - t4) / (t3 + t4), r_s);
    (r_s + r_p) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(value: f32) -> Vec3 {
        Vec3::new(value, value, value)
    }

    /// 2∫F(μ)μ dμ has a closed form for dielectrics (Walsh 1926); the values to six digits.
    #[test]
    fn dielectric_means_are_known() {
        for (eta, expected) in
            [(1.5, 0.091_778), (1.0 / 1.5, 0.596_346), (1.33, 0.065_931), (2.4, 0.210_181)]
        {
            let n = 200_000;
            let mean: f64 = (0..n)
                .map(|i| {
                    let mu = (f64::from(i) + 0.5) / f64::from(n);
                    2.0 * mu * f64::from(dielectric(mu as f32, eta).reflectance) / f64::from(n)
                })
                .sum();
            assert!((mean - expected).abs() < 1e-6, "eta {eta}: {mean}");
        }
        let known = [(1.5, 0.091_778), (1.0 / 1.5, 0.596_346), (1.33, 0.065_931), (2.4, 0.210_181)];
        // Walsh's formula with 50 digits.
        for (eta, exact) in known.into_iter().chain([(1.0, 0.0), (1000.0, 0.994720)]) {
            let passing = dielectric_mean_transmittance(eta);
            assert!((1.0 - passing - exact).abs() < 1e-6, "eta {eta}: {passing}");
        }
        // cos 60 degrees at 1.5.
        assert!((dielectric(0.5, 1.5).reflectance - 0.089_187).abs() < 1e-6);
    }

    /// At the critical angle of 1.5 → 1, three ulp to either side: F rises to 1 and stays a number.
    #[test]
    fn critical_angle_is_approached_without_nan() {
        let critical = 0.745_355_96f32;
        let mut previous = 0.0;
        for step in (-3i32..=3).rev() {
            let cos = f32::from_bits((critical.to_bits() as i32 + step) as u32);
            let f = dielectric(cos, 1.0 / 1.5);
            assert!(f.reflectance >= 0.995 && f.reflectance <= 1.0, "{step}: {f:?}");
            assert!(f.reflectance >= previous, "{step}: not monotonic");
            previous = f.reflectance;
        }
        assert_eq!(previous, 1.0);
    }

    #[test]
    fn equal_indices_do_nothing() {
        for cos in [1.0, 0.3, 1e-4, -1e-4, -1.0] {
            let f = dielectric(cos, 1.0);
            assert_eq!(f.reflectance, 0.0);
            assert!((f.cos_t + cos).abs() < 1e-7);
        }
    }

    /// Whatever the index and the angle, the reflectance is a number from 0 to 1; 4 roundings of f64 and one
    /// of f32 may put it above.
    #[test]
    fn conductors_reflect_at_most_all_light() {
        let indices = [0.0, 1e-30, 1e-3, 1.0, 1.5, 1e3, 1e18, f32::MAX];
        for eta in indices {
            for k in indices {
                for cos in [1.0, 0.999_999_94, 0.5, 1e-6, 1e-20, f32::MIN_POSITIVE] {
                    let r = conductor(cos, grey(eta), grey(k)).x;
                    assert!((0.0..=1.0 + f32::EPSILON).contains(&r), "{eta} + {k}i at {cos}: {r}");
                }
            }
        }
        assert_eq!(conductor(1.0, grey(0.0), grey(0.0)), grey(1.0));
    }

    /// Without absorption a conductor is a dielectric.
    #[test]
    fn conductor_without_absorption_is_a_dielectric() {
        for cos in [1.0, 0.7, 0.2, 0.01] {
            let c = conductor(cos, grey(1.5), grey(0.0)).x;
            let d = dielectric(cos, 1.5).reflectance;
            assert!((c - d).abs() < 1e-6, "{cos}: {c} {d}");
        }
    }
}
