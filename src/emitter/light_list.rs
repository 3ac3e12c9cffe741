//! A choice among a few lights by weighing each of them.

use super::importance::LightBounds;
use super::{EmitterBounds, LightChoices, Receivers};
use crate::math::discrete::BELOW_ONE;
use crate::math::real::{Float, Lanes, Mask, Real, Uint};

/// A list of lights, chosen mostly in proportion to their importance for the receiver, and else all alike.
///
/// All lanes weigh a light at once, and walk down a [`LightBvh`](super::LightBvh) one after the other: with 32 lamps in a
/// room, paths take 0.85 of the instructions that they take with the tree.
#[derive(Clone, Debug)]
pub(super) struct LightList {
    /// Those that shine, with their indices.
    lights: Vec<(u32, LightBounds)>,
}

/// More lights make a tree.
const MOST: usize = 32;

/// How often lights that can be of use are chosen all alike at glossy surfaces: the irradiance that a light may cause says little
/// of what is reflected of it. Of the error of a choice by importance alone this leaves 0.6 in Veach's scene of four plates
/// under lamps of very different power and 0.84 to 0.94 in glossy rooms of 8 to 32 lamps; in diffuse ones it would leave
/// 1.5 to 1.9.
const ALIKE: f64 = 0.25;

/// The same at diffuse surfaces, in case that the light which would bring most is hidden.
const ALIKE_DIFFUSE: f64 = 0.03125;

impl LightList {
    /// A list of the lights of these bounds that have an intensity. `None` if there are none, or so many that a tree
    /// is better.
    pub(super) fn new(lights: &[EmitterBounds]) -> Option<Self> {
        let total: f64 = lights.iter().map(|bounds| bounds.intensity).sum();
        let bright = (0..).zip(lights).filter(|(_, bounds)| bounds.intensity > 0.0);
        let share = |bounds: &EmitterBounds| EmitterBounds {
            intensity: bounds.intensity / total,
            ..*bounds
        };
        let lights: Vec<_> =
            bright.map(|(light, bounds)| (light, LightBounds::new(&share(bounds)))).collect();
        (1..=MOST).contains(&lights.len()).then_some(Self { lights })
    }

    /// The weight of each light, and their sum.
    #[inline(always)]
    fn weigh<R: Real>(
        &self,
        receivers: &Receivers<R>,
        weights: &mut [R::Double; MOST],
    ) -> R::Double {
        let token = receivers.normal.token();
        let weights = &mut weights[..self.lights.len()];
        let zero = R::Double::splat(token, 0.0);
        let (mut sum, mut useful) = (zero, zero);
        for ((_, bounds), weight) in self.lights.iter().zip(weights.iter_mut()) {
            *weight = bounds.importance(receivers);
            sum += *weight;
            useful += R::Double::select(weight.gt(0.0), 1.0, 0.0);
        }
        let ratio = |share: f64| share / (1.0 - share);
        let ratio = R::Double::select(
            receivers.is_diffuse,
            R::Double::splat(token, ratio(ALIKE_DIFFUSE)),
            ratio(ALIKE),
        );
        // NaN where no light is of use, and there not needed.
        let alike = sum * ratio / useful;
        let mut total = zero;
        for weight in weights {
            *weight = R::Double::select(weight.gt(0.0), *weight + alike, 0.0);
            total += *weight;
        }
        total
    }

