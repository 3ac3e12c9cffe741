//! Which of the emitters a shadow ray is sent to.

use glam::{DVec2, DVec3, Vec3A};

use super::area::AreaPdf;
use super::parts::Parts;
use super::{Area, ChoicePolicy, Emitter, EmitterSample, EmitterSamples, Sight};
use crate::math::real::{Double, Float, Lanes, Mask, Real, Select};
use crate::math::{Choices, Discrete, vector as real};

/// A point that light is to arrive at.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// World position.
    pub position: DVec3,
    /// Unit normal of the surface, on the side where light has to arrive.
    pub normal: Vec3A,
    /// Whether light that arrives on the other side is of use too.
    pub both_sides: bool,
    /// Whether the irradiance alone says what light is worth there, and not also from where it arrives.
    pub is_diffuse: bool,
}

/// A [`Receiver`] in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Receivers<R: Real> {
    /// See [`Receiver::position`].
    pub position: real::Vec3<R::Double>,
    /// See [`Receiver::normal`].
    pub normal: real::Vec3<R>,
    /// See [`Receiver::both_sides`].
    pub both_sides: R::Mask,
    /// See [`Receiver::is_diffuse`].
    pub is_diffuse: R::Mask,
}

impl From<Receiver> for Receivers<f32> {
    #[inline(always)]
    fn from(Receiver { position, normal, both_sides, is_diffuse }: Receiver) -> Self {
        Self { position: position.into(), normal: normal.into(), both_sides, is_diffuse }
    }
}

impl<R: Real> Receivers<R> {
    /// That of one lane.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, i: usize) -> Receiver {
        Receiver {
            position: self.position.lane(i).into(),
            normal: self.normal.lane(i).into(),
            both_sides: self.both_sides.lane(i),
            is_diffuse: self.is_diffuse.lane(i),
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
    /// Over the emitters and, at the end, the parts, if any are chosen by importance: the emitters that have those have no
    /// share of their own. `None` if no emitter emits.
    distribution: Option<Discrete>,
    parts: Option<Parts>,
}

/// What is chosen in each lane: a [`Chosen`], where it exists.
struct ChosenEach<R: Real> {
    exists: R::Mask,
    emitter: R::Each<u32>,
    part: R::Each<Option<u32>>,
    probability: R::Double,
    rest: R::Double,
}

impl EmitterChoice {
    /// A choice among `emitters`. An emitter without power is never chosen.
    #[must_use]
    pub fn new(policy: ChoicePolicy, emitters: &[Box<dyn Emitter>]) -> Self {
        Self::of_powers(policy, emitters, &Self::powers(emitters, false))
    }

    /// The same for who follows the directions of surfaces too: where there are others, an emitter that
    /// [is uniform](Emitter::is_uniform) is never chosen.
    ///
    /// With a lamp beside a uniform environment every second shadow ray would go to the environment, half of them into
    /// the ground, for what directions find anyhow.
    #[must_use]
    pub fn beside_directions(policy: ChoicePolicy, emitters: &[Box<dyn Emitter>]) -> Self {
        Self::of_powers(policy, emitters, &Self::powers(emitters, true))
    }

    /// The power of each emitter, as far as it may be chosen.
    pub(super) fn powers(
        emitters: &[Box<dyn Emitter>],
        beside_directions: bool,
    ) -> Vec<Option<f64>> {
        let all: Vec<_> = emitters.iter().map(|emitter| emitter.power()).collect();
        let emitters = emitters.iter().zip(&all);
        let left = emitters.map(|(e, &power)| if e.is_uniform() { Some(0.0) } else { power });
        let left: Vec<_> = left.collect();
        if beside_directions && left.iter().any(|&power| power != Some(0.0)) { left } else { all }
    }

