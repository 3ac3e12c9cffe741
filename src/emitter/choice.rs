//! Which of the emitters a shadow ray is sent to.

use glam::{DVec2, DVec3, Vec3A};

use super::light_bvh::LightChoice;
use super::{ChoicePolicy, Emitter, EmitterSample, LightBvh, Sight};
use crate::math::{Choice, Discrete};

/// A point that light is to arrive at.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// World position.
    pub position: DVec3,
    /// Unit normal of the surface, on the side where light has to arrive.
    pub normal: Vec3A,
    /// Whether light that arrives on the other side is of use too.
    pub both_sides: bool,
}

/// What [`EmitterChoice::sample`] chose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chosen {
    /// Index of the emitter.
    pub emitter: usize,
    /// The part of it, if parts were chosen among.
    pub part: Option<usize>,
    /// Its probability.
    pub probability: f64,
    /// The number rescaled to `[0, 1)` within its share, for further use.
    pub rest: f64,
}

/// A distribution over the emitters of a scene.
#[derive(Clone, Debug)]
pub struct EmitterChoice {
    /// Over the emitters and, at the end, the tree, if there is one: those that it holds have no share of their own.
    /// `None` if no emitter emits.
    distribution: Option<Discrete>,
    tree: Option<Tree>,
}

/// A light BVH over parts of emitters.
#[derive(Clone, Debug)]
struct Tree {
    bvh: LightBvh,
    /// For each of its lights the emitter and the part of it.
    parts: Vec<(u32, u32)>,
    /// For each emitter its first light.
    first: Vec<u32>,
}

impl Tree {
    /// `None` unless there is something to choose from.
    fn new(emitters: &[Box<dyn Emitter>]) -> Option<Self> {
        let (mut bounds, mut parts, mut first) = (Vec::new(), Vec::new(), Vec::new());
        for (emitter, index) in emitters.iter().zip(0..) {
            first.push(parts.len() as u32);
            let of_this = emitter.parts();
            parts.extend((0..of_this.len() as u32).map(|part| (index, part)));
            bounds.extend(of_this);
        }
        let lit = bounds.iter().filter(|b| b.intensity > 0.0).count();
        let bvh = if lit > 1 { LightBvh::new(&bounds) } else { None };
        bvh.map(|bvh| Self { bvh, parts, first })
    }
}

impl EmitterChoice {
    /// A choice among `emitters`. An emitter without power is never chosen.
    #[must_use]
    pub fn new(policy: ChoicePolicy, emitters: &[Box<dyn Emitter>]) -> Self {
        let powers: Vec<_> = emitters.iter().map(|e| e.power()).collect();
        let tree = if policy == ChoicePolicy::Bvh { Tree::new(emitters) } else { None };
        let inside: f64 = powers.iter().flatten().sum();
        let least = 1e-3 * inside / powers.len() as f64;
        let outside = powers.iter().filter(|p| p.is_none()).count();
        // Together as likely as all emitters inside the scene.
        let share = if inside > 0.0 { inside / outside as f64 } else { 1.0 };
        let weight = |power: Option<f64>| match (policy, power) {
            (_, Some(power)) if power <= 0.0 => 0.0,
            (ChoicePolicy::Power, Some(power)) => power.max(least),
            (ChoicePolicy::Power, None) => share,
            (ChoicePolicy::Bvh, Some(_)) if tree.is_some() => 0.0,
            (ChoicePolicy::Bvh | ChoicePolicy::Uniform, _) => 1.0,
        };
        let weights = powers.iter().map(|&power| weight(power));
        let weights: Vec<_> = weights.chain(tree.as_ref().map(|_| 1.0)).collect();
        Self { distribution: Discrete::new(&weights), tree }
    }

    /// An emitter, chosen by `u` in `[0, 1)`. `None` if none emits, or none towards the receiver.
    #[inline]
    #[must_use]
    pub fn sample(&self, receiver: &Receiver, u: f64) -> Option<Chosen> {
        let Choice { index, probability, rest } = self.distribution.as_ref()?.sample(u);
        let Some(Tree { bvh, parts, .. }) = self.tree.as_ref().filter(|t| index == t.first.len())
        else {
            return Some(Chosen { emitter: index, part: None, probability, rest });
        };
        let LightChoice { light, probability: share, rest } = bvh.sample(receiver, rest)?;
        let (emitter, part) = parts[light];
        Some(Chosen {
            emitter: emitter as usize,
            part: Some(part as usize),
            probability: probability * share,
            rest,
        })
    }

    /// Light from one of the `emitters` that this is a choice among, chosen by `u` in `[0, 1)²`; weight and density
    /// are those of the direction among all. `None` if no light can be found.
    #[inline]
    #[must_use]
    pub fn sample_toward(
        &self,
        emitters: &[Box<dyn Emitter>],
        receiver: &Receiver,
        u: DVec2,
    ) -> Option<EmitterSample> {
        let Chosen { emitter, part, probability, rest } = self.sample(receiver, u.x)?;
        let (emitter, u) = (&emitters[emitter], DVec2::new(rest, u.y));
        let mut sample = match part {
            None => emitter.sample_toward(receiver.position, u),
            Some(part) => emitter.sample_part_toward(part, receiver.position, u),
        }?;
        let probability = probability as f32;
        sample.weight /= probability;
        sample.pdf *= probability;
        Some(sample)
    }

    /// Density with which [`EmitterChoice::sample_toward`] chooses what is seen of an emitter, in sr⁻¹.
    #[inline]
    #[must_use]
    pub fn pdf_toward(
        &self,
        emitters: &[Box<dyn Emitter>],
        emitter: usize,
        receiver: &Receiver,
        sight: &Sight<'_>,
    ) -> f32 {
        let Some(distribution) = &self.distribution else { return 0.0 };
        let alone = distribution.probability(emitter);
        match &self.tree {
            Some(tree) if alone == 0.0 => {
                let (part, pdf) = emitters[emitter].part_pdf_toward(sight);
                if pdf == 0.0 {
                    return 0.0;
                }
                let light = tree.first[emitter] as usize + part;
                let share = tree.bvh.probability(receiver, light);
                (distribution.probability(emitters.len()) * share) as f32 * pdf
            }
            _ => alone as f32 * emitters[emitter].pdf_toward(sight),
        }
    }

    /// Probability with which `emitter` is chosen.
    #[must_use]
    pub fn probability(&self, receiver: &Receiver, emitter: usize) -> f64 {
        let Some(distribution) = &self.distribution else { return 0.0 };
        let alone = distribution.probability(emitter);
        let Some(Tree { bvh, parts, first }) = &self.tree else { return alone };
        let next = first.get(emitter + 1).map_or(parts.len(), |&n| n as usize);
        let lights = first.get(emitter).map_or(next, |&n| n as usize)..next;
        let share: f64 = lights.map(|light| bvh.probability(receiver, light)).sum();
        let last = distribution.probability(first.len());
        alone + last * share
    }
}
