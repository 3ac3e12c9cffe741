//! Reconstruction filters, by importance sampling.
//!
//! A sample's position is drawn in proportion to the filter around its pixel and its value then counts
//! with weight 1 for this pixel alone (Ernst, Stamminger and Greiner, "Filter Importance Sampling",
//! 2006). No sample is shared between pixels: their noise stays uncorrelated, the estimate unbiased,
//! and no pixel depends on the order in which threads finish.

use glam::Vec2;

use crate::math::discrete::ONE_MINUS_ULP;
use crate::scene::settings::Filter;

/// Draws positions in proportion to a filter.
#[derive(Clone, Debug)]
pub struct FilterSampler {
    profile: Profile,
}

/// A filter along one axis; the filter is the product of both axes' profiles.
#[derive(Clone, Debug)]
enum Profile {
    Box,
    Tent { radius: f32 },
    Tabulated { radius: f32, inverse: Vec<f32> },
}

/// Where a Gaussian is cut off, in standard deviations (as in Mitsuba).
const CUTOFF: f32 = 4.0;
/// Intervals of the tabulated inverse. Between its knots the position is interpolated, so what is
/// sampled differs from a Gaussian by a fraction of a thousandth of its width.
const INTERVALS: usize = 4096;

impl FilterSampler {
    /// A sampler of `filter`.
    #[must_use]
    pub fn new(filter: Filter) -> Self {
        let profile = match filter {
            Filter::Box => Profile::Box,
            Filter::Tent { radius } => Profile::Tent { radius },
            Filter::Gaussian { stddev } => Profile::Tabulated {
                radius: CUTOFF * stddev,
                inverse: tabulate(|x| {
                    let x = x * f64::from(CUTOFF);
                    let cut = f64::from(CUTOFF * CUTOFF);
                    ((-0.5 * x * x).exp() - (-0.5 * cut).exp()).max(0.0)
                }),
            },
        };
        Self { profile }
    }

    /// An offset from the centre of the pixel, in pixels, for `u` in `[0, 1)²`.
    #[must_use]
    pub fn sample(&self, u: Vec2) -> Vec2 {
        Vec2::new(self.profile.sample(u.x), self.profile.sample(u.y))
    }
}

impl Profile {
    fn sample(&self, u: f32) -> f32 {
        match self {
            Self::Box => u - 0.5,
            Self::Tent { radius } => {
                let side = if u < 0.5 { -1.0 } else { 1.0 };
                // 1 − |2u − 1| is uniform, and its square root has the density of a ramp.
                radius * side * (1.0 - (1.0 - (2.0 * u - 1.0).abs()).sqrt())
            }
            Self::Tabulated { radius, inverse } => {
                let place = u.min(ONE_MINUS_ULP) * INTERVALS as f32;
                let index = place as usize;
                let rest = place - index as f32;
                radius * (inverse[index] + (inverse[index + 1] - inverse[index]) * rest)
            }
        }
    }
}

/// The inverse of the cumulative distribution of `density` on `[-1, 1]`, at equidistant probabilities.
fn tabulate(density: impl Fn(f64) -> f64) -> Vec<f32> {
    const STEPS: usize = 1 << 16;
    let at = |i: usize| -1.0 + 2.0 * i as f64 / STEPS as f64;
    let mut cumulative = vec![0.0];
    let mut sum = 0.0;
    for i in 0..STEPS {
        sum += 0.5 * (density(at(i)) + density(at(i + 1)));
        cumulative.push(sum);
    }
    (0..=INTERVALS)
        .map(|knot| {
            let target = sum * knot as f64 / INTERVALS as f64;
            let above = cumulative.partition_point(|&c| c < target).clamp(1, STEPS);
            let (low, high) = (cumulative[above - 1], cumulative[above]);
            let rest = if high > low { (target - low) / (high - low) } else { 0.0 };
            (at(above - 1) + rest * (at(above) - at(above - 1))) as f32
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean of |x| and of x² under a filter, by stratified numbers.
    fn moments(filter: Filter) -> (f64, f64) {
        let sampler = FilterSampler::new(filter);
        let n = 100_000;
        let mut sums = (0.0, 0.0);
        for i in 0..n {
            let u = (i as f32 + 0.5) / n as f32;
            let x = f64::from(sampler.sample(Vec2::new(u, 0.5)).x);
            sums = (sums.0 + x.abs() / f64::from(n), sums.1 + x * x / f64::from(n));
        }
        sums
    }

    /// Box of width 1: 1/4 and 1/12. Tent of radius r: r/3 and r²/6. Gaussian: σ√(2/π) and σ² less what
    /// the cut at 4σ takes, which quadrature gives as below.
    #[test]
    fn moments_are_those_of_the_filter() {
        let close =
            |(a, b): (f64, f64), c: f64, d: f64| (a - c).abs() < 1e-4 && (b - d).abs() < 1e-4;
        assert!(close(moments(Filter::Box), 0.25, 1.0 / 12.0));
        assert!(close(moments(Filter::Tent { radius: 1.5 }), 0.5, 0.375));
        let (mut mass, mut first, mut second) = (0.0, 0.0, 0.0);
        for i in 0..200_000 {
            let x = (f64::from(i) + 0.5) * (4.0 / 200_000.0);
            let w = (-0.5 * x * x).exp() - (-8f64).exp();
            (mass, first, second) = (mass + w, first + w * x, second + w * x * x);
        }
        let sigma = 0.5;
        let gaussian = moments(Filter::Gaussian { stddev: 0.5 });
        assert!(
            close(gaussian, sigma * first / mass, sigma * sigma * second / mass),
            "{gaussian:?}"
        );
    }

    #[test]
    fn samples_stay_within_the_radius() {
        for (filter, radius) in [
            (Filter::Box, 0.5),
            (Filter::Tent { radius: 1.0 }, 1.0),
            (Filter::Gaussian { stddev: 0.5 }, 2.0),
        ] {
            let sampler = FilterSampler::new(filter);
            for u in [0.0, 0.25, 0.5, ONE_MINUS_ULP] {
                let x = sampler.sample(Vec2::new(u, u));
                assert!(x.abs().max_element() <= radius, "{filter:?} {u}: {x}");
            }
        }
    }
}
