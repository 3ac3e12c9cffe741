//! When series reach an error.

use super::bench::Run;
use super::efficiency::BOOTSTRAP_SEED;
use super::plan::BASE;
use super::series::{Series, SlopeVerdict, UNBIASED_SLOPE};
use super::statistics::{bootstrap, median};
use super::summary::{Findings, Interval, Summary};

/// When a series reaches an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Seconds, with the bootstrap interval over rounds.
    pub seconds: Interval,
    /// Samples per pixel that this takes, one at least.
    pub samples_per_pixel: f64,
    /// Whether that is more than four times the most, or less than a quarter of the least, that was measured.
    pub extrapolated: bool,
}

/// All runs of one setting.
struct Member {
    samples_per_pixel: f64,
    /// relMSE and seconds of each repetition.
    runs: Vec<(f64, f64)>,
    /// What the mean of these relMSEs is at least taken for.
    least: f64,
}

/// What an experiment can ask for at most.
const MOST_SAMPLES: f64 = u32::MAX as f64;

impl Findings {
    /// When a series reaches `target` in relMSE.
    ///
    /// With n samples per pixel the relMSE is c·n^−p, where p is 1 unless the series' slope says otherwise.
    /// c is the mean of relMSE·n^p over all runs, weighted by n, as if all their samples were pooled: the
    /// error of few runs with heavy tails says little. Time is that of a sample in the run with the most.
    /// `None` for a series with a setting that is biased, and where no possible number of samples is enough.
    #[must_use]
    pub fn reach(&self, series: &Series, runs: &[Run], target: f64) -> Option<Reach> {
        let settings: Vec<&Summary> =
            self.settings.iter().filter(|s| s.series == series.label).collect();
        if settings.iter().any(|s| s.bias.is_biased) {
            return None;
        }
        let known = |v: SlopeVerdict| matches!(v, SlopeVerdict::Steeper | SlopeVerdict::Flatter);
        let slope = series.slope.filter(|_| series.verdict.is_some_and(known));
        let power = -2.0 * slope.map_or(UNBIASED_SLOPE, |(slope, _)| slope);
        let members: Vec<Member> = settings.iter().map(|s| Member::of(s, runs)).collect();
        let rounds = members.iter().map(|m| m.runs.len()).min().unwrap_or(0);
        let all: Vec<usize> = (0..rounds).collect();
        let samples = |rounds: &[usize]| {
            (constant(&members, rounds, power) / target).powf(1.0 / power).max(1.0)
        };
        let seconds = |rounds: &[usize]| samples(rounds) * time_per_sample(&members, rounds);
        let (low, high) = bootstrap(rounds, BOOTSTRAP_SEED, seconds);
        let seconds = Interval { value: seconds(&all), low, high };
        let samples_per_pixel = samples(&all);
        let counts = || members.iter().map(|m| m.samples_per_pixel);
        let least = counts().fold(f64::INFINITY, f64::min);
        let most = counts().fold(0.0, f64::max);
        let possible = power > 0.0 && samples_per_pixel <= MOST_SAMPLES;
        (possible && seconds.value.is_finite()).then_some(Reach {
            seconds,
            samples_per_pixel,
            extrapolated: !(0.25 * least..=4.0 * most).contains(&samples_per_pixel),
        })
    }

    /// The same of all series, each with its setting of the most samples.
    #[must_use]
    pub fn reaches(&self, runs: &[Run], target: f64) -> Vec<(&Summary, Option<Reach>)> {
        let longest = |series: &Series| {
            let members = self.settings.iter().filter(|s| s.series == series.label);
            members.max_by_key(|s| s.samples_per_pixel)
        };
        let each = |series| Some((longest(series)?, self.reach(series, runs, target)));
        self.series.iter().filter_map(each).collect()
    }

    /// The series of the base.
    #[must_use]
    pub fn base_series(&self) -> &str {
        self.base().map_or(BASE, |b| b.series.as_str())
    }
}

impl Member {
    fn of(setting: &Summary, runs: &[Run]) -> Self {
        let own: Vec<&Run> = runs.iter().filter(|r| r.setting == setting.setting).collect();
        let least = own.iter().map(|r| r.metrics.least_rel_mse()).sum::<f64>() / own.len() as f64;
        Self {
            samples_per_pixel: f64::from(setting.samples_per_pixel),
            runs: own.iter().map(|r| (r.metrics.true_rel_mse(), r.seconds)).collect(),
            least,
        }
    }

    /// Mean relMSE of some rounds, as far as the reference tells.
    fn rel_mse(&self, rounds: &[usize]) -> f64 {
        let sum: f64 = rounds.iter().map(|&round| self.runs[round].0).sum();
        (sum / rounds.len() as f64).max(self.least)
    }
}

/// c of relMSE = c·n^−p.
fn constant(members: &[Member], rounds: &[usize], power: f64) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for member in members {
        let n = member.samples_per_pixel;
        sum += n * member.rel_mse(rounds) * n.powf(power);
        weights += n;
    }
    sum / weights
}

/// Median time of a sample in the setting with the most.
fn time_per_sample(members: &[Member], rounds: &[usize]) -> f64 {
    let longest = members.iter().max_by(|a, b| a.samples_per_pixel.total_cmp(&b.samples_per_pixel));
    longest.map_or(f64::NAN, |m| {
        median(rounds.iter().map(|&round| m.runs[round].1)) / m.samples_per_pixel
    })
}
