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
pub(super) type Error = fn(&Metrics) -> f64;

/// MSE without the reference's noise.
pub(super) const MSE: Error = Metrics::true_mse;
/// relMSE without the worst pixels.
pub(super) const TRIMMED: Error = |m| m.rel_mse_trimmed;

/// 1/(error·T), such as 1/(MSE·T): how much a second of rendering buys.
pub(super) fn efficiency(runs: &[&Run], error: Error) -> f64 {
    let mean = runs.iter().map(|r| error(&r.metrics)).sum::<f64>() / runs.len() as f64;
    1.0 / (mean.max(0.0) * median(runs.iter().map(|r| r.seconds)))
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
pub(super) fn log_cost(runs: &[&Run], error: Error) -> Moments {
    let log = |r: &&Run| (error(&r.metrics) * r.seconds).ln();
    Moments::of(&runs.iter().map(log).collect::<Vec<_>>())
}

/// Compares `runs` with those of the base; `tests` comparisons are made in all.
pub(super) fn compare(runs: &[&Run], base: &[&Run], tests: usize, error: Error) -> Comparison {
    let p_value = welch(&log_cost(runs, error), &log_cost(base, error));
    // Both are resampled, each by itself.
    let both: Vec<&Run> = runs.iter().chain(base).copied().collect();
    let split = runs.len();
    let ratio_of = |indices: &[usize]| {
        let (a, b) = indices.split_at(split);
        let part = |indices: &[usize], from: usize, count: usize| {
            let chosen: Vec<&Run> = indices.iter().map(|&i| both[from + i % count]).collect();
            efficiency(&chosen, error)
        };
        part(a, 0, split) / part(b, split, base.len())
    };
    let (low, high) = bootstrap(both.len(), BOOTSTRAP_SEED, ratio_of);
    Comparison {
        ratio: Interval { value: efficiency(runs, error) / efficiency(base, error), low, high },
        p_value,
        differs: p_value < significance_each(SIGNIFICANCE, tests),
    }
}