    pub(super) fn of_powers(
        policy: ChoicePolicy,
        emitters: &[Box<dyn Emitter>],
        powers: &[Option<f64>],
    ) -> Self {
        let by_importance = matches!(policy, ChoicePolicy::Bvh | ChoicePolicy::Ris);
        let parts = if by_importance { Parts::new(emitters) } else { None };
        let inside: f64 = powers.iter().flatten().sum();
        let least = 1e-3 * inside / powers.len() as f64;
        let outside = powers.iter().filter(|p| p.is_none()).count();
        // Together as likely as all emitters inside the scene.
        let share = if inside > 0.0 { inside / outside as f64 } else { 1.0 };
        let weight = |power: Option<f64>| match (policy, power) {
            (_, Some(power)) if power <= 0.0 => 0.0,
            (ChoicePolicy::Power, Some(power)) => power.max(least),
            (ChoicePolicy::Power, None) => share,
            (ChoicePolicy::Bvh | ChoicePolicy::Ris, Some(_)) if parts.is_some() => 0.0,
            (ChoicePolicy::Bvh | ChoicePolicy::Ris | ChoicePolicy::Uniform, _) => 1.0,
        };
        let weights = powers.iter().map(|&power| weight(power));
        let weights: Vec<_> = weights.chain(parts.as_ref().map(|_| 1.0)).collect();
        Self { distribution: Discrete::new(&weights), parts }
    }

    /// An emitter, chosen by `u` in `[0, 1)`. `None` if none emits, or none towards the receiver.
    #[must_use]
    pub fn sample(&self, receiver: &Receiver, u: f64) -> Option<Chosen> {
        let distribution = self.distribution.as_ref()?;
        let chosen = self.choose::<f32>(distribution, &(*receiver).into(), u);
        chosen.exists.then(|| Chosen {
            emitter: chosen.emitter[0] as usize,
            part: chosen.part[0].map(|part| part as usize),
            probability: chosen.probability,
            rest: chosen.rest,
        })
    }

    #[inline(always)]
    fn choose<R: Real>(
        &self,
        distribution: &Discrete,
        receivers: &Receivers<R>,
        u: R::Double,
    ) -> ChosenEach<R> {
        let token = u.token();
        let Choices { index: emitter, probability, rest } = distribution.sample_each::<R>(u);
        let mut chosen = ChosenEach {
            exists: R::Mask::splat(token, true),
            emitter,
            part: R::each(|_| None),
            probability,
            rest,
        };
        let Some(Parts { among, names, first }) = &self.parts else { return chosen };
        let is_part = R::mask(token, |i| emitter.as_ref()[i] as usize == first.len());
        if !is_part.any() {
            return chosen;
        }
        let lights = among.sample(receivers, rest);
        let names = R::each(|i| names[lights.light.as_ref()[i] as usize]);
        let names = names.as_ref();
        chosen.exists = !is_part | lights.exists;
        chosen.emitter =
            R::each(|i| if is_part.lane(i) { names[i].0 } else { emitter.as_ref()[i] });
        chosen.part = R::each(|i| is_part.lane(i).then_some(names[i].1));
        chosen.probability =
            R::Double::select(is_part, probability * lights.probability, probability);
        chosen.rest = R::Double::select(is_part, lights.rest, rest);
        chosen
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
        self.sample_toward_each::<f32>(emitters, &(*receiver).into(), u.into(), true).lane(0)
    }

