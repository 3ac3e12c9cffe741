//! Russian roulette.

use super::knobs::{Needs, Turned};
use super::plugin::MOST_EDGES;
use super::settings::Reason;
use crate::math::real::{Mask, Real};
use crate::math::vector::Vec3;
use crate::property::{
    self, At, Bounds, Given, Kind, Nothing, PropertyInfo, Refusal, Value, property,
};

/// Russian roulette: when a path ends by chance, and with what probability it goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roulette {
    /// Where the survival probability comes from.
    pub policy: RoulettePolicy,
    /// What the throughput is multiplied by to be the survival probability, if that follows it: paths go on more often than
    /// in proportion to what they carry, since what they meet is not known yet.
    pub factor: f32,
    /// Paths with fewer edges than this always go on.
    pub min_depth: u32,
    /// Largest survival probability, so that every path ends.
    pub max_survival: f32,
}

/// Where the survival probability comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RoulettePolicy {
    /// Every path goes on.
    None,
    /// The same for all.
    Fixed(f32),
    /// The path's throughput.
    Throughput,
}

/// With the factor 3 of [`RR_FACTOR`], against Mitsuba's 5 and a factor of 1: efficiency 1.25 in a Cornell box with glass, 1.11
/// in one without, 1.04 for a dragon under a lamp, and as before where paths are short.
pub(super) const RR_DEPTH: PropertyInfo = property(
    "rr_depth",
    Kind::Integer(1, MOST_EDGES),
    property::Default::Integer(3),
    "paths with fewer edges are not ended by Russian roulette",
);

const THROUGHPUT: &str = "throughput";
const FIXED: &str = "fixed";
const NONE: &str = "none";

pub(super) const RR_POLICY: PropertyInfo = property(
    "rr_policy",
    Kind::Choice(&[THROUGHPUT, FIXED, NONE]),
    property::Default::Text(THROUGHPUT),
    "where the probability to go on comes from",
);

pub(super) const RR_SURVIVAL: PropertyInfo = property(
    "rr_survival",
    Kind::Float(Bounds::Probability),
    property::Default::Absent("required by rr_policy `fixed`"),
    "probability to go on of rr_policy `fixed`",
);

/// The lecture's clamp.
pub(super) const RR_MAX_SURVIVAL: PropertyInfo = property(
    "rr_max_survival",
    Kind::Float(Bounds::Probability),
    property::Default::Float(0.99),
    "largest probability to go on of rr_policy `throughput`",
);

/// See [`RR_DEPTH`].
pub(super) const RR_FACTOR: PropertyInfo = property(
    "rr_factor",
    Kind::Float(Bounds::AtLeastOne),
    property::Default::Float(3.0),
    "what rr_policy `throughput` multiplies the throughput by (not in Mitsuba, where it is 1)",
);

/// What [`Roulette::turn_policy`] takes.
pub(super) const POLICY_WORDS: &str =
    "none, throughput, or fixed:P with a probability P above 0, up to 1";

pub(super) const THROUGHPUT_NEEDS: Needs = Needs::Reason("only `rr_policy=throughput` has it");

/// What [`Roulette::turn_min_depth`] takes: also 0, which is as good as 1, since every path has an edge.
pub(super) const MIN_DEPTH_WORDS: &str = "a whole number from 0";

pub(super) const MIN_DEPTH_NEEDS: Needs =
    Needs::Reason("only `rr_policy=throughput` and `rr_policy=fixed:P` have it");

impl Roulette {
    /// As it was told.
    ///
    /// # Errors
    /// A probability that the policy does not have, or one that it needs and was not told.
    pub(super) fn read(told: &dyn Given) -> Result<Self, Refusal> {
        let policy = match told.choice(&RR_POLICY) {
            FIXED => {
                let p = told.number(&RR_SURVIVAL).ok_or_else(|| {
                    Refusal::new(
                        At::Value(RR_POLICY.name),
                        "rr_policy `fixed` needs the property `rr_survival`",
                    )
                })?;
                RoulettePolicy::Fixed(p as f32)
            }
            NONE => RoulettePolicy::None,
            _ => RoulettePolicy::Throughput,
        };
        if !matches!(policy, RoulettePolicy::Fixed(_)) {
            Refusal::if_given(told, &[&RR_SURVIVAL], "unless `rr_policy` is `fixed`")?;
        }
        if policy != RoulettePolicy::Throughput {
            let of_throughput = [&RR_MAX_SURVIVAL, &RR_FACTOR];
            Refusal::if_given(told, &of_throughput, "unless `rr_policy` is `throughput`")?;
        }
        let max_survival = match policy {
            // A fixed probability is what the file asks for, up to 1.
            RoulettePolicy::Fixed(_) => None,
            _ => told.number(&RR_MAX_SURVIVAL),
        };
        let max_survival = max_survival.map_or(1.0, |p| p as f32);
        let factor = told.number(&RR_FACTOR).map_or(1.0, |factor| factor as f32);
        Ok(Self { policy, factor, min_depth: told.count(&RR_DEPTH), max_survival })
    }

