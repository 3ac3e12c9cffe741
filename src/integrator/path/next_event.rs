//! Light that emitters send to the surfaces of paths: next-event estimation.

use super::{Path, Paths, Strategy};
use crate::emitter::{Emitter, EmitterSamples};
use crate::integrator::shading::Shading;
use crate::math::discrete::BELOW_ONE;
use crate::math::real::{Double, Float, Lanes, Mask, Real, Select};
use crate::math::vector::Vec3;
use crate::shape::Interaction;

impl Path {
    /// In each lane, samples of the light that emitters send to the surface and that is scattered back along the path, if
    /// nothing is between, and where it comes from; one exists where any may arrive. All that arrives is their sum: of
    /// two lights, one sample each at the first surface of a path, else one.
    #[inline(always)]
    pub(super) fn next_event<R: Real>(
        &self,
        emitters: &[Box<dyn Emitter>],
        interaction: &Interaction<R>,
        shading: &Shading<'_, R>,
        paths: &mut Paths<'_, R>,
        wanted: R::Mask,
    ) -> [EmitterSamples<R>; 2] {
        let token = wanted.token();
        let aside = paths.numbers;
        let u = paths.numbers.next_choice(wanted);
        let receivers = shading.receivers(interaction);
        let none = EmitterSamples::<R>::splat(token, None);
        let Some((candidates, here)) = self.lights.candidates(&receivers, paths.is_first) else {
            let choice = self.lights.choice();
            let chosen = choice.sample_toward_each(emitters, &receivers, u, wanted);
            return [self.scattered_back(chosen, shading, paths), none];
        };
        let (here, elsewhere) = (wanted & here, wanted & !here);
        let [mut light, mut second] = [none; 2];
        if here.any() {
            let mut resampled = Reservoir::new(none, aside.aside().widen());
            let is_both = here & self.lights.both::<R>(paths.is_first);
            for i in 0..candidates.count() {
                let mut candidate = candidates.sample_each(i, emitters, &receivers, u, here);
                if !candidate.exists.any() {
                    continue;
                }
                candidate = self.scattered_back(candidate, shading, paths);
                if i == 1 {
                    second = candidate;
                    second.exists &= is_both;
                    candidate.exists &= !is_both;
                }
                resampled.add(&candidate);
            }
            light = resampled.light();
        }
        if elsewhere.any() {
            let choice = self.lights.choice();
            let chosen = choice.sample_toward_each(emitters, &receivers, u, elsewhere);
            light = EmitterSamples::selected(
                elsewhere,
                self.scattered_back(chosen, shading, paths),
                light,
            );
        }
        [light, second]
    }

    /// What the surface scatters of the light back along the path, with the weight of having found the light that way.
    #[inline(always)]
    fn scattered_back<R: Real>(
        &self,
        mut light: EmitterSamples<R>,
        shading: &Shading<'_, R>,
        paths: &Paths<'_, R>,
    ) -> EmitterSamples<R> {
        let wo = shading.to_local(light.direction);
        let (value, pdf) = self.settings.directions.evaluate(shading, wo);
        let scattered = value.x.eq(0.0) & value.y.eq(0.0) & value.z.eq(0.0);
        light.exists &= !scattered & shading.sides_agree(wo, light.direction);
        light.weight = value.times(light.weight);
        if let Strategy::Mis(heuristic) = self.settings.strategy {
            let own = light.pdf * self.settings.emitter_samples as f32;
            let weight = heuristic.weight(own, paths.directions * pdf);
            light.weight = light.weight * R::select(light.pdf.gt(0.0), weight, 1.0);
        }
        light
    }
}

/// One of the samples that were seen, in proportion to what they bring (resampled importance sampling; Talbot, Cline and
/// Egbert, "Importance Resampling for Global Illumination", 2005), by one number.
struct Reservoir<R: Real> {
    kept: EmitterSamples<R>,
    /// What the kept one brings, and what all together bring: sums over the channels.
    own: R::Double,
    total: R::Double,
    /// What is left of the number, in `[0, 1)`.
    rest: R::Double,
}

impl<R: Real> Reservoir<R> {
    #[inline(always)]
    fn new(none: EmitterSamples<R>, number: R::Double) -> Self {
        let zero = R::Double::splat(number.token(), 0.0);
        Self { kept: none, own: zero, total: zero, rest: number }
    }

    #[inline(always)]
    fn add(&mut self, light: &EmitterSamples<R>) {
        let Vec3 { x, y, z } = light.weight.map(R::widen);
        let own = R::Double::select(light.exists, x + y + z, 0.0);
        self.total += own;
        let share = own / self.total;
        let is_nothing = own.eq(0.0);
        // What is infinite or NaN is kept, so that the sample is counted.
        let is_kept = !is_nothing & !self.rest.ge(share);
        let left = (self.rest - share) / (R::Double::splat(share.token(), 1.0) - share);
        let rest = R::Double::select(is_kept, self.rest / share, left);
        let rest = R::Double::select(rest.lt(BELOW_ONE), rest, BELOW_ONE);
        self.rest = R::Double::select(is_nothing, self.rest, rest);
        self.own = R::Double::select(is_kept, own, self.own);
        self.kept = EmitterSamples::selected(is_kept, *light, self.kept);
    }

    /// The kept one, for all of them.
    #[inline(always)]
    fn light(self) -> EmitterSamples<R> {
        let Self { mut kept, own, total, .. } = self;
        let factor = total / own;
        kept.weight = kept.weight.map(|channel| (channel.widen() * factor).narrow());
        kept
    }
}
