//! Multiple importance sampling: how two techniques that can choose the same direction share it.

use crate::math::real::Real;

/// How the two are weighted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MisHeuristic {
    /// In proportion to the densities.
    Balance,
    /// In proportion to their squares.
    Power,
}

impl MisHeuristic {
    /// What it is, for reports.
    pub(super) fn describe(self) -> &'static str {
        match self {
            Self::Balance => "by the balance heuristic",
            Self::Power => "by the power heuristic",
        }
    }
}

impl MisHeuristic {
    /// The weight of a technique that chose a direction with density `own`, where another could have
    /// chosen it with density `other` (both in sr⁻¹, times the number of samples of the technique). The two
    /// weights sum to 1.
    ///
    /// Veach and Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering" (1995),
    /// equations 9 and 10. Written with the quotient of the densities, whose square
    /// underflows to 0 or overflows to infinity where the squares of both would give 0/0 or ∞/∞.
    #[inline(always)]
    #[must_use]
    pub fn weight<R: Real>(self, own: R, other: R) -> R {
        let ratio = other / own;
        let ratio = match self {
            Self::Balance => ratio,
            Self::Power => ratio * ratio,
        };
        R::select(own.gt(0.0), (ratio + 1.0).recip(), 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs whose squares leave the range of f32.
    #[test]
    fn power_heuristic_holds_at_the_extremes() {
        for (own, other, expected) in [
            (1e30, 1.0, 1.0),
            (2e19, 2e19, 0.5),
            (1e-23, 2e-23, 0.2),
            (0.0, 1.0, 0.0),
            (1.0, 0.0, 1.0),
            (f32::INFINITY, 1.0, 1.0),
            (0.0, 0.0, 0.0),
        ] {
            assert_eq!(MisHeuristic::Power.weight::<f32>(own, other), expected, "({own}, {other})");
        }
    }

    /// One rounding of the quotient, of its square, of the sum and of the division in each weight.
    #[test]
    fn weights_sum_to_one() {
        for heuristic in [MisHeuristic::Balance, MisHeuristic::Power] {
            for i in -60..60 {
                let other = 1.3f32.powi(i);
                let sum = heuristic.weight::<f32>(1.0, other) + heuristic.weight(other, 1.0);
                assert!((sum - 1.0).abs() < 8.0 * f32::EPSILON, "{heuristic:?} {other}: {sum}");
            }
        }
    }
}
