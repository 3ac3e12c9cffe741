//! The error of a series against its samples, at the counts that were measured and nowhere else.

use super::bench::Run;
use super::efficiency::{BOOTSTRAP_SEED, REL_MSE};
use super::statistics::{Line, Moments, bootstrap, fit_line, median, student_quantile};
use super::summary::{Interval, Summary};

/// What was measured of one series, by ascending counts of samples.
#[derive(Clone, Debug)]
pub(super) struct Curve(pub(super) Vec<Point>);

/// What was measured with one count of samples.
#[derive(Clone, Debug)]
pub(super) struct Point {
    pub(super) samples_per_pixel: u32,
    /// Mean relMSE over seeds, as far as the reference tells.
    pub(super) rel_mse: f64,
    /// Sample standard deviation of it between seeds, over it.
    deviation: f64,
    runs: usize,
    /// Of each run.
    seconds_per_sample: Vec<f64>,
    /// Whether the error is no more than what the reference's noise hides.
    is_unresolved: bool,
}

/// The neighbours between which a curve comes down to an error for good: indices of the last point above it
/// and of the next one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bracket {
    pub(super) above: Option<usize>,
    pub(super) below: Option<usize>,
}

/// Half of the width that a 95 % interval may leave out at either end.
const TAIL: f64 = 0.025;

/// Counts within this factor take alike for each sample, but for what a picture costs by itself.
const NEXT: f64 = 1.5;

/// Errors that are farther than this factor from a target say nothing of how uncertain those near it are.
const NEIGHBOURHOOD: f64 = 4.0;

impl Curve {
    /// The runs of all `settings`, which differ in the number of samples only.
    pub(super) fn of<'a>(settings: impl Iterator<Item = &'a Summary>, runs: &[Run]) -> Self {
        let point = |setting: &Summary| {
            let own: Vec<&Run> = runs.iter().filter(|r| r.setting == setting.setting).collect();
            (!own.is_empty()).then(|| Point::of(setting.samples_per_pixel, &own))
        };
        let mut points: Vec<Point> = settings.filter_map(point).collect();
        points.sort_by_key(|p| p.samples_per_pixel);
        Self(points)
    }

    /// Where errors that are `factor` times as large come below `target` and stay there.
    pub(super) fn bracket(&self, factor: f64, target: f64) -> Bracket {
        let above = self.0.iter().rposition(|p| factor * p.rel_mse > target);
        let below = above.map_or(0, |last| last + 1);
        Bracket { above, below: (below < self.0.len()).then_some(below) }
    }

    /// By which factor means near `target` may be off in either direction (95 %, Student's t of the
    /// logarithm). The deviations of all counts near it are pooled: where light is rare, a count whose
    /// pictures have missed it seems certain.
    pub(super) fn uncertainty(&self, target: f64) -> f64 {
        let near =
            |p: &&Point| p.rel_mse <= NEIGHBOURHOOD * target && NEIGHBOURHOOD * p.rel_mse >= target;
        let bracket = self.bracket(1.0, target);
        let ends = [bracket.above, bracket.below].into_iter().flatten().map(|i| &self.0[i]);
        let mut points: Vec<&Point> = self.0.iter().filter(near).collect();
        points.extend(ends.filter(|p| !near(p)));
        let freedom: f64 = points.iter().map(|p| p.runs as f64 - 1.0).sum();
        let squares: f64 = points.iter().map(|p| (p.runs as f64 - 1.0) * p.deviation.powi(2)).sum();
        let fewest = points.iter().map(|p| p.runs).min().unwrap_or(0);
        if freedom == 0.0 {
            return f64::INFINITY;
        }
        let error = (squares / freedom / fewest as f64).sqrt();
        if error == 0.0 { 1.0 } else { (student_quantile(1.0 - TAIL, freedom) * error).exp() }
    }

    /// The time of a sample, with its bootstrap interval, in pictures of about as many `samples`: the median over
    /// all runs of the counts next to it, since a count by itself may have met a busy machine.
    pub(super) fn seconds_per_sample(&self, samples: u32) -> Interval {
        let away = |p: &Point| (f64::from(p.samples_per_pixel) / f64::from(samples)).ln().abs();
        let nearest = self.0.iter().map(away).fold(f64::INFINITY, f64::min);
        let near = self.0.iter().filter(|p| away(p) <= nearest.max(NEXT.ln()));
        let each: Vec<f64> = near.flat_map(|p| p.seconds_per_sample.iter().copied()).collect();
        let of = |chosen: &[usize]| median(chosen.iter().map(|&i| each[i]));
        let (low, high) = bootstrap(each.len(), BOOTSTRAP_SEED, of);
        Interval { value: median(each.iter().copied()), low, high }
    }

    /// The line of the logarithms of relMSE over samples, with the mean point that it passes through; for at
    /// least three counts that the reference tells. Its error is that of the noise, or what points that lie off
    /// the line show if this is more.
    pub(super) fn line(&self) -> Option<(Line, [f64; 2])> {
        let usable: Vec<&Point> =
            self.0.iter().filter(|p| p.rel_mse > 0.0 && !p.is_unresolved && p.runs > 1).collect();
        if usable.len() < 3 {
            return None;
        }
        let relative = |p: &&Point| p.deviation / (p.runs as f64).sqrt();
        let relative = usable.iter().map(relative).fold(0.0, f64::max);
        let points: Vec<_> = usable
            .iter()
            .map(|p| (f64::from(p.samples_per_pixel).ln(), p.rel_mse.ln(), relative))
            .collect();
        let freedom = usable.iter().map(|p| p.runs).min()? as f64 - 1.0;
        let line = fit_line(&points, freedom)?;
        let count = points.len() as f64;
        let sums = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0, y + p.1));
        let mean = [sums.0 / count, sums.1 / count];
        let xx: f64 = points.iter().map(|p| (p.0 - mean[0]).powi(2)).sum();
        let off = |p: &(f64, f64, f64)| p.1 - mean[1] - line.slope * (p.0 - mean[0]);
        let squares: f64 = points.iter().map(|p| off(p).powi(2)).sum();
        let scattered = Line {
            slope_error: (squares / (count - 2.0) / xx).sqrt(),
            freedom: count - 2.0,
            ..line
        };
        let width = |l: &Line| l.slope_error * student_quantile(1.0 - TAIL, l.freedom);
        Some((if width(&scattered) > width(&line) { scattered } else { line }, mean))
    }
}

impl Point {
    fn of(samples_per_pixel: u32, runs: &[&Run]) -> Self {
        let errors: Vec<f64> = runs.iter().map(|r| r.metrics.true_rel_mse()).collect();
        let rel_mse = REL_MSE.mean(runs);
        let deviation = Moments::of(&errors).deviation;
        let each = |r: &&Run| r.seconds / f64::from(samples_per_pixel);
        Self {
            samples_per_pixel,
            rel_mse,
            deviation: if deviation == 0.0 { 0.0 } else { deviation / rel_mse },
            runs: runs.len(),
            seconds_per_sample: runs.iter().map(each).collect(),
            is_unresolved: REL_MSE.is_unresolved(runs),
        }
    }
}
