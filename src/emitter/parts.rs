//! A choice among the parts of emitters by importance for the receiver.

use std::ops::Range;

use super::light_list::LightList;
use super::{Emitter, EmitterBounds, LightBvh, Receivers};
use crate::math::real::{Lanes, Real};

/// A light of a list or a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightChoice {
    /// Which of the lights.
    pub light: usize,
    /// Its probability.
    pub probability: f64,
    /// The number rescaled to `[0, 1)` within its share.
    pub rest: f64,
}

/// A [`LightChoice`] in each lane.
#[derive(Clone, Copy, Debug)]
pub struct LightChoices<R: Real> {
    /// Where there is one; elsewhere the rest means nothing.
    pub exists: R::Mask,
    /// See [`LightChoice::light`].
    pub light: R::Each<u32>,
    /// See [`LightChoice::probability`].
    pub probability: R::Double,
    /// See [`LightChoice::rest`].
    pub rest: R::Double,
}

/// A choice among parts of emitters by importance for the receiver.
#[derive(Clone, Debug)]
pub(super) struct Parts {
    pub(super) among: Among,
    /// Of each part the emitter, and its number among the parts of that.
    pub(super) names: Vec<(u32, u32)>,
    /// For each emitter its first part.
    pub(super) first: Vec<u32>,
}

#[derive(Clone, Debug)]
pub(super) enum Among {
    Few(LightList),
    Many(LightBvh),
}

impl Parts {
    /// `None` unless there is something to choose from.
    pub(super) fn new(emitters: &[Box<dyn Emitter>]) -> Option<Self> {
        let (mut bounds, mut names, mut first) = (Vec::new(), Vec::new(), Vec::new());
        for (emitter, index) in emitters.iter().zip(0..) {
            first.push(names.len() as u32);
            let of_this = emitter.parts();
            names.extend((0..of_this.len() as u32).map(|part| (index, part)));
            bounds.extend(of_this);
        }
        Some(Self { among: Among::new(&bounds)?, names, first })
    }

    /// The number of a part of an emitter, or one that no part has.
    pub(super) fn number(&self, emitter: usize, part: u32) -> u32 {
        let parts = self.of(emitter);
        let number = parts.start + part as usize;
        if parts.contains(&number) { number as u32 } else { u32::MAX }
    }

    /// The numbers of an emitter's parts.
    pub(super) fn of(&self, emitter: usize) -> Range<usize> {
        let at = |emitter| self.first.get(emitter).map_or(self.names.len(), |&n| n as usize);
        at(emitter)..at(emitter + 1)
    }
}

impl Among {
    /// `None` unless there is something to choose from.
    pub(super) fn new(bounds: &[EmitterBounds]) -> Option<Self> {
        let lit = bounds.iter().filter(|b| b.intensity > 0.0).count();
        if lit < 2 {
            return None;
        }
        let few = LightList::new(bounds).map(Self::Few);
        few.or_else(|| LightBvh::new(bounds).map(Self::Many))
    }

    /// Of few together, of many lane by lane.
    #[inline(always)]
    pub(super) fn sample<R: Real>(
        &self,
        receivers: &Receivers<R>,
        u: R::Double,
    ) -> LightChoices<R> {
        let token = u.token();
        match self {
            Self::Few(list) => R::vectorize(
                token,
                #[inline(always)]
                || list.sample(receivers, u),
            ),
            Self::Many(bvh) => {
                let chosen = R::each(|i| bvh.sample(&receivers.lane(i), u.lane(i)));
                let chosen = chosen.as_ref();
                let number = |of: fn(&LightChoice) -> f64| {
                    R::Double::from_fn(token, |i| chosen[i].as_ref().map_or(1.0, of))
                };
                LightChoices {
                    exists: R::mask(token, |i| chosen[i].is_some()),
                    light: R::each(|i| chosen[i].map_or(0, |choice| choice.light as u32)),
                    probability: number(|choice| choice.probability),
                    rest: number(|choice| choice.rest),
                }
            }
        }
    }

    /// Probability with which [`Among::sample`] chooses each lane's light.
    #[inline(always)]
    pub(super) fn probability<R: Real>(
        &self,
        receivers: &Receivers<R>,
        lights: &R::Each<u32>,
    ) -> R::Double {
        match self {
            Self::Few(list) => list.probability(receivers, lights),
            Self::Many(bvh) => R::Double::from_fn(receivers.normal.token(), |i| {
                bvh.probability(&receivers.lane(i), lights.as_ref()[i] as usize)
            }),
        }
    }
}