    /// What would let a path between white walls go on for ever: the property that says so, and how.
    pub(super) fn never_ends(&self) -> Option<(&'static PropertyInfo, &'static str)> {
        match self.policy {
            RoulettePolicy::None => Some((&RR_POLICY, "`rr_policy` is `none`")),
            RoulettePolicy::Fixed(p) if p >= 1.0 => Some((&RR_SURVIVAL, "`rr_survival` is 1")),
            RoulettePolicy::Throughput if self.max_survival >= 1.0 => {
                Some((&RR_MAX_SURVIVAL, "`rr_max_survival` is 1"))
            }
            RoulettePolicy::Fixed(_) | RoulettePolicy::Throughput => None,
        }
    }

    /// Changes the policy, each with the factor and the largest probability that scene files give it.
    pub(super) fn turn_policy(&mut self, text: &str) -> Turned {
        let Self { max_survival, factor, .. } = Self::default();
        let fixed = text.strip_prefix(FIXED).and_then(|rest| rest.strip_prefix(':'));
        let fixed = fixed.and_then(|p| RR_SURVIVAL.kind.parse(p)).map(Value::number);
        let (policy, max_survival) = match (text, fixed) {
            (NONE, _) => (RoulettePolicy::None, max_survival),
            (THROUGHPUT, _) => (RoulettePolicy::Throughput, max_survival),
            (_, Some(p)) => (RoulettePolicy::Fixed(p), 1.0),
            _ => return Turned::Bad,
        };
        // A policy that stays keeps what the scene says of it.
        if self.policy != policy {
            *self = Self { policy, max_survival, factor, ..*self };
        }
        Turned::Done
    }

    /// Changes the largest probability, if the policy has one.
    pub(super) fn turn_max_survival(&mut self, value: Value) -> bool {
        let used = self.policy == RoulettePolicy::Throughput;
        if used {
            self.max_survival = value.number();
        }
        used
    }

    /// Changes the factor, if the policy has one.
    pub(super) fn turn_factor(&mut self, value: Value) -> bool {
        let used = self.policy == RoulettePolicy::Throughput;
        if used {
            self.factor = value.number();
        }
        used
    }

    /// Changes where it begins, if it does.
    pub(super) fn turn_min_depth(&mut self, text: &str) -> Turned {
        let Some(value) = Kind::Integer(0, MOST_EDGES).parse(text) else {
            return Turned::Bad;
        };
        let used = self.policy != RoulettePolicy::None;
        if used {
            self.min_depth = value.count();
        }
        Turned::if_used(used)
    }

    /// How it is played for paths of at most `max_depth` edges.
    pub(super) fn reason(&self, max_depth: Option<u32>) -> Reason {
        let survival = match self.policy {
            RoulettePolicy::None => {
                return Err("the integrator's policy is to play none".to_owned());
            }
            RoulettePolicy::Fixed(p) => format!("{p}"),
            RoulettePolicy::Throughput if self.factor == 1.0 => "the path's throughput".to_owned(),
            RoulettePolicy::Throughput => format!("{} times the path's throughput", self.factor),
        };
        match max_depth {
            Some(max) if max <= self.min_depth => {
                Err(format!("paths end at {max} edges, before it begins"))
            }
            _ => Ok(format!(
                "from edge {} on, survival by {survival}, at most {}",
                self.min_depth.max(1),
                self.max_survival
            )),
        }
    }
}

impl Default for Roulette {
    fn default() -> Self {
        Self::read(&Nothing).expect("the defaults go together")
    }
}

