//! Special functions.

use super::real::{Real, polynomial};

/// The error function, within 2 ulp.
///
/// Polynomials of least largest relative error, 2e-8: of (erf x − x) / x in x² in the middle, beyond of
/// ln(1 − erf x) / x in x.
#[inline(always)]
#[must_use]
pub fn erf<R: Real>(x: R) -> R {
    const MIDDLE: [f32; 6] = [
        -5.953_728e-4,
        4.985_937_4e-3,
        -2.676_171_6e-2,
        1.128_168_26e-1,
        -3.761_248e-1,
        1.283_791_5e-1,
    ];
    const ENDS: [f32; 6] = [
        2.136_450_8e-4,
        -3.212_145_3e-3,
        2.288_092_1e-2,
        -1.052_476_8e-1,
        -6.357_291_3e-1,
        -1.128_511_2,
    ];
    // Beyond 4 it rounds to 1.
    let t = x.abs().clamp(0.0, 4.0);
    let middle = polynomial(x * x, MIDDLE) * x + x;
    let end = (polynomial(t, ENDS) * t).exp().one_minus().copysign(x);
    R::select(t.lt(0.93), middle, end)
}

/// The inverse of [`erf`] on (−1, 1), with a relative error below 1e-6.
///
/// Giles, "Approximating the erfinv Function" (GPU Computing Gems Jade 2011), single precision: a
/// polynomial in −ln(1 − x²) for the middle, one in its root for both ends.
#[inline(always)]
#[must_use]
pub fn erf_inverse<R: Real>(x: R) -> R {
    const MIDDLE: [f32; 9] = [
        2.810_226_4e-8,
        3.432_739_4e-7,
        -3.523_387_6e-6,
        -4.391_506_5e-6,
        2.185_808_7e-4,
        -1.253_725_e-3,
        -4.177_681_6e-3,
        2.466_407_3e-1,
        1.501_409_4,
    ];
    const ENDS: [f32; 9] = [
        -2.002_142_6e-4,
        1.009_505_6e-4,
        1.349_343_2e-3,
        -3.673_428_4e-3,
        5.739_507_7e-3,
        -7.622_461e-3,
        9.438_870_5e-3,
        1.001_674,
        2.832_976_8,
    ];
    let w = -(x.one_minus() * (x + 1.0)).ln();
    let middle = w.lt(5.0);
    let t = R::select(middle, w - 2.5, w.sqrt() - 3.0);
    let mut sum = R::splat(x.token(), 0.0);
    for (of_middle, of_ends) in MIDDLE.into_iter().zip(ENDS) {
        sum = sum * t + R::select(middle, R::splat(x.token(), of_middle), of_ends);
    }
    sum * x
}

/// Nodes in (−1, 1) and weights of the rule of Gauss and Legendre with `count` points, which integrates
/// polynomials up to degree 2·count − 1 exactly. The nodes are zeros of the Legendre polynomial, found by
/// Newton's method from Chebyshev's (Abramowitz and Stegun, 25.4.29 and 22.16.6).
#[must_use]
pub fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    // The polynomial and its derivative by the recurrence in its degree.
    let legendre = |x: f64| {
        let (mut before, mut p) = (1.0, x);
        for degree in 2..=count {
            let n = degree as f64;
            (before, p) = (p, ((2.0 * n - 1.0) * x * p - (n - 1.0) * before) / n);
        }
        (p, count as f64 * (x * p - before) / (x * x - 1.0))
    };
    let node = |i: usize| {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
        // Quadratic convergence from within 1e-2.
        for _ in 0..6 {
            let (p, slope) = legendre(x);
            x -= p / slope;
        }
        let (_, slope) = legendre(x);
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    if count == 1 { vec![(0.0, 2.0)] } else { (0..count).map(node).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against f64, at every 641st of all numbers.
    #[test]
    fn error_function_is_accurate() {
        let mut worst = (0.0, 0.0);
        for x in (0..=u32::MAX).step_by(641).map(f32::from_bits).filter(|x| !x.is_nan()) {
            let (found, exact) = (erf(x), statrs::function::erf::erf(x.into()));
            // Relative to the unit in the last place of the result.
            let ulp = f64::from((exact as f32).abs()) * f64::from(f32::EPSILON);
            let error = (f64::from(found) - exact).abs() / ulp.max(f64::from(f32::MIN_POSITIVE));
            if error > worst.0 {
                worst = (error, x);
            }
        }
        assert!(worst.0 < 1.6, "{worst:?}");
        assert_eq!([f32::INFINITY, f32::NEG_INFINITY, 0.0].map(erf), [1.0, -1.0, 0.0]);
        assert!(erf(f32::NAN).is_nan());
    }

    #[test]
    fn inverse_undoes_the_error_function() {
        for i in -380..=380 {
            let x = i as f32 / 100.0;
            let y = erf(x);
            if y.abs() < 1.0 {
                // A change of y by half an ulp moves x by so much.
                let slope = std::f32::consts::FRAC_2_SQRT_PI * (-x * x).exp();
                let tolerance = 2e-6 * x.abs() + f32::EPSILON / slope;
                assert!((erf_inverse(y) - x).abs() <= tolerance, "{x}: {}", erf_inverse(y));
            }
        }
        assert_eq!(erf_inverse(0.0), 0.0);
    }

    /// Monomials up to the degree that the rule is exact for.
    #[test]
    fn gauss_legendre_is_exact_for_polynomials() {
        for count in [1, 2, 5, 32, 128] {
            let rule = gauss_legendre(count);
            for degree in [0, 1, 2 * count - 2, 2 * count - 1] {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                let exact = if degree % 2 == 0 { 2.0 / (degree as f64 + 1.0) } else { 0.0 };
                assert!((sum - exact).abs() < 1e-13, "{count} points, degree {degree}: {sum}");
            }
        }
    }
}
