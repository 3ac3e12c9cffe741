//! A choice among a finite number of things.

use glam::{DVec2, Vec2};

use super::real::{Float, Lanes, Mask, Real};

/// A discrete distribution proportional to given weights, by inversion of its prefix sums.
#[derive(Clone, Debug)]
pub struct Discrete {
    /// `cumulative[i]` is the probability of an index below `i`; one entry more than weights.
    /// In f64, because a sum of a million f32 areas loses the small ones.
    cumulative: Vec<f64>,
    total: f64,
}

impl Discrete {
    /// `None` if there is no weight above 0, or one that is negative or not finite.
    #[must_use]
    pub fn new(weights: &[f64]) -> Option<Self> {
        if !weights.iter().all(|&w| w >= 0.0 && w.is_finite()) {
            return None;
        }
        let total: f64 = weights.iter().sum();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let mut cumulative = Vec::with_capacity(weights.len() + 1);
        let mut sum = 0.0;
        cumulative.push(0.0);
        for w in weights {
            sum += w;
            cumulative.push(sum / total);
        }
        Some(Self { cumulative, total })
    }

    /// Sum of the weights.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.total
    }

    /// Probability of `index`; 0 outside the range.
    #[must_use]
    pub fn probability(&self, index: usize) -> f64 {
        match self.cumulative.get(index..index + 2) {
            Some(&[low, high]) => high - low,
            _ => 0.0,
        }
    }

    /// The index chosen by `u` in `[0, 1)`. Never one of probability 0. What is chosen with a probability near
    /// the spacing of the numbers is chosen too often or never, so `u` has more bits than an f32.
    #[must_use]
    pub fn sample(&self, u: f64) -> Choice {
        if self.cumulative.len() == 2 {
            return Choice { index: 0, probability: 1.0, rest: u };
        }
        // The first entry above u, less one: its share is not empty, since it holds u.
        let last = self.cumulative.len() - 2;
        let mut index = match self.cumulative[..] {
            // A rectangle's two triangles.
            [_, middle, _] => usize::from(middle <= u),
            _ => self.cumulative[1..].partition_point(|&c| c <= u).min(last),
        };
        // Rounding may have left the last sum below u; the last share may then be empty.
        while self.probability(index) <= 0.0 && index > 0 {
            index -= 1;
        }
        let probability = self.probability(index);
        let rest = (u - self.cumulative[index]) / probability;
        Choice { index, probability, rest: rest.clamp(0.0, BELOW_ONE) }
    }
}

impl Discrete {
    /// [`Discrete::sample`] in each lane: of two together, of more lane by lane.
    #[inline(always)]
    #[must_use]
    pub fn sample_each<R: Real>(&self, u: R::Double) -> Choices<R> {
        let token = u.token();
        match self.cumulative[..] {
            [_, _] => Choices {
                index: R::each(|_| 0),
                probability: R::Double::splat(token, 1.0),
                rest: u,
            },
            [_, middle, last] if 0.0 < middle && middle < last => {
                let second = u.ge(middle);
                let choose = |yes, no| R::Double::select(second, yes, no);
                let probability = choose(last - middle, middle);
                let rest = (u - choose(middle, 0.0)) / probability;
                Choices {
                    index: R::each(|i| second.lane(i).into()),
                    probability,
                    rest: R::Double::select(rest.lt(BELOW_ONE), rest, BELOW_ONE),
                }
            }
            _ => Choices::from_fn(token, |i| self.sample(u.lane(i))),
        }
    }
}

/// A [`Choice`] in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Choices<R: Real> {
    /// See [`Choice::index`].
    pub index: R::Each<u32>,
    /// See [`Choice::probability`].
    pub probability: R::Double,
    /// See [`Choice::rest`].
    pub rest: R::Double,
}

impl<R: Real> Choices<R> {
    /// What `choice` says of each lane.
    #[inline(always)]
    #[must_use]
    pub fn from_fn(token: R::Token, choice: impl FnMut(usize) -> Choice) -> Self {
        let choices = R::each(choice);
        let choices = choices.as_ref();
        Self {
            index: R::each(|i| choices[i].index as u32),
            probability: R::Double::from_fn(token, |i| choices[i].probability),
            rest: R::Double::from_fn(token, |i| choices[i].rest),
        }
    }
}

/// What [`Discrete::sample`] chose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Which of the weights.
    pub index: usize,
    /// Its probability.
    pub probability: f64,
    /// The number rescaled to `[0, 1)` within its share, so that one number serves the choice and what
    /// comes after it.
    pub rest: f64,
}

/// The largest f32 below 1: the largest value that a sample of `[0, 1)` may have.
pub const ONE_MINUS_ULP: f32 = 1.0 - f32::EPSILON / 2.0;

/// The largest f64 below 1.
pub const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// Numbers in `[0, 1)`, rounded to f32 without becoming 1.
#[must_use]
pub fn round_below_one(u: DVec2) -> Vec2 {
    u.as_vec2().min(Vec2::splat(ONE_MINUS_ULP))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rejects_what_is_no_distribution() {
        for weights in [&[][..], &[0.0, 0.0], &[1.0, -1e-9], &[f64::NAN], &[f64::INFINITY]] {
            assert!(Discrete::new(weights).is_none(), "{weights:?}");
        }
    }

    #[test]
    fn chooses_only_what_has_weight() {
        let mut weights = vec![0.0; 1_000_000];
        weights[271_828] = 1.0;
        let d = Discrete::new(&weights).expect("one positive weight");
        for u in [0.0, 1e-30, 0.5, ONE_MINUS_ULP.into()] {
            let Choice { index, rest, .. } = d.sample(u);
            assert_eq!(index, 271_828);
            assert_eq!(rest, u, "a share of 1 leaves the number as it was");
        }
        assert_eq!(d.probability(271_828), 1.0);
        assert_eq!(d.probability(0), 0.0);
        assert_eq!(d.probability(1_000_000), 0.0);
    }

    /// In one lane by both ways; eight are compared with one in `tests/lanes`.
    #[test]
    fn both_forms_choose_the_same() {
        for weights in [&[2.0][..], &[1.0, 3.0], &[0.0, 3.0], &[3.0, 0.0], &[1.0, 0.0, 2.0, 5.0]] {
            let d = Discrete::new(weights).expect("positive weights");
            for u in [0.0, 1e-300, 0.1, 0.25, 0.25 - 1e-17, 0.3, 0.9, BELOW_ONE] {
                let Choices { index, probability, rest } = d.sample_each::<f32>(u);
                let each = Choice { index: index[0] as usize, probability, rest };
                assert_eq!(each, d.sample(u), "{weights:?} {u}");
            }
        }
    }

    #[test]
    fn shares_are_as_long_as_the_weights() {
        let d = Discrete::new(&[1.0, 0.0, 3.0]).expect("positive weights");
        assert_eq!(d.total(), 4.0);
        let choice = |index, probability, rest| Choice { index, probability, rest };
        assert_eq!(d.sample(0.125), choice(0, 0.25, 0.5));
        assert_eq!(d.sample(0.25), choice(2, 0.75, 0.0));
        assert_eq!(d.sample(0.625), choice(2, 0.75, 0.5));
        assert_eq!(d.sample(ONE_MINUS_ULP.into()).index, 2);
    }
}
