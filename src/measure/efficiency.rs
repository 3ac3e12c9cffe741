//! What a second of rendering buys: the inverse of error times time.

use serde::{Deserialize, Serialize};

use super::bench::Run;
use super::metrics::Metrics;
use super::statistics::{Moments, bootstrap, median, significance_each, welch};
use super::summary::{Interval, SIGNIFICANCE};

/// A setting's efficiency over that of the base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// The ratio, with a bootstrap interval over seeds.
    pub ratio: Interval,
    /// p-value if both are alike (Welch's test of the logarithms).
    pub p_value: f64,
    /// Whether that is below the corrected significance.
    pub differs: bool,
}

/// A squared error of one picture, which falls as 1/n with n independent samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Error {
    of: fn(&Metrics) -> f64,
    /// What it is at least taken for.
    least: fn(&Metrics) -> f64,
}

/// MSE without the reference's noise.
pub(super) const MSE: Error = Error { of: Metrics::true_mse, least: Metrics::least_mse };
/// relMSE likewise.
pub(super) const REL_MSE: Error =
    Error { of: Metrics::true_rel_mse, least: Metrics::least_rel_mse };
/// relMSE without the worst pixels. What the reference's noise has added cannot be subtracted from it.
pub(super) const TRIMMED: Error = Error { of: |m| m.rel_mse_trimmed, least: |_| 0.0 };

impl Error {
    /// Its mean over runs, and the least that this is taken for.
    fn means(self, runs: &[&Run]) -> (f64, f64) {
        let mean = |of: fn(&Metrics) -> f64| {
            runs.iter().map(|r| of(&r.metrics)).sum::<f64>() / runs.len() as f64
        };
        (mean(self.of), mean(self.least))
    }

    /// Whether its mean over runs is lost in the reference's noise.
    pub(super) fn is_unresolved(self, runs: &[&Run]) -> bool {
        let (mean, least) = self.means(runs);
        mean < least
    }

    /// Its mean over runs, as far as the reference tells.
    pub(super) fn mean(self, runs: &[&Run]) -> f64 {
        let (mean, least) = self.means(runs);
        mean.max(least)
    }
}

fn time(runs: &[&Run]) -> f64 {
    median(runs.iter().map(|r| r.seconds))
}

/// 1/(error·T), such as 1/(MSE·T): how much a second of rendering buys. Infinite without any error.
pub(super) fn efficiency(runs: &[&Run], error: Error) -> f64 {
    1.0 / (error.mean(runs) * time(runs))
}

/// The ratio of two efficiencies; of times if neither has an error.
fn ratio(runs: &[&Run], base: &[&Run], error: Error) -> f64 {
    match (error.mean(runs), error.mean(base)) {
        (0.0, 0.0) => time(base) / time(runs),
        (own, its) => its * time(base) / (own * time(runs)),
    }
}

/// Seed of all bootstraps: a report does not change from one look to the next.
pub(super) const BOOTSTRAP_SEED: u64 = 1;

/// A statistic of runs with its bootstrap interval.
pub(super) fn interval(runs: &[&Run], statistic: &dyn Fn(&[&Run]) -> f64) -> Interval {
    let of = |indices: &[usize]| {
        let chosen: Vec<&Run> = indices.iter().map(|&i| runs[i]).collect();
        statistic(&chosen)
    };
    let (low, high) = bootstrap(runs.len(), BOOTSTRAP_SEED, of);
    Interval { value: statistic(runs), low, high }
}

/// Moments of log(error·T), whose distribution is closer to the normal one than that of error·T.
fn log_cost(runs: &[&Run], error: Error) -> Moments {
    let cost = |r: &&Run| (error.of)(&r.metrics).max((error.least)(&r.metrics)) * r.seconds;
    Moments::of(&runs.iter().map(|r| cost(r).ln()).collect::<Vec<_>>())
}

