//! A choice among many lights by a tree over them.
//!
//! Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting" (2018), without the
//! splitting, as in Pharr, Jakob and Humphreys, "Physically Based Rendering" (4th edition, 2023), section 12.6.3.

use std::num::NonZeroU64;

use super::importance::LightBounds;
use super::{EmitterBounds, LightChoice, Receiver, Receivers};
use crate::math::discrete::BELOW_ONE;

mod build;

/// What can be of use is taken so often at least: the bright one may be hidden, and then all comes from the others.
const LEAST_SHARE: f64 = 1.0 / 1024.0;

/// A binary tree over lights. A walk from its root takes each side as often as its importance for the receiver
/// says, so that a choice among n takes about log n steps.
#[derive(Clone, Debug)]
pub struct LightBvh {
    /// Depth first, the root at the start.
    nodes: Vec<Node>,
    /// For each light the way to its leaf; `None` for those that are dark.
    trails: Vec<Option<Trail>>,
}

/// The way from the root to a leaf, from the lowest bit on: 1 where it takes the second child. The highest bit that
/// is set is the end.
type Trail = NonZeroU64;

/// A node: what is below it, bounded, and where.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: LightBounds,
    content: Content,
}

#[derive(Clone, Copy, Debug)]
enum Content {
    /// The index of a light.
    Light(u32),
    /// The index of the second child; the first is the next node.
    Children(u32),
}

impl LightBvh {
    /// A tree over the lights of these bounds that have an intensity. `None` if there are none.
    ///
    /// # Panics
    /// With more than 2³¹ lights.
    #[must_use]
    pub fn new(lights: &[EmitterBounds]) -> Option<Self> {
        build::build(lights)
    }

    /// A light, chosen by `u` in `[0, 1)`. `None` where none can be of use to the receiver.
    #[must_use]
    pub fn sample(&self, receiver: &Receiver, u: f64) -> Option<LightChoice> {
        let receiver = &Receivers::from(*receiver);
        let (mut probability, mut rest, mut index) = (1.0, u, 0);
        loop {
            let second = match self.nodes[index].content {
                Content::Light(light) => {
                    return Some(LightChoice { light: light as usize, probability, rest });
                }
                Content::Children(second) => second as usize,
            };
            let shares = self.shares(index + 1, second, receiver)?;
            let side = usize::from(rest >= shares[0]);
            let below = if side == 0 { 0.0 } else { shares[0] };
            rest = ((rest - below) / shares[side]).min(BELOW_ONE);
            probability *= shares[side];
            index = if side == 0 { index + 1 } else { second };
        }
    }

    /// Probability with which [`LightBvh::sample`] chooses `light`.
    #[must_use]
    pub fn probability(&self, receiver: &Receiver, light: usize) -> f64 {
        let receiver = &Receivers::from(*receiver);
        let Some(trail) = self.trails.get(light).copied().flatten() else {
            return 0.0;
        };
        let (mut probability, mut index, mut trail) = (1.0, 0, trail.get());
        while let Content::Children(second) = self.nodes[index].content {
            let Some(shares) = self.shares(index + 1, second as usize, receiver) else {
                return 0.0;
            };
            let side = (trail & 1) as usize;
            probability *= shares[side];
            index = if side == 0 { index + 1 } else { second as usize };
            trail >>= 1;
        }
        probability
    }

    /// The probabilities of two children; `None` if neither can be of use.
    #[inline]
    fn shares(&self, first: usize, second: usize, receiver: &Receivers<f32>) -> Option<[f64; 2]> {
        let [a, b] = [first, second].map(|i| self.nodes[i].bounds.importance(receiver));
        let first = if a > 0.0 && b > 0.0 {
            (a / (a + b)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE)
        } else {
            f64::from(u8::from(a > 0.0))
        };
        (a > 0.0 || b > 0.0).then_some([first, 1.0 - first])
    }
}

#[cfg(test)]
pub(in crate::emitter) mod tests;