impl Roulette {
    /// Plays for paths: the factors by which their throughputs are to be multiplied, and which of them go on. Those of fewer
    /// than [`Roulette::min_depth`] edges are `young`.
    ///
    /// `throughput` is the path's own, undone of the scaling by squared refractive indices. Only the 1/p
    /// of this step compensates. Numbers in `[0, 1)` are drawn only where chance decides.
    #[inline(always)]
    pub(super) fn play<R: Real>(
        &self,
        young: R::Mask,
        throughput: Vec3<R>,
        draw: impl FnOnce(R::Mask) -> R,
    ) -> (R, R::Mask) {
        let token = young.token();
        let Vec3 { x, y, z } = throughput;
        let largest = x.max(y).max(z);
        // Something is left to carry, and it is a number.
        let carries = x.eq(x) & y.eq(y) & z.eq(z) & largest.gt(0.0);
        let survival = match self.policy {
            RoulettePolicy::None => return (R::splat(token, 1.0), carries),
            RoulettePolicy::Fixed(p) => R::splat(token, p),
            RoulettePolicy::Throughput => largest * self.factor,
        };
        let survival = survival.min(self.max_survival);
        // Below the normal range 1/p would be infinite.
        let plays = carries & !young & survival.ge(f32::MIN_POSITIVE);
        let mut goes_on = carries & young;
        if plays.any() {
            goes_on |= plays & draw(plays).lt(survival);
        }
        (R::select(young, 1.0, survival.recip()), goes_on)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;

    const THROUGHPUT: Roulette = Roulette {
        policy: RoulettePolicy::Throughput,
        factor: 1.0,
        min_depth: 3,
        max_survival: 0.99,
    };

    /// What becomes of one path.
    fn play(
        roulette: Roulette,
        edges: u32,
        throughput: Rgb,
        draw: impl FnOnce() -> f32,
    ) -> Option<f32> {
        let young = edges < roulette.min_depth;
        let (factor, goes_on) = roulette.play::<f32>(young, throughput.into(), |_| draw());
        goes_on.then_some(factor)
    }

    fn no_draw() -> f32 {
        panic!("no number was needed")
    }

    #[test]
    fn short_paths_go_on_without_a_draw() {
        assert_eq!(play(THROUGHPUT, 2, Rgb::splat(0.1), no_draw), Some(1.0));
        let none = Roulette { policy: RoulettePolicy::None, ..THROUGHPUT };
        assert_eq!(play(none, 100, Rgb::splat(0.1), no_draw), Some(1.0));
    }

    #[test]
    fn the_factor_is_the_inverse_of_this_steps_probability() {
        let dim = Rgb::new(0.1, 0.25, 0.2);
        assert_eq!(play(THROUGHPUT, 3, dim, || 0.249), Some(4.0));
        assert_eq!(play(THROUGHPUT, 3, dim, || 0.25), None);
        let fixed = Roulette { policy: RoulettePolicy::Fixed(0.5), ..THROUGHPUT };
        assert_eq!(play(fixed, 3, dim, || 0.499), Some(2.0));
        assert_eq!(play(fixed, 3, dim, || 0.5), None);
    }

    #[test]
    fn paths_go_on_more_often_by_the_factor() {
        let thrice = Roulette { factor: 3.0, ..THROUGHPUT };
        let dim = Rgb::new(0.1, 0.25, 0.2);
        assert_eq!(play(thrice, 3, dim, || 0.749), Some(1.0 / 0.75));
        assert_eq!(play(thrice, 3, dim, || 0.75), None);
        assert_eq!(play(thrice, 3, 2.0 * dim, || 0.98), Some(1.0 / 0.99));
        let fixed = Roulette { policy: RoulettePolicy::Fixed(0.25), ..thrice };
        assert_eq!(play(fixed, 3, dim, || 0.249), Some(4.0));
        assert_eq!(play(fixed, 3, dim, || 0.25), None);
    }

    #[test]
    fn survival_is_clamped_where_throughput_exceeds_one() {
        assert_eq!(play(THROUGHPUT, 3, Rgb::splat(2.25), || 0.98), Some(1.0 / 0.99));
        assert_eq!(play(THROUGHPUT, 3, Rgb::splat(2.25), || 0.99), None);
    }

    #[test]
    fn paths_that_carry_nothing_end() {
        assert_eq!(play(THROUGHPUT, 0, Rgb::ZERO, no_draw), None);
        assert_eq!(play(THROUGHPUT, 3, Rgb::splat(1e-39), no_draw), None);
        assert_eq!(play(THROUGHPUT, 0, Rgb::NAN, no_draw), None);
    }
}
