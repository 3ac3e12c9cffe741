//! How fast errors fall with the number of samples.

use serde::{Deserialize, Serialize};

use super::statistics::{Line, fit_line, p_value, significance_each};
use super::summary::{SIGNIFICANCE, Summary};

/// Slope of RMSE over samples of an unbiased estimator with independent samples, on log axes.
pub const UNBIASED_SLOPE: f64 = -0.5;

/// A slope within this of [`UNBIASED_SLOPE`] is as good as it, however small its error.
pub const SLOPE_TOLERANCE: f64 = 0.03;

/// Settings that differ in the number of samples only.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Series {
    /// Its label.
    pub label: String,
    /// Whether its samples are spread evenly, as those of a low-discrepancy sampler: its slope may be steeper.
    pub is_even: bool,
    /// Slope of log RMSE over log samples, with its standard error; for at least three numbers of samples.
    pub slope: Option<(f64, f64)>,
    /// Whether that is −1/2.
    pub verdict: Option<SlopeVerdict>,
}

/// What a slope says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SlopeVerdict {
    /// Within [`SLOPE_TOLERANCE`] of −1/2, as for independent samples without bias.
    AsExpected,
    /// Further away, but not by more than chance explains.
    NotToldApart,
    /// The error falls faster, as with samples that are spread evenly.
    Steeper,
    /// The error falls more slowly: bias, or light so rare that few pictures have met it.
    Flatter,
}

/// The series of `settings`, where `even` says of each whether its samples are spread evenly.
pub(super) fn of(settings: &[Summary], even: &[bool]) -> Vec<Series> {
    let mut labels: Vec<&str> = Vec::new();
    for s in settings {
        if !labels.contains(&s.series.as_str()) {
            labels.push(&s.series);
        }
    }
    let lines: Vec<Option<Line>> = labels.iter().map(|&label| line(settings, label)).collect();
    let tests = lines.iter().flatten().count();
    let each = |(&label, line): (&&str, &Option<Line>)| Series {
        label: label.to_owned(),
        is_even: settings.iter().zip(even).any(|(s, &even)| s.series == label && even),
        slope: line.map(|l| (l.slope, l.slope_error)),
        verdict: line.map(|l| verdict(&l, tests)),
    };
    labels.iter().zip(&lines).map(each).collect()
}

/// log RMSE over log samples of one series.
fn line(settings: &[Summary], label: &str) -> Option<Line> {
    let usable = |s: &&Summary| s.mse.mean > 0.0 && !s.is_unresolved && s.runs > 1;
    let members: Vec<&Summary> =
        settings.iter().filter(|s| s.series == label).filter(usable).collect();
    // The MSEs of a series are nearly as certain as each other; where light is rare, those that have missed it seem
    // the most certain.
    let relative = |s: &&Summary| s.mse.deviation / s.mse.mean / (s.runs as f64).sqrt();
    let relative = members.iter().map(relative).fold(0.0, f64::max);
    let point = |s: &&Summary| {
        // Half of the relative error of the MSE is that of its root, and that of the logarithm.
        (f64::from(s.samples_per_pixel).ln(), s.rmse.ln(), 0.5 * relative)
    };
    let points: Vec<_> = members.iter().map(point).collect();
    let runs = members.iter().map(|s| s.runs).min()?;
    (points.len() > 2).then(|| fit_line(&points, runs as f64 - 1.0)).flatten()
}

fn verdict(line: &Line, tests: usize) -> SlopeVerdict {
    let beyond = line.slope - UNBIASED_SLOPE;
    let p_value = p_value(beyond, line.slope_error, line.freedom);
    if beyond.abs() <= SLOPE_TOLERANCE {
        SlopeVerdict::AsExpected
    } else if p_value >= significance_each(SIGNIFICANCE, tests) {
        SlopeVerdict::NotToldApart
    } else if beyond > 0.0 {
        SlopeVerdict::Flatter
    } else {
        SlopeVerdict::Steeper
    }
}