/// p-value if both are equally efficient.
pub(super) fn p_value(runs: &[&Run], base: &[&Run], error: Error) -> f64 {
    let log_time =
        |runs: &[&Run]| Moments::of(&runs.iter().map(|r| r.seconds.ln()).collect::<Vec<_>>());
    match (error.mean(runs), error.mean(base)) {
        (0.0, 0.0) => welch(&log_time(runs), &log_time(base)),
        // No error is none by chance, as far as runs tell.
        (0.0, _) | (_, 0.0) => 0.0,
        _ => welch(&log_cost(runs, error), &log_cost(base, error)),
    }
}

/// Compares `runs` with those of the base; `tests` comparisons are made in all.
pub(super) fn compare(runs: &[&Run], base: &[&Run], tests: usize, error: Error) -> Comparison {
    let p_value = p_value(runs, base, error);
    // Both are resampled, each by itself.
    let both: Vec<&Run> = runs.iter().chain(base).copied().collect();
    let split = runs.len();
    let ratio_of = |indices: &[usize]| {
        let (a, b) = indices.split_at(split);
        let part = |indices: &[usize], from: usize, count: usize| -> Vec<&Run> {
            indices.iter().map(|&i| both[from + i % count]).collect()
        };
        ratio(&part(a, 0, split), &part(b, split, base.len()), error)
    };
    let (low, high) = bootstrap(both.len(), BOOTSTRAP_SEED, ratio_of);
    Comparison {
        ratio: Interval { value: ratio(runs, base, error), low, high },
        p_value,
        differs: p_value < significance_each(SIGNIFICANCE, tests),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::metrics::ReferenceNoise;
    use crate::measure::summary::tests::run;

    /// Four runs of `seconds` with the MSE `mse`, each a little off, against a reference with the noise `noise`.
    fn runs(seconds: f64, mse: f64, noise: f64) -> Vec<Run> {
        let one = |k: u32| {
            let wobble = 1.0 + if k.is_multiple_of(2) { 0.01 } else { -0.01 };
            let mut run = run("x", k, wobble * seconds, wobble * mse, 0.0);
            run.metrics.reference_noise = Some(ReferenceNoise { mse: noise, rel_mse: noise });
            run
        };
        (0..4).map(one).collect()
    }

    fn compared(a: &[Run], b: &[Run]) -> Comparison {
        let [a, b] = [a, b].map(|runs| runs.iter().collect::<Vec<_>>());
        compare(&a, &b, 1, MSE)
    }

    /// Pictures without any error differ in time alone, and are better than all that have one.
    #[test]
    fn exact_pictures_are_compared_by_time() {
        let (fast, slow, noisy) = (runs(1.0, 0.0, 0.0), runs(2.0, 0.0, 0.0), runs(1.0, 0.1, 0.0));
        let both = compared(&fast, &slow);
        assert!((both.ratio.value - 2.0).abs() < 1e-12 && both.differs, "{both:?}");
        assert!(both.ratio.low > 1.9 && both.ratio.high < 2.1, "{both:?}");
        let same = compared(&fast, &fast);
        assert!(same.ratio.value == 1.0 && !same.differs, "{same:?}");
        let better = compared(&fast, &noisy);
        assert!(better.ratio.value == f64::INFINITY && better.differs, "{better:?}");
        let worse = compared(&noisy, &fast);
        assert!(worse.ratio.value == 0.0 && worse.differs, "{worse:?}");
    }

    /// What is left of an MSE that is that of the reference counts as half the reference's noise, 0.05, by chance
    /// above or below 0: 1/(0.05 · 1 s). One of 0.2 without the noise is known.
    #[test]
    fn what_the_reference_does_not_tell_is_a_bound() {
        let (lost, known) = (runs(1.0, 0.1, 0.1), runs(1.0, 0.3, 0.1));
        let [lost_runs, known_runs] = [&lost, &known].map(|r| r.iter().collect::<Vec<_>>());
        assert!(MSE.is_unresolved(&lost_runs) && !MSE.is_unresolved(&known_runs));
        assert!((efficiency(&lost_runs, MSE) - 20.0).abs() < 1e-9);
        assert!((efficiency(&known_runs, MSE) - 5.0).abs() < 1e-9);
        let better = compared(&lost, &known);
        assert!((better.ratio.value - 4.0).abs() < 1e-9 && better.differs, "{better:?}");
    }
}
