//! Whether a setting's pictures are right in the mean.

use serde::{Deserialize, Serialize};

use super::bench::Run;
use super::statistics::{Moments, p_value, significance_each};
use super::summary::SIGNIFICANCE;

/// Difference of the mean from the reference's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bias {
    /// Mean difference over seeds, pixels and channels.
    pub value: f64,
    /// Its standard error, of which a part is the reference's own.
    pub error: f64,
    /// The first over the reference's mean; 0 if it is 0, even if the reference is black.
    pub relative: f64,
    /// The second likewise.
    pub relative_error: f64,
    /// p-value if there is no bias (Student's t, Satterthwaite's degrees of freedom).
    pub p_value: f64,
    /// Whether that is below the corrected significance, and the bias larger than [`ROUNDING`].
    pub is_biased: bool,
}

/// A bias relative to the reference's mean that the rounding of 32-bit numbers can make: a path's weight is the
/// product of a few factors, each of which is off by 2⁻²⁴, and all in one direction where a scene has no noise.
pub const ROUNDING: f64 = 1.0 / 1_048_576.0;

impl Bias {
    /// Student's t-test of the mean difference over seeds, where the reference's error counts too; `tests` of
    /// them are made in all. The squared standard error of the runs' own mean is taken for `least` at least.
    pub(super) fn of(runs: &[&Run], least: f64, reference_error: f64, tests: usize) -> Self {
        let moments = moments(runs);
        let (own, its) = (moments.standard_error().powi(2).max(least), reference_error.powi(2));
        let error = (own + its).sqrt();
        // Satterthwaite 1946; the reference's error comes from so many pixels that it counts as known.
        let freedom = (own + its).powi(2) / (own * own) * (moments.count as f64 - 1.0);
        let value = moments.mean;
        let p_value = p_value(value, error, freedom);
        let means: Vec<f64> = runs.iter().map(|r| r.metrics.reference_mean).collect();
        let mean = Moments::of(&means).mean;
        let over_mean = |v: f64| if v == 0.0 { 0.0 } else { v / mean };
        let is_rounding = value.abs() <= ROUNDING * mean.abs();
        Self {
            value,
            error,
            relative: over_mean(value),
            relative_error: over_mean(error),
            p_value,
            is_biased: p_value < significance_each(SIGNIFICANCE, tests) && !is_rounding,
        }
    }
}

fn moments(runs: &[&Run]) -> Moments {
    Moments::of(&runs.iter().map(|r| r.metrics.bias).collect::<Vec<_>>())
}

/// The variance that one sample of every pixel gives the mean of a picture, from settings that differ in the number
/// of samples alone: runs, with their samples per pixel, which must be independent. Since noise falls as 1/n, all
/// of them tell it; the largest counts. Where light is rare, pictures that have missed it seem certain.
pub(super) fn noise_of_sample<'a>(series: impl Iterator<Item = (&'a [&'a Run], u32)>) -> f64 {
    let of = |(runs, samples): (&[&Run], u32)| {
        moments(runs).standard_error().powi(2) * runs.len() as f64 * f64::from(samples)
    };
    series.map(of).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::summary::tests::run;

    /// Eight runs with a bias of `value` ± `spread`.
    fn bias_of(value: f64, spread: f64, reference_error: f64) -> Bias {
        let off = |k: u32| value + if k.is_multiple_of(2) { spread } else { -spread };
        let runs: Vec<Run> = (0..8).map(|k| run("base", k, 1.0, 1.0, off(k))).collect();
        Bias::of(&runs.iter().collect::<Vec<_>>(), 0.0, reference_error, 1)
    }

    /// The reference's error counts: a mean off by 3 standard errors of its own is no bias if the reference
    /// may be off by as much.
    #[test]
    fn both_errors_count() {
        let exact = bias_of(0.3, 0.1, 0.0);
        // Deviations of ±0.1: s² = 8·0.01/7, of the mean 0.01/7. The reference's mean is 2.
        let error = (0.01_f64 / 7.0).sqrt();
        assert!((exact.value - 0.3).abs() < 1e-12 && (exact.relative - 0.15).abs() < 1e-12);
        assert!((exact.error - error).abs() < 1e-12 && exact.is_biased);
        assert!((exact.relative_error - 0.5 * error).abs() < 1e-12);
        assert!(!bias_of(0.3, 0.1, 0.3).is_biased);
    }

    /// Without noise the test alone would reject the last bit of an f32, 2⁻²⁴ of its value.
    #[test]
    fn rounding_is_no_bias() {
        let last_bit = bias_of(2.0 / 16_777_216.0, 0.0, 0.0);
        assert!(last_bit.p_value == 0.0 && !last_bit.is_biased);
        assert!(bias_of(4.0 * ROUNDING, 0.0, 0.0).is_biased);
        let none = bias_of(0.0, 0.0, 0.0);
        assert_eq!((none.relative, none.relative_error, none.p_value), (0.0, 0.0, 1.0));
    }

    /// Pictures with 16 samples that have missed rare light, and such with 4 that have met it: their noise of 0.4
    /// for 4 samples is 0.2 for 16.
    #[test]
    fn a_series_has_one_noise() {
        let runs = |value: f64, spread: f64| -> Vec<Run> {
            let off = |k: u32| value + if k.is_multiple_of(2) { spread } else { -spread };
            (0..8).map(|k| run("base", k, 1.0, 1.0, off(k))).collect()
        };
        let (some, none) = (runs(0.0, 0.4), runs(-0.1, 0.01));
        let [some, none] = [&some, &none].map(|runs| runs.iter().collect::<Vec<_>>());
        let noise = noise_of_sample([(some.as_slice(), 4), (none.as_slice(), 16)].into_iter());
        let variance = 0.4 * 0.4 * 8.0 / 7.0;
        assert!((noise - 4.0 * variance).abs() < 1e-12);
        let least = noise / (8.0 * 16.0);
        assert!(Bias::of(&none, 0.0, 0.0, 1).is_biased);
        assert!(!Bias::of(&none, least, 0.0, 1).is_biased);
    }
}
