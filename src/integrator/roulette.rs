//! Russian roulette.

use crate::math::Rgb;

/// Russian roulette: when a path ends by chance, and with what probability it goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roulette {
    /// Where the survival probability comes from.
    pub policy: RoulettePolicy,
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

impl Default for Roulette {
    /// Mitsuba's default depth, and the lecture's clamp.
    fn default() -> Self {
        Self { policy: RoulettePolicy::Throughput, min_depth: 5, max_survival: 0.99 }
    }
}

impl Roulette {
    /// Plays for a path of `edges` edges: the factor by which its throughput is to be multiplied if it
    /// goes on, `None` if it ends.
    ///
    /// `throughput` is the path's own, undone of the scaling by squared refractive indices. Only the 1/p
    /// of this step compensates. `u` in `[0, 1)` is drawn only where chance decides.
    pub(super) fn play(&self, edges: u32, throughput: Rgb, u: impl FnOnce() -> f32) -> Option<f32> {
        let largest = throughput.max_element();
        // Nothing left to carry, or no number.
        if largest.is_nan() || largest <= 0.0 {
            return None;
        }
        let survival = match self.policy {
            _ if edges < self.min_depth => return Some(1.0),
            RoulettePolicy::None => return Some(1.0),
            RoulettePolicy::Fixed(p) => p,
            RoulettePolicy::Throughput => largest,
        }
        .min(self.max_survival);
        // Below the normal range 1/p would be infinite.
        (survival >= f32::MIN_POSITIVE && u() < survival).then(|| 1.0 / survival)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const THROUGHPUT: Roulette =
        Roulette { policy: RoulettePolicy::Throughput, min_depth: 3, max_survival: 0.99 };

    fn no_draw() -> f32 {
        panic!("no number was needed")
    }

    #[test]
    fn short_paths_go_on_without_a_draw() {
        assert_eq!(THROUGHPUT.play(2, Rgb::splat(0.1), no_draw), Some(1.0));
        let none = Roulette { policy: RoulettePolicy::None, ..THROUGHPUT };
        assert_eq!(none.play(100, Rgb::splat(0.1), no_draw), Some(1.0));
    }

    #[test]
    fn the_factor_is_the_inverse_of_this_steps_probability() {
        let dim = Rgb::new(0.1, 0.25, 0.2);
        assert_eq!(THROUGHPUT.play(3, dim, || 0.249), Some(4.0));
        assert_eq!(THROUGHPUT.play(3, dim, || 0.25), None);
        let fixed = Roulette { policy: RoulettePolicy::Fixed(0.5), ..THROUGHPUT };
        assert_eq!(fixed.play(3, dim, || 0.499), Some(2.0));
        assert_eq!(fixed.play(3, dim, || 0.5), None);
    }

    #[test]
    fn survival_is_clamped_where_throughput_exceeds_one() {
        assert_eq!(THROUGHPUT.play(3, Rgb::splat(2.25), || 0.98), Some(1.0 / 0.99));
        assert_eq!(THROUGHPUT.play(3, Rgb::splat(2.25), || 0.99), None);
    }

    #[test]
    fn paths_that_carry_nothing_end() {
        assert_eq!(THROUGHPUT.play(0, Rgb::ZERO, no_draw), None);
        assert_eq!(THROUGHPUT.play(3, Rgb::splat(1e-39), no_draw), None);
        assert_eq!(THROUGHPUT.play(0, Rgb::NAN, no_draw), None);
    }
}
