//! Which of the emitters a shadow ray is sent to.

use glam::{DVec2, DVec3, Vec3A};

use super::light_bvh::LightChoice;
use super::{ChoicePolicy, Emitter, EmitterSample, EmitterSamples, LightBvh, Sight};
use crate::math::real::{Lanes, Mask, Real, Select};
use crate::math::{Choice, Discrete, vector as real};

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

/// A [`Receiver`] in each lane, all of one material.
#[derive(Clone, Copy, Debug)]
pub struct Receivers<R: Real> {
    /// See [`Receiver::position`].
    pub position: real::Vec3<R::Double>,
    /// See [`Receiver::normal`].
    pub normal: real::Vec3<R>,
    /// See [`Receiver::both_sides`].
    pub both_sides: bool,
}

impl<R: Real> Receivers<R> {
    /// That of one lane.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, i: usize) -> Receiver {
        Receiver {
            position: self.position.lane(i).into(),
            normal: self.normal.lane(i).into(),
            both_sides: self.both_sides,
        }
    }
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
    /// Whether there is nothing to choose from but one emitter.
    is_alone: bool,
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
        let distribution = Discrete::new(&weights);
        let is_alone = emitters.len() == 1 && tree.is_none() && distribution.is_some();
        Self { distribution, tree, is_alone }
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
    #[must_use]
    pub fn sample_toward(
        &self,
        emitters: &[Box<dyn Emitter>],
        receiver: &Receiver,
        u: DVec2,
    ) -> Option<EmitterSample> {
        let Receiver { position, normal, both_sides } = *receiver;
        let receivers = Receivers { position: position.into(), normal: normal.into(), both_sides };
        self.sample_toward_each::<f32>(emitters, &receivers, u.into(), true).lane(0)
    }

    /// The same in each lane where it is `wanted`. The emitter is chosen lane by lane, unless there is one alone; lanes that
    /// chose the same are answered together.
    #[inline(always)]
    #[must_use]
    pub fn sample_toward_each<R: Real>(
        &self,
        emitters: &[Box<dyn Emitter>],
        receivers: &Receivers<R>,
        u: real::Vec2<R::Double>,
        wanted: R::Mask,
    ) -> EmitterSamples<R> {
        let token = wanted.token();
        if self.is_alone {
            return emitters[0].sample(None, receivers.position, u);
        }
        let chosen = R::each(|i| {
            let is_wanted = wanted.lane(i);
            is_wanted.then(|| self.sample(&receivers.lane(i), u.x.lane(i))).flatten()
        });
        let chosen = chosen.as_ref();
        let rest = R::Double::from_fn(token, |i| chosen[i].map_or(0.0, |chosen| chosen.rest));
        let u = real::Vec2::new(rest, u.y);
        let mut samples = EmitterSamples::<R>::splat(token, None);
        let mut answered = R::Mask::splat(token, false);
        for first in 0..R::LANES {
            let Some(Chosen { emitter, part, .. }) = chosen[first] else { continue };
            if answered.lane(first) {
                continue;
            }
            let same = R::mask(token, |i| chosen[i].is_some_and(|other| other.emitter == emitter));
            let chosen_emitter = emitters[emitter].as_ref();
            let sampled = if same.count() == 1 {
                let part = part.map(|part| [part as u32]);
                let (from, u) = (receivers.position.lane(first), u.lane(first));
                let sample = chosen_emitter.sample::<f32>(part, from, u).lane(0);
                EmitterSamples::splat(token, sample.as_ref())
            } else {
                // In the other lanes any part will do.
                let part_of = |i: usize| chosen[i].filter(|other| other.emitter == emitter)?.part;
                let parts = part.map(|first| R::each(|i| part_of(i).unwrap_or(first) as u32));
                chosen_emitter.sample(parts, receivers.position, u)
            };
            samples = Select::selected(same, sampled, samples);
            answered |= same;
        }
        let probability =
            R::from_fn(token, |i| chosen[i].map_or(1.0, |chosen| chosen.probability as f32));
        samples.weight = samples.weight / probability;
        samples.pdf *= probability;
        samples
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
