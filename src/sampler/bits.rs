//! Hashing, and bits to numbers: what the samplers share.

/// 2⁶⁴ over the golden ratio, made odd: the increment of SplitMix64.
pub(super) const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014; constants of Stafford's variant 13).
pub(super) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The 24 high bits as a multiple of 2⁻²⁴ below 1. All 32 would round up to 1 for 128 inputs.
pub(super) fn to_unit(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stay_below_one() {
        for x in [0, 1, 255, u32::MAX - 255, u32::MAX] {
            assert!((0.0..1.0).contains(&to_unit(x)), "{x}");
        }
        assert_eq!(to_unit(u32::MAX), 1.0 - f32::EPSILON / 2.0);
    }
}
