//! Independent uniform numbers from a counter-based generator.

use glam::{DVec2, Vec2};

use super::{PathKey, Sampler};

/// Numbers without any correlation: plain Monte Carlo, with an error that falls as n^(−1/2).
#[derive(Clone, Copy, Debug)]
pub struct Independent {
    seed: u64,
}

impl Independent {
    /// Different seeds give unrelated numbers.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { seed }
    }
}

impl Sampler for Independent {
    fn path(&self, pixel: u32, sample: u32) -> PathKey {
        // Two rounds, so that neither neighbouring seeds nor neighbouring pixels share a sequence.
        let counter = (u64::from(pixel) << 32) | u64::from(sample);
        PathKey(mix(mix(self.seed ^ GOLDEN) ^ counter))
    }

    fn get_1d(&self, path: PathKey, dimension: u32) -> f32 {
        to_unit((bits(path, dimension) >> 32) as u32)
    }

    fn get_2d(&self, path: PathKey, dimension: u32) -> Vec2 {
        let bits = bits(path, dimension);
        Vec2::new(to_unit((bits >> 32) as u32), to_unit(bits as u32))
    }

    /// The first has 40 bits, the second the other 24.
    fn get_choice(&self, path: PathKey, dimension: u32) -> DVec2 {
        const ULP: f64 = 1.0 / (1u64 << 40) as f64;
        let bits = bits(path, dimension);
        DVec2::new((bits >> 24) as f64 * ULP, to_unit((bits << 8) as u32).into())
    }
}

/// 2⁶⁴ over the golden ratio, made odd: the increment of SplitMix64.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

fn bits(path: PathKey, dimension: u32) -> u64 {
    mix(path.0.wrapping_add(GOLDEN.wrapping_mul(u64::from(dimension) + 1)))
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014; constants of Stafford's variant 13).
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The 24 high bits as a multiple of 2⁻²⁴ below 1. All 32 would round up to 1 for 128 inputs.
fn to_unit(x: u32) -> f32 {
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
