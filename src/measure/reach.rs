//! When series reach an error.

use super::bench::Run;
use super::curve::{Bracket, Curve};
use super::plan::BASE;
use super::series::Series;
use super::statistics::student_quantile;
use super::summary::{Findings, Interval, Summary};

/// When a series reaches an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reach {
    /// With a number of samples that was measured.
    Measured(Measured),
    /// With no number of samples that was measured.
    Beyond(Beyond),
    /// Never for sure: it has a setting that is biased.
    Biased,
}

/// A number of samples that was measured and is enough. Nothing in it is extrapolated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The fewest samples per pixel whose mean error was no larger, as were those of all greater numbers that
    /// were measured.
    pub samples_per_pixel: u32,
    /// Their mean relMSE.
    pub rel_mse: f64,
    /// The fewest that it may take (95 %): one more than the most that were too few beyond chance.
    pub fewest: u32,
    /// The most (95 %): the fewest that were enough beyond chance; `None` where that is more than was measured.
    pub most: Option<u32>,
    /// Time of such a picture in seconds, with the interval (95 %) that the number of samples and the time of each
    /// leave, infinite where there is no `most`.
    pub seconds: Interval,
    /// Whether fewer samples, of which none were measured, may well be enough.
    pub is_upper_bound: bool,
}

/// The most samples that were measured, which are not enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beyond {
    /// Samples per pixel.
    pub samples_per_pixel: u32,
    /// Their mean relMSE.
    pub rel_mse: f64,
    /// Time of such a picture in seconds.
    pub seconds: f64,
    /// How many samples it takes if the error goes on falling as it did, with the interval (95 %) that the slope
    /// leaves: infinite where it may be flat. `None` for fewer than three measured numbers.
    pub projected: Option<Interval>,
}

impl Reach {
    /// What it says of a number of samples that is enough, if one was measured.
    #[must_use]
    pub fn measured(self) -> Option<Measured> {
        if let Self::Measured(measured) = self { Some(measured) } else { None }
    }
}

impl Measured {
    /// Whether it is sooner than `other`, beyond what their intervals leave open.
    #[must_use]
    pub fn is_sooner_than(&self, other: &Self) -> bool {
        let (own, its) = (self.seconds, other.seconds);
        // Both are independent, and about as wide in the logarithm as those of a normal number.
        let open = (own.high / own.value).ln().hypot((its.value / its.low).ln());
        (its.value / own.value).ln() > open
    }
}

impl Findings {
    /// When a series reaches `target` in relMSE, by the numbers of samples that were measured: a number between
    /// them has an error of its own, since samples that are spread evenly are best at powers of two.
    ///
    /// # Panics
    /// If `runs` are not those that this was found in.
    #[must_use]
    pub fn reach(&self, series: &Series, runs: &[Run], target: f64) -> Reach {
        if self.members(&series.label).any(|s| s.bias.is_biased) {
            return Reach::Biased;
        }
        let curve = self.curve(&series.label, runs);
        let Bracket { above, below } = curve.bracket(1.0, target);
        let Some(below) = below else {
            let most = &curve.0[above.expect("the runs of these findings")];
            return Reach::Beyond(Beyond {
                samples_per_pixel: most.samples_per_pixel,
                rel_mse: most.rel_mse,
                seconds: f64::from(most.samples_per_pixel)
                    * curve.seconds_per_sample(most.samples_per_pixel).value,
                projected: projected(&curve, target),
            });
        };
        let uncertainty = curve.uncertainty(target);
        let samples = |index: usize| curve.0[index].samples_per_pixel;
        let too_few = curve.bracket(1.0 / uncertainty, target).above;
        let enough = curve.bracket(uncertainty, target).below;
        let fewest = too_few.map_or(1, |index| samples(index) + 1);
        let most = enough.map(samples);
        Reach::Measured(Measured {
            samples_per_pixel: samples(below),
            rel_mse: curve.0[below].rel_mse,
            fewest,
            most,
            seconds: seconds(&curve, samples(below), fewest, most),
            is_upper_bound: above.is_none() && samples(below) > 1,
        })
    }

    /// The same of all series, each with its setting of the most samples.
    #[must_use]
    pub fn reaches(&self, runs: &[Run], target: f64) -> Vec<(&Summary, Reach)> {
        let each = |series: &Series| {
            let longest = self
                .settings
                .iter()
                .filter(|s| s.series == series.label)
                .max_by_key(|s| s.samples_per_pixel)?;
            Some((longest, self.reach(series, runs, target)))
        };
        self.series.iter().filter_map(each).collect()
    }

    /// The series of the base.
    #[must_use]
    pub fn base_series(&self) -> &str {
        self.base().map_or(BASE, |b| b.series.as_str())
    }

    /// The settings of a series.
    pub(super) fn members<'a>(&'a self, series: &'a str) -> impl Iterator<Item = &'a Summary> {
        self.settings.iter().filter(move |s| s.series == series)
    }

    /// The error of a series against its samples.
    pub(super) fn curve(&self, series: &str, runs: &[Run]) -> Curve {
        Curve::of(self.members(series), runs)
    }
}

/// The time of `samples`, of which it may take `fewest` to `most`.
fn seconds(curve: &Curve, samples: u32, fewest: u32, most: Option<u32>) -> Interval {
    let each = curve.seconds_per_sample(samples);
    let value = f64::from(samples) * each.value;
    let ratio = |a: u32, b: u32| (f64::from(a) / f64::from(b)).ln();
    // Independent errors add up in squares.
    let low = ratio(samples, fewest).hypot((each.value / each.low).ln());
    let high = |most| ratio(most, samples).hypot((each.high / each.value).ln());
    Interval {
        value,
        low: value * (-low).exp(),
        high: most.map_or(f64::INFINITY, |most| value * high(most).exp()),
    }
}

/// Where the line through all points comes to `target`. Slope and height are each taken to the ends of their
/// interval, so that what both leave is covered.
fn projected(curve: &Curve, target: f64) -> Option<Interval> {
    let (line, [x, y]) = curve.line()?;
    let most = f64::from(curve.0.last()?.samples_per_pixel);
    let width = student_quantile(0.975, line.freedom) * line.slope_error;
    let height = curve.uncertainty(target).ln();
    let at = |slope: f64, y: f64| {
        let samples = (x + (target.ln() - y) / slope).exp();
        if slope < 0.0 { samples.max(most + 1.0) } else { f64::INFINITY }
    };
    Some(Interval {
        value: at(line.slope, y),
        low: at(line.slope - width, y - height),
        high: at(line.slope + width, y + height),
    })
}