    /// A light in each lane, chosen by `u` in `[0, 1)`; none where none can be of use to the receiver.
    #[inline(always)]
    pub(super) fn sample<R: Real>(
        &self,
        receivers: &Receivers<R>,
        u: R::Double,
    ) -> LightChoices<R> {
        let token = u.token();
        let zero = R::Double::splat(token, 0.0);
        let mut weights = [zero; MOST];
        let total = self.weigh(receivers, &mut weights);
        let target = u * total;
        let (mut below, mut low, mut width) = (zero, zero, zero);
        let mut light = R::Uint::splat(token, 0);
        let mut is_found = R::Mask::splat(token, false);
        // Rounding may leave the last sum below the target; then it is the last one that has a weight.
        for ((number, _), weight) in self.lights.iter().zip(&weights) {
            let is_here = !is_found & weight.gt(0.0);
            light = R::Uint::select(is_here, *number, light);
            low = R::Double::select(is_here, below, low);
            width = R::Double::select(is_here, *weight, width);
            below += *weight;
            is_found |= is_here & target.lt(below);
        }
        let rest = (target - low) / width;
        LightChoices {
            exists: total.gt(0.0),
            light: R::each(|i| light.lane(i)),
            probability: width / total,
            rest: R::Double::select(rest.lt(BELOW_ONE), rest, BELOW_ONE),
        }
    }

    /// Probability with which [`LightList::sample`] chooses each lane's light.
    #[inline(always)]
    pub(super) fn probability<R: Real>(
        &self,
        receivers: &Receivers<R>,
        lights: &R::Each<u32>,
    ) -> R::Double {
        let token = receivers.normal.token();
        let zero = R::Double::splat(token, 0.0);
        let mut weights = [zero; MOST];
        let total = self.weigh(receivers, &mut weights);
        let wanted = R::Uint::from_fn(token, |i| lights.as_ref()[i]);
        let mut own = zero;
        for ((number, _), weight) in self.lights.iter().zip(&weights) {
            own = R::Double::select(wanted.eq(*number), *weight, own);
        }
        R::Double::select(total.gt(0.0), own / total, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::light_bvh::tests::{lights, numbers, receivers};
    use super::*;
    use crate::emitter::LightBvh;

    /// Each light that a tree would choose is chosen too, as often as it says, and no other.
    #[test]
    fn probabilities_are_those_of_samples_and_sum_to_one() {
        let lights = lights(MOST);
        let list = LightList::new(&lights).expect("some shine");
        let bvh = LightBvh::new(&lights).expect("some shine");
        let (mut chosen, mut none) = (0, 0);
        for receiver in receivers().take(500) {
            let receivers = Receivers::from(receiver);
            let probability = |light| list.probability::<f32>(&receivers, &[light]);
            let all: Vec<_> = (0..MOST as u32).map(probability).collect();
            let sum: f64 = all.iter().sum();
            // One rounding of each share.
            let rounding = MOST as f64 * f64::EPSILON;
            let alike = if receiver.is_diffuse { ALIKE_DIFFUSE } else { ALIKE };
            let least = alike / MOST as f64 * (1.0 - rounding);
            for (light, &share) in all.iter().enumerate() {
                let in_tree = bvh.probability(&receiver, light) > 0.0;
                assert!(share >= least || share == 0.0 && !in_tree, "{light}: {share}");
            }
            // Intervals of the number are as long as the shares, one after the other.
            let (mut light, mut below) = (0, 0.0);
            let mut sorted: Vec<_> = numbers().take(200).map(f64::from).collect();
            sorted.sort_by(f64::total_cmp);
            for u in sorted {
                let choice = list.sample::<f32>(&receivers, u);
                if sum == 0.0 {
                    assert!(!choice.exists);
                    none += 1;
                    continue;
                }
                assert!((sum - 1.0).abs() <= rounding, "{sum}");
                while u >= below + all[light] + rounding {
                    below += all[light];
                    light += 1;
                }
                let near = (u - below - all[light]).abs() <= rounding;
                assert!(choice.light[0] as usize == light || near, "{u}");
                assert_eq!(choice.probability, all[choice.light[0] as usize]);
                assert!((0.0..1.0).contains(&choice.rest));
                chosen += 1;
            }
        }
        assert!(chosen > 50_000 && none > 100, "{chosen} {none}");
    }

    #[test]
    fn none_and_many_make_no_list() {
        assert!(LightList::new(&[]).is_none());
        assert!(LightList::new(&lights(4 * MOST)).is_none());
    }
}
