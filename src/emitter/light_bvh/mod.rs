//! A choice among many lights by a tree over them.
//!
//! Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting" (2018), without the
//! splitting, as in Pharr, Jakob and Humphreys, "Physically Based Rendering" (4th edition, 2023), section 12.6.3.

use std::num::NonZeroU64;

use glam::{Vec3, Vec3A};

use super::{EmitterBounds, Receiver};
use crate::math::discrete::BELOW_ONE;

mod build;

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

/// A node as a receiver sees it: a ball around lights and a cone around their normals.
#[derive(Clone, Copy, Debug)]
struct Node {
    center: Vec3,
    radius_squared: f32,
    /// Of the cone of normals.
    axis: Vec3,
    /// Sine and cosine of its half angle.
    normals: Angle,
    /// Cosine of the largest angle between a normal and a direction of its light.
    cos_emission: f32,
    /// As a fraction of that of all lights.
    intensity: f32,
    content: Content,
}

#[derive(Clone, Copy, Debug)]
enum Content {
    /// The index of a light.
    Light(u32),
    /// The index of the second child; the first is the next node.
    Children(u32),
}

/// What [`LightBvh::sample`] chose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightChoice {
    /// Which of the lights.
    pub light: usize,
    /// Its probability.
    pub probability: f64,
    /// The number rescaled to `[0, 1)` within its share.
    pub rest: f64,
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
    fn shares(&self, first: usize, second: usize, receiver: &Receiver) -> Option<[f64; 2]> {
        let [a, b] = [first, second].map(|i| self.nodes[i].importance(receiver));
        let first = if a > 0.0 && b > 0.0 {
            (a / (a + b)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE)
        } else {
            f64::from(u8::from(a > 0.0))
        };
        (a > 0.0 || b > 0.0).then_some([first, 1.0 - first])
    }
}

/// What can be of use is taken so often at least: the bright side may be hidden, and then all comes from the other.
const LEAST_SHARE: f64 = 1.0 / 1024.0;

/// Cosines count from here on, so that no light is left out that can be of use: nothing that is near the limit of
/// what shines or receives is called dark because of rounding. Sines that are found from a cosine are off by up to
/// √2⁻²³ = 3.5e-4, and two such are added.
const LEAST_COSINE: f32 = 1e-3;

/// The sine and the cosine of an angle in `[0, π]`.
#[derive(Clone, Copy, Debug)]
struct Angle {
    sin: f32,
    cos: f32,
}

impl Angle {
    const ZERO: Self = Self { sin: 0.0, cos: 1.0 };

    fn of_cosine(cos: f32) -> Self {
        Self { sin: (1.0 - cos * cos).max(0.0).sqrt(), cos }
    }

    /// The difference, or 0 if it is below.
    #[inline]
    fn less(self, other: Self) -> Self {
        if self.cos > other.cos {
            return Self::ZERO;
        }
        Self {
            sin: self.sin * other.cos - self.cos * other.sin,
            cos: self.cos * other.cos + self.sin * other.sin,
        }
    }
}

impl Node {
    /// A guess of the irradiance: intensity over squared distance, times a bound of the cosines at both ends. 0 only
    /// where nothing can arrive; finite, also at the emitter itself.
    #[inline]
    fn importance(&self, receiver: &Receiver) -> f64 {
        let to_receiver = receiver.position.as_vec3a() - Vec3A::from(self.center);
        let squared = to_receiver.length_squared();
        if squared <= self.radius_squared {
            // Within the ball nothing is known of directions, and half of its size stands for the distance.
            return self.over(self.radius_squared);
        }
        let direction = to_receiver * squared.sqrt().recip();
        // Half of the angle under which the ball is seen.
        let sin_squared = self.radius_squared / squared;
        let ball = Angle { sin: sin_squared.sqrt(), cos: (1.0 - sin_squared).sqrt() };
        let to_axis = Angle::of_cosine(Vec3A::from(self.axis).dot(direction));
        let cos_emitter = to_axis.less(self.normals).less(ball).cos;
        let above = -receiver.normal.dot(direction);
        let above = if receiver.both_sides { above.abs() } else { above };
        let cos_receiver = Angle::of_cosine(above).less(ball).cos;
        if cos_emitter < self.cos_emission - LEAST_COSINE || cos_receiver < -LEAST_COSINE {
            return 0.0;
        }
        let cosines = cos_emitter.max(LEAST_COSINE) * cos_receiver.max(LEAST_COSINE);
        self.over(squared) * f64::from(cosines)
    }

    fn over(&self, distance_squared: f32) -> f64 {
        f64::from(self.intensity) / f64::from(distance_squared.max(f32::MIN_POSITIVE))
    }
}

#[cfg(test)]
mod tests;
