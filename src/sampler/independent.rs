//! Independent uniform numbers from a counter-based generator.

use glam::{DVec2, Vec2};

use super::bits::{GOLDEN, mix, to_unit};
use super::{About, PathKey, Sampler};

pub(super) static ABOUT: About = About {
    name: "independent",
    help: "Independent uniform numbers.",
    independent: true,
    build: |seed| Box::new(Independent::new(seed)),
};

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

fn bits(path: PathKey, dimension: u32) -> u64 {
    mix(path.0.wrapping_add(GOLDEN.wrapping_mul(u64::from(dimension) + 1)))
}