    /// The same in each lane where it is `wanted`. Points of surfaces are sampled together, whichever lights they are of,
    /// and lanes that chose the same other emitter.
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
        let none = EmitterSamples::<R>::splat(token, None);
        let Some(distribution) = &self.distribution else { return none };
        let chosen = self.choose::<R>(distribution, receivers, u.x);
        let wanted = wanted & chosen.exists;
        let u = real::Vec2::new(chosen.rest, u.y);
        let indices = chosen.emitter.as_ref();
        let area = R::each(|i| emitters[indices[i] as usize].area());
        let is_area = R::mask(token, |i| area.as_ref()[i].is_some());
        let mut samples = none;
        if let Some(any) = area.as_ref().iter().flatten().next() {
            // In the other lanes any will do.
            let areas = R::each(|i| area.as_ref()[i].unwrap_or(any));
            // By itself, as it is long.
            samples = R::vectorize(
                token,
                #[inline(always)]
                || Area::sample(&areas, &chosen.part, receivers.position, u),
            );
        }
        let mut left = wanted & !is_area;
        for first in 0..R::LANES {
            if !left.lane(first) {
                continue;
            }
            let emitter = indices[first];
            let same = left & R::mask(token, |i| indices[i] == emitter);
            // Another emitter's part is one that means nothing to this, and is not asked for.
            let part = |first| {
                R::each(|i| {
                    if same.lane(i) { chosen.part.as_ref()[i] } else { None }.unwrap_or(first)
                })
            };
            let parts = chosen.part.as_ref()[first].map(part);
            let sampled = emitters[emitter as usize].sample::<R>(parts, receivers.position, u);
            samples = Select::selected(same, sampled, samples);
            left &= !same;
        }
        samples.chosen(wanted, chosen.probability)
    }

    /// Density with which [`EmitterChoice::sample_toward`] chooses what is seen of an emitter, in sr⁻¹.
    #[must_use]
    pub fn pdf_toward(
        &self,
        emitters: &[Box<dyn Emitter>],
        emitter: usize,
        receiver: &Receiver,
        sight: &Sight<'_>,
    ) -> f32 {
        let Some(distribution) = &self.distribution else { return 0.0 };
        let by_part = self.parts.is_some() && distribution.probability(emitter) == 0.0;
        let (part, pdf) = if by_part {
            emitters[emitter].part_pdf_toward(sight)
        } else {
            (0, emitters[emitter].pdf_toward(sight))
        };
        let seen = AreaPdf::<f32> { part: [part as u32], pdf, part_pdf: pdf };
        self.pdf_each(&[emitter as u32], &seen, &(*receiver).into())
    }

    /// The same of an emitter that is not chosen by its parts, if it is asked for the direction with density `pdf`.
    #[inline(always)]
    #[must_use]
    pub(super) fn pdf_of_emitter<R: Real>(&self, emitter: usize, pdf: R) -> R {
        let probability = self.distribution.as_ref().map_or(0.0, |all| all.probability(emitter));
        pdf * probability as f32
    }

    /// Density of what is seen of emitters: for the densities with which their directions, or those of their parts, are
    /// chosen once they are.
    #[inline(always)]
    pub(super) fn pdf_each<R: Real>(
        &self,
        emitters: &R::Each<u32>,
        of_areas: &AreaPdf<R>,
        receivers: &Receivers<R>,
    ) -> R {
        let AreaPdf { part: parts, pdf, part_pdf } = *of_areas;
        let token = pdf.token();
        let emitters = emitters.as_ref();
        let Some(distribution) = &self.distribution else { return R::splat(token, 0.0) };
        let alone = R::Double::from_fn(token, |i| distribution.probability(emitters[i] as usize));
        let by_itself = alone.narrow() * pdf;
        let Some(all) = &self.parts else { return by_itself };
        let is_part = alone.eq(0.0);
        if !is_part.any() {
            return by_itself;
        }
        let light = |i: usize| all.number(emitters[i] as usize, parts.as_ref()[i]);
        let share = all.among.probability(receivers, &R::each(light));
        let share = share * distribution.probability(all.first.len());
        R::select(is_part, share.narrow() * part_pdf, by_itself)
    }

    /// Probability with which `emitter` is chosen.
    #[must_use]
    pub fn probability(&self, receiver: &Receiver, emitter: usize) -> f64 {
        let Some(distribution) = &self.distribution else { return 0.0 };
        let alone = distribution.probability(emitter);
        let Some(parts) = &self.parts else { return alone };
        let receivers = Receivers::from(*receiver);
        let share = |light| parts.among.probability::<f32>(&receivers, &[light as u32]);
        let share: f64 = parts.of(emitter).map(share).sum();
        alone + distribution.probability(parts.first.len()) * share
    }
}
