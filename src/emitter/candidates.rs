//! One candidate for light from each of a few lights.

use super::area::AreaPdf;
use super::parts::Among;
use super::{Area, Emitter, EmitterSamples, LightChoices, Receivers};
use crate::math::real::{Double, Lanes, Mask, Real};
use crate::math::vector::Vec2;

/// A few lights, each of which is asked for a candidate: a direction with the density that the light has by itself.
#[derive(Clone, Debug)]
pub struct Candidates {
    lights: Vec<Candidate>,
}

/// A light.
#[derive(Clone, Debug)]
struct Candidate {
    emitter: u32,
    /// A choice among its parts, if it has several.
    parts: Option<Among>,
}

/// More lights than this are chosen from before anything is known of the directions.
const MOST: usize = 16;

impl Candidates {
    /// Those of the `emitters` that may be chosen, with their powers. `None` if there is no choice, or too many to ask all
    /// of them.
    pub(super) fn new(emitters: &[Box<dyn Emitter>], powers: &[Option<f64>]) -> Option<Self> {
        let lit: Vec<_> = lit(powers).collect();
        if !(2..=MOST).contains(&lit.len()) {
            return None;
        }
        let light = |emitter: u32| Candidate {
            emitter,
            parts: Among::new(&emitters[emitter as usize].parts()),
        };
        Some(Self { lights: lit.into_iter().map(light).collect() })
    }

    /// How many there are, at least 2.
    #[must_use]
    pub fn count(&self) -> usize {
        self.lights.len()
    }

    /// The candidate of one of the lights in each lane where it is `wanted`, chosen by `u` in `[0, 1)²`; weight and
    /// density are those of the light by itself.
    #[inline(always)]
    #[must_use]
    pub fn sample_each<R: Real>(
        &self,
        light: usize,
        emitters: &[Box<dyn Emitter>],
        receivers: &Receivers<R>,
        u: Vec2<R::Double>,
        wanted: R::Mask,
    ) -> EmitterSamples<R> {
        let Candidate { emitter, parts } = &self.lights[light];
        let emitter = emitters[*emitter as usize].as_ref();
        let Some(parts) = parts else {
            let mut samples = sample::<R>(emitter, None, receivers, u);
            samples.exists &= wanted;
            return samples;
        };
        let LightChoices { exists, light, probability, rest } = parts.sample(receivers, u.x);
        let u = Vec2::new(rest, u.y);
        let samples = sample::<R>(emitter, Some(light), receivers, u);
        samples.chosen(wanted & exists, probability)
    }

    /// Density with which what is seen of emitters is their candidate, for the densities with which their directions,
    /// or those of their parts, are chosen.
    #[inline(always)]
    pub(super) fn pdf_each<R: Real>(
        &self,
        emitters: &R::Each<u32>,
        of_areas: &AreaPdf<R>,
        receivers: &Receivers<R>,
    ) -> R {
        let token = of_areas.pdf.token();
        let mut pdf = R::splat(token, 0.0);
        for Candidate { emitter, parts } in &self.lights {
            let is_this = R::mask(token, |i| emitters.as_ref()[i] == *emitter);
            if !is_this.any() {
                continue;
            }
            let own = match parts {
                None => of_areas.pdf,
                Some(parts) => {
                    let share = parts.probability(receivers, &of_areas.part);
                    share.narrow() * of_areas.part_pdf
                }
            };
            pdf = R::select(is_this, own, pdf);
        }
        pdf
    }

    /// The same of an emitter without parts, if it is asked for the direction with density `pdf`.
    #[inline(always)]
    pub(super) fn pdf_of_emitter<R: Real>(&self, emitter: usize, pdf: R) -> R {
        let is_one = self.lights.iter().any(|light| light.emitter as usize == emitter);
        if is_one { pdf } else { R::splat(pdf.token(), 0.0) }
    }
}

/// Those of the emitters with these powers that may be chosen.
pub(super) fn lit(powers: &[Option<f64>]) -> impl Iterator<Item = u32> {
    let lit = (0..).zip(powers).filter(|(_, power)| power.is_none_or(|power| power > 0.0));
    lit.map(|(emitter, _)| emitter)
}

/// A direction to an emitter, or to a part of it, in each lane.
#[inline(always)]
fn sample<R: Real>(
    emitter: &dyn Emitter,
    part: Option<R::Each<u32>>,
    receivers: &Receivers<R>,
    u: Vec2<R::Double>,
) -> EmitterSamples<R> {
    let Some(area) = emitter.area() else {
        return emitter.sample::<R>(part, receivers.position, u);
    };
    let (areas, parts) = (R::each(|_| area), R::each(|i| part.map(|part| part.as_ref()[i])));
    // By itself, as it is long.
    R::vectorize(
        u.token(),
        #[inline(always)]
        || Area::sample(&areas, &parts, receivers.position, u),
    )
}
