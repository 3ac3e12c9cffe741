//! Hashing: what the samplers share.

use crate::math::real::Uint;

/// 2⁶⁴ over the golden ratio, made odd: the increment of SplitMix64.
pub(super) const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014; constants of Stafford's variant 13).
pub(super) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Three hashes of three numbers: pcg3d of Jarzynski and Olano ("Hash Functions for GPU Rendering", 2020, listing 16), with
/// 32-bit operations alone.
#[inline(always)]
pub(super) fn pcg3d<U: Uint>([x, y, z]: [U; 3]) -> [U; 3] {
    let [x, y, z] = spread(step(x), step(y), step(z));
    spread(x ^ (x >> 16), y ^ (y >> 16), z ^ (z >> 16))
}

/// The linear congruential generator in it.
#[inline(always)]
fn step<U: Uint>(v: U) -> U {
    v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223)
}

#[inline(always)]
fn spread<U: Uint>(x: U, y: U, z: U) -> [U; 3] {
    let x = x.wrapping_add(y.wrapping_mul(z));
    let y = y.wrapping_add(z.wrapping_mul(x));
    [x, y, z.wrapping_add(x.wrapping_mul(y))]
}

/// A hash of one number: `lowbias32` of Wellons ("Prospecting for Hash Functions", 2018).
#[inline(always)]
pub(super) fn lowbias32<U: Uint>(x: U) -> U {
    let x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    let x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All 32 bits would round up to 1 for 128 inputs.
    #[test]
    fn numbers_stay_below_one() {
        for x in [0, 1, 255, u32::MAX - 255, u32::MAX] {
            assert!((0.0..1.0).contains(&x.to_unit()), "{x}");
        }
        assert_eq!(u32::MAX.to_unit(), 1.0 - f32::EPSILON / 2.0);
    }
}
