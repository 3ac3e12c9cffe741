//! Special functions.

/// The error function, to the last bit or two.
#[must_use]
pub fn erf(x: f32) -> f32 {
    libm::erff(x)
}

/// The inverse of [`erf`] on (−1, 1), with a relative error below 1e-6.
///
/// Giles, "Approximating the erfinv Function" (GPU Computing Gems Jade 2011), single precision: a
/// polynomial in −ln(1 − x²) for the middle, one in its root for both ends.
#[must_use]
pub fn erf_inverse(x: f32) -> f32 {
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
    let w = -((1.0 - x) * (1.0 + x)).ln();
    let (coefficients, t) = if w < 5.0 { (&MIDDLE, w - 2.5) } else { (&ENDS, w.sqrt() - 3.0) };
    coefficients.iter().fold(0.0, |sum, c| sum * t + c) * x
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
