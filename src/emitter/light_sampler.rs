//! How light is sampled at the surfaces of a path.

use super::area::AreaPdf;
use super::candidates::{self, Candidates};
use super::{Area, ChoicePolicy, Emitter, EmitterChoice, Receiver, Receivers, Sight};
use crate::math::real::{Mask, Real};
use crate::shape::{Arrivals, Interaction};

/// How light is sampled at the surfaces of a path: from one emitter that was chosen, or where emitters are few by a
/// candidate from each of them.
#[derive(Clone, Debug)]
pub struct LightSampler {
    choice: EmitterChoice,
    candidates: Option<Candidates>,
}

/// So many lights are cheap enough to be asked at every surface of a path. More are only at the first one that is no ideal
/// mirror or glass, and if that is glossy: of what a diffuse surface scatters, a bound of the irradiance says nearly as
/// much. In rooms of 8 to 16 lamps candidates have .54 to .65 of the error of a choice by importance, a quarter alike, for 1.2
/// to 1.6 of the time if all is diffuse, where importance alone has .51 to .62 for the same time; and .38 to .26 for 1.4 to
/// 1.8 if all is glossy, where importance alone has 1.2.
const MOST_EVERYWHERE: usize = 3;

/// So many candidates are all taken at the first surface of a path that is no ideal mirror or glass.
const BOTH: usize = 2;

impl LightSampler {
    /// For `emitters`, of which one without power is never chosen. If the directions of surfaces are followed too, see
    /// [`EmitterChoice::beside_directions`].
    #[must_use]
    pub fn new(
        policy: ChoicePolicy,
        emitters: &[Box<dyn Emitter>],
        beside_directions: bool,
    ) -> Self {
        let powers = EmitterChoice::powers(emitters, beside_directions);
        let candidates = match policy {
            ChoicePolicy::Ris => Candidates::new(emitters, &powers),
            ChoicePolicy::Uniform | ChoicePolicy::Power | ChoicePolicy::Bvh => None,
        };
        Self { choice: EmitterChoice::of_powers(policy, emitters, &powers), candidates }
    }

    /// Whether there are two lights, both of which are taken at the first surface of a path.
    #[must_use]
    pub fn takes_both(
        policy: ChoicePolicy,
        emitters: &[Box<dyn Emitter>],
        beside_directions: bool,
    ) -> bool {
        let powers = EmitterChoice::powers(emitters, beside_directions);
        policy == ChoicePolicy::Ris && candidates::lit(&powers).count() == BOTH
    }

    /// What one emitter is chosen by, where not all are asked.
    #[must_use]
    pub fn choice(&self) -> &EmitterChoice {
        &self.choice
    }

    /// The lights that are asked for candidates, and for which of the receivers, if some are the `first` ones of their paths
    /// that are no ideal mirror or glass.
    #[inline(always)]
    #[must_use]
    pub fn candidates<R: Real>(
        &self,
        receivers: &Receivers<R>,
        first: R::Mask,
    ) -> Option<(&Candidates, R::Mask)> {
        let candidates = self.candidates.as_ref()?;
        let everywhere = R::Mask::splat(first.token(), candidates.count() <= MOST_EVERYWHERE);
        Some((candidates, everywhere | first & !receivers.is_diffuse))
    }

    /// For which of them both of two candidates are taken.
    #[inline(always)]
    #[must_use]
    pub fn both<R: Real>(&self, first: R::Mask) -> R::Mask {
        let are_two = self.candidates.as_ref().is_some_and(|all| all.count() == BOTH);
        first & R::Mask::splat(first.token(), are_two)
    }

    /// Density of what is seen of an area light in each lane from receivers that are the `first` ones of their paths or not.
    #[inline(always)]
    #[must_use]
    pub(crate) fn pdf_of_areas<R: Real>(
        &self,
        emitters: &R::Each<u32>,
        areas: &R::Each<&Area>,
        receivers: &Receivers<R>,
        first: R::Mask,
        arrivals: &Arrivals<'_, R>,
        surface: &Interaction<R>,
    ) -> R {
        let of_areas = Area::pdf_each(areas, arrivals, surface);
        self.pdf_each(emitters, &of_areas, receivers, first)
    }

    /// The same of an environment, if that is asked for the direction with density `pdf`.
    #[inline(always)]
    #[must_use]
    pub(crate) fn pdf_of_emitter<R: Real>(
        &self,
        emitter: usize,
        receivers: &Receivers<R>,
        first: R::Mask,
        pdf: R,
    ) -> R {
        let chosen = self.choice.pdf_of_emitter(emitter, pdf);
        match self.candidates(receivers, first) {
            Some((candidates, here)) => {
                R::select(here, candidates.pdf_of_emitter(emitter, pdf), chosen)
            }
            None => chosen,
        }
    }

    /// Density with which what is seen of an emitter is sampled from a receiver that is the `first` one of its path or not,
    /// in sr⁻¹: that of its candidate, or with the probability that the emitter is chosen.
    #[must_use]
    pub fn pdf_toward(
        &self,
        emitters: &[Box<dyn Emitter>],
        emitter: usize,
        receiver: &Receiver,
        first: bool,
        sight: &Sight<'_>,
    ) -> f32 {
        let pdf = emitters[emitter].pdf_toward(sight);
        let (part, part_pdf) = emitters[emitter].part_pdf_toward(sight);
        let seen = AreaPdf::<f32> { part: [part as u32], pdf, part_pdf };
        self.pdf_each(&[emitter as u32], &seen, &(*receiver).into(), first)
    }

    #[inline(always)]
    fn pdf_each<R: Real>(
        &self,
        emitters: &R::Each<u32>,
        of_areas: &AreaPdf<R>,
        receivers: &Receivers<R>,
        first: R::Mask,
    ) -> R {
        let Some((candidates, here)) = self.candidates(receivers, first) else {
            return self.choice.pdf_each(emitters, of_areas, receivers);
        };
        let mut pdf = R::splat(of_areas.pdf.token(), 0.0);
        if here.any() {
            pdf = candidates.pdf_each(emitters, of_areas, receivers);
        }
        if !here.all() {
            let chosen = self.choice.pdf_each(emitters, of_areas, receivers);
            pdf = R::select(here, pdf, chosen);
        }
        pdf
    }
}
