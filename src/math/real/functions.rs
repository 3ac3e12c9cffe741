//! Functions as polynomials over any number of lanes. Errors are measured by `tests::functions`.

use std::f32::consts::{FRAC_2_PI, FRAC_PI_2, LOG2_E, PI};

use super::{Real, Uint};

/// 1.5 · 2²³: what is added to it is rounded to a whole number, to even in a tie, that then stands in the lowest
/// bits. For less than 2²² in magnitude.
const ROUND: f32 = 12_582_912.0;

/// The polynomial with these coefficients, that of the highest power first.
#[inline(always)]
pub(in crate::math) fn polynomial<R: Real, const N: usize>(x: R, coefficients: [f32; N]) -> R {
    let mut sum = R::splat(x.token(), coefficients[0]);
    for coefficient in &coefficients[1..] {
        sum = sum * x + *coefficient;
    }
    sum
}

/// The other sign where the highest bit of `bits` is set.
#[inline(always)]
fn flip<R: Real>(number: R, bits: R::Uint) -> R {
    R::from_bits(number.to_bits() ^ (bits & (1 << 31)))
}

/// Sine and cosine of at most π/4 in magnitude, within 1 ulp. The polynomials are those of Cephes (Moshier 1989,
/// `sinf` and `cosf`).
#[inline(always)]
pub(in crate::math) fn sin_cos_octant<R: Real>(x: R) -> (R, R) {
    let z = x * x;
    let sin = polynomial(z, [-1.951_529_6e-4, 8.332_161e-3, -1.666_665_5e-1]) * z * x + x;
    let cos = polynomial(z, [2.443_315_7e-5, -1.388_731_6e-3, 4.166_664_6e-2]) * z * z - z * 0.5;
    (sin, cos + 1.0)
}

/// The nearest multiple of π/2 is taken off in three parts, of which the first two have so few bits that their
/// products are exact (Cody and Waite).
#[inline(always)]
pub(super) fn sin_cos<R: Real>(x: R) -> (R, R) {
    const PARTS: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];
    let x = R::select(x.abs().le(8192.0), x, f32::NAN);
    let shifted = x * FRAC_2_PI + ROUND;
    let (turns, quadrant) = (shifted - ROUND, shifted.to_bits());
    let rest = x - turns * PARTS[0] - turns * PARTS[1] - turns * PARTS[2];
    let (sin, cos) = sin_cos_octant(rest.abs());
    let straight = (quadrant & 1).eq(0);
    // The sine is odd in the rest; of both, the sign changes every other quadrant, the cosine's one earlier.
    let sin_of_rest = flip(sin, rest.to_bits());
    let sin = flip(R::select(straight, sin_of_rest, cos), quadrant << 30);
    let cos = flip(R::select(straight, cos, sin_of_rest), quadrant.wrapping_add(1) << 30);
    (sin, cos)
}

/// 2 to the power of `biased` - 128, which is in the range of f32.
#[inline(always)]
fn power_of_two<R: Real>(biased: R::Uint) -> R {
    R::from_bits(biased.wrapping_sub(1) << 23)
}

/// e^x = 2^k · e^r with r within ln 2 / 2 of 0. The polynomial is that of Cephes (Moshier 1989, `expf`).
#[inline(always)]
pub(super) fn exp<R: Real>(x: R) -> R {
    const LN_2: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];
    // Beyond these it is ∞ and 0 all the same.
    let x = x.clamp(-105.0, 89.0);
    let shifted = x * LOG2_E + ROUND;
    let power = shifted - ROUND;
    let r = x - power * LN_2[0] - power * LN_2[1];
    let tail = polynomial(
        r,
        [1.987_569_1e-4, 1.398_199_9e-3, 8.333_452e-3, 4.166_579_6e-2, 1.666_666_5e-1, 5e-1],
    );
    let mantissa = tail * (r * r) + r + 1.0;
    // In two steps, since 2^k itself leaves the range of f32 before the result does. `biased` is k + 256, of
    // which each half has 128.
    let biased = shifted.to_bits().wrapping_sub(ROUND.to_bits() - 256);
    let half = biased >> 1;
    mantissa * power_of_two::<R>(half) * power_of_two::<R>(biased.wrapping_sub(half))
}

/// x = 2^k · (1 + f) with 1 + f within a factor √2 of 1. With s = f / (2 + f), ln(1 + f) = 2 artanh s. The
/// coefficients are those of fdlibm (Sun Microsystems 1993, `e_logf.c`).
#[inline(always)]
pub(super) fn ln<R: Real>(x: R) -> R {
    const LN_2: [f32; 2] = [9.058_001e-6, 0.693_138_1];
    // Bits of √½, and of 1.
    const ROOT: u32 = 0x3f35_04f3;
    const ONE: u32 = 0x3f80_0000;
    let subnormal = x.lt(f32::MIN_POSITIVE);
    let normal = R::select(subnormal, x * 33_554_432.0, x);
    let bits = normal.to_bits().wrapping_add(ONE - ROOT);
    let power = (bits >> 23).to_real() - R::select(subnormal, R::splat(x.token(), 152.0), 127.0);
    let f = R::from_bits((bits & 0x007f_ffff).wrapping_add(ROOT)) - 1.0;
    let s = f / (f + 2.0);
    let z = s * s;
    let tail = polynomial(z, [0.242_790_79, 0.284_987_87, 0.400_009_72, 0.666_666_6]) * z;
    let half_square = f * f * 0.5;
    let sum = s * (half_square + tail) + power * LN_2[0] - half_square + f + power * LN_2[1];
    // Of 0 and ∞; what is negative or NaN satisfies neither comparison.
    let sum = R::select(x.lt(f32::INFINITY), sum, x);
    let sum = R::select(x.eq(0.0), f32::NEG_INFINITY, sum);
    R::select(x.ge(0.0), sum, f32::NAN)
}

/// The angle in the first octant by a polynomial in the ratio of the shorter to the longer side (least largest
/// relative error, 3e-9), then mirrored to where the point is.
#[inline(always)]
pub(super) fn atan2<R: Real>(y: R, x: R) -> R {
    /// π/2 less its nearest f32.
    const REST: f32 = -4.371_139e-8;
    let (height, width) = (y.abs(), x.abs());
    let (short, long) = (height.min(width), height.max(width));
    // Also of two infinities; 0/0 is none.
    let ratio = R::select(short.eq(long), 1.0, short / long);
    let ratio = R::select(long.eq(0.0), 0.0, ratio);
    let z = ratio * ratio;
    let tail = polynomial(
        z,
        [
            -1.793_621_3e-3,
            1.091_460_5e-2,
            -3.117_784_3e-2,
            5.795_759_3e-2,
            -8.403_45e-2,
            1.095_218_6e-1,
            -1.426_424_2e-1,
            1.999_854_9e-1,
            -3.333_33e-1,
        ],
    );
    let octant = tail * z * ratio + ratio;
    let left = x.is_sign_negative();
    let steep = -(octant.copysign(x) - REST) + FRAC_PI_2;
    let flat = R::select(left, -(octant - 2.0 * REST) + PI, octant);
    let angle = R::select(height.gt(width), steep, flat);
    let numbers = x.eq(x) & y.eq(y);
    R::select(numbers, angle.copysign(y), f32::NAN)
}
