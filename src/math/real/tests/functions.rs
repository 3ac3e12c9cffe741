//! Errors of the functions against f64, over numbers of all magnitudes.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use super::*;

/// Every so many of all bit patterns are tried: a prime, so that all ends of the mantissa occur. The errors named
/// below were measured with smaller strides, 1 for the sine up to 2π.
const STRIDE: usize = 641;

/// Units in the last place of f32 that `found` is off by; none if both are too large for f32, or NaN.
fn ulps(found: f32, expected: f64) -> f64 {
    let rounded = expected as f32;
    if found == rounded || found.is_nan() && expected.is_nan() {
        return 0.0;
    }
    let exponent = (rounded.abs().to_bits() >> 23).max(1) as i32 - 150;
    (f64::from(found) - expected).abs() / 2f64.powi(exponent)
}

/// The largest error in ulp over `numbers`, and where.
fn worst(
    numbers: impl Iterator<Item = f32>,
    f: impl Fn(f32) -> f32,
    exact: impl Fn(f64) -> f64,
) -> (f64, f32) {
    numbers.map(|x| (ulps(f(x), exact(x.into())), x)).fold((0.0, 0.0), |worst, this| {
        assert!(!this.0.is_nan(), "{} of {}", f(this.1), this.1);
        if this.0 > worst.0 { this } else { worst }
    })
}

fn all() -> impl Iterator<Item = f32> {
    (0..=u32::MAX).step_by(STRIDE).map(f32::from_bits)
}

fn within(limit: f32) -> impl Iterator<Item = f32> {
    all().filter(move |x| x.abs() <= limit)
}

/// Measured up to 2π: 1.515 and 1.49 ulp; beyond, 7.7e-8.
#[test]
fn sine_and_cosine() {
    let sin = worst(within(TAU), Real::sin, f64::sin);
    let cos = worst(within(TAU), Real::cos, f64::cos);
    assert!(sin.0 < 1.6, "{sin:?}");
    assert!(cos.0 < 1.6, "{cos:?}");
    for x in within(8192.0) {
        let (sin, cos) = Real::sin_cos(x);
        let exact = f64::from(x).sin_cos();
        assert!((f64::from(sin) - exact.0).abs() < f64::from(f32::EPSILON), "{x}: {sin}");
        assert!((f64::from(cos) - exact.1).abs() < f64::from(f32::EPSILON), "{x}: {cos}");
    }
    assert_eq!(Real::sin(0.0).to_bits(), 0.0f32.to_bits());
    assert_eq!(Real::sin(-0.0).to_bits(), (-0.0f32).to_bits());
    assert_eq!((Real::cos(0.0), Real::cos(-0.0)), (1.0, 1.0));
    for x in [f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 8193.0, f32::MAX] {
        assert!(Real::sin(x).is_nan() && Real::cos(x).is_nan(), "{x}");
    }
}

/// Measured: 0.98 ulp.
#[test]
fn exponential() {
    let exp = worst(all(), Real::exp, f64::exp);
    assert!(exp.0 < 1.0, "{exp:?}");
    assert_eq!([0.0, -0.0].map(Real::exp), [1.0; 2]);
    assert_eq!(Real::exp(f32::INFINITY), f32::INFINITY);
    assert_eq!(Real::exp(f32::NEG_INFINITY), 0.0);
    assert!(Real::exp(f32::NAN).is_nan());
}

/// Measured: 0.79 ulp.
#[test]
fn logarithm() {
    let ln = worst(all(), Real::ln, f64::ln);
    assert!(ln.0 < 1.0, "{ln:?}");
    assert_eq!(Real::ln(1.0), 0.0);
    assert_eq!([0.0, -0.0].map(Real::ln), [f32::NEG_INFINITY; 2]);
    assert_eq!(Real::ln(f32::INFINITY), f32::INFINITY);
    assert!([-1e-45, -1.0, f32::NEG_INFINITY, f32::NAN].iter().all(|&x| Real::ln(x).is_nan()));
}

/// Measured: 1.54 ulp.
#[test]
fn angle_of_a_point() {
    for (x, y) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
        let of_ratio = |ratio: f32| Real::atan2(y * ratio, x);
        let angle = worst(all(), of_ratio, |ratio| (f64::from(y) * ratio).atan2(x.into()));
        assert!(angle.0 < 1.6, "{x}, {y}: {angle:?}");
    }
    let (inf, zero) = (f32::INFINITY, 0.0);
    for (y, x, angle) in [
        (zero, zero, zero),
        (zero, -zero, PI),
        (zero, 1.0, zero),
        (zero, -1.0, PI),
        (1.0, zero, FRAC_PI_2),
        (1.0, -zero, FRAC_PI_2),
        (inf, inf, FRAC_PI_4),
        (inf, -inf, 3.0 * FRAC_PI_4),
        (1.0, inf, zero),
        (1.0, -inf, PI),
        (inf, 1.0, FRAC_PI_2),
        (inf, -1.0, FRAC_PI_2),
        (1e-45, 1e-45, FRAC_PI_4),
        (f32::MAX, f32::MAX, FRAC_PI_4),
    ] {
        assert_eq!(Real::atan2(y, x).to_bits(), angle.to_bits(), "{y}, {x}");
        assert_eq!(Real::atan2(-y, x).to_bits(), (-angle).to_bits(), "-{y}, {x}");
    }
    for (y, x) in
        [(f32::NAN, 1.0), (1.0, f32::NAN), (f32::NAN, inf), (inf, f32::NAN), (zero, f32::NAN)]
    {
        assert!(Real::atan2(y, x).is_nan(), "{y}, {x}");
    }
}

#[test]
fn sine_and_cosine_are_those_of_the_angle() {
    for i in -1000..=1000 {
        let angle = FRAC_PI_4 * i as f32 / 1000.0;
        let (sin, cos) = sin_cos_octant(angle);
        let (expected_sin, expected_cos) = f64::from(angle).sin_cos();
        assert!((f64::from(sin) - expected_sin).abs() < 1e-7, "{angle}");
        assert!((f64::from(cos) - expected_cos).abs() < 1e-7, "{angle}");
    }
}
