//! Independent uniform numbers from a counter-based generator.

use super::bits::{GOLDEN, mix, pcg3d};
use super::{About, PathKey, PathKeys, Sequence};
use crate::math::real::Uint;

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

impl Sequence for Independent {
    fn path(&self, pixel: u32, sample: u32) -> PathKey {
        // Two rounds, so that neither neighbouring seeds nor neighbouring pixels share a sequence.
        let counter = (u64::from(pixel) << 32) | u64::from(sample);
        PathKey(mix(mix(self.seed ^ GOLDEN) ^ counter))
    }

    #[inline(always)]
    fn one<U: Uint>(&self, path: PathKeys<U>, dimension: U) -> U {
        let [x, ..] = pcg3d([path.high, path.low, dimension]);
        x
    }

    #[inline(always)]
    fn two<U: Uint>(&self, path: PathKeys<U>, dimension: U) -> [U; 2] {
        let [x, y, _] = pcg3d([path.high, path.low, dimension]);
        [x, y]
    }

    #[inline(always)]
    fn choice<U: Uint>(&self, path: PathKeys<U>, dimension: U) -> [U; 3] {
        let [x, y, more] = pcg3d([path.high, path.low, dimension]);
        [x, more, y]
    }
}
