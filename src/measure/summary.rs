//! What many runs say together.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::bench::Run;
use super::efficiency::{Comparison, MSE, TRIMMED, compare, efficiency, interval};
use super::metrics::Metrics;
use super::plan::Candidate;
use super::statistics::{Line, Moments, fit_line, median, p_value, significance_each, sorted};

/// Probability that any setting without bias is called biased, that any setting which is as efficient as the
/// base is called different, or that any series which converges as it should is said not to: of each 0.01.
pub const SIGNIFICANCE: f64 = 0.01;

/// Slope of RMSE over samples of an unbiased estimator with independent samples, on log axes.
pub const UNBIASED_SLOPE: f64 = -0.5;

/// A slope within this of [`UNBIASED_SLOPE`] is as good as it, however small its error.
pub const SLOPE_TOLERANCE: f64 = 0.03;

/// Mean over seeds, with the standard deviation between them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Sample standard deviation.
    pub deviation: f64,
}

/// A number with the ends of its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// The number.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// All runs of one setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Label of the setting.
    pub setting: String,
    /// Label of its series.
    pub series: String,
    /// Whether it is what the others are compared with.
    pub is_base: bool,
    /// Whether it is that up to the number of samples.
    pub in_base_series: bool,
    /// Samples per pixel.
    pub samples_per_pixel: u32,
    /// How many runs there are.
    pub runs: usize,
    /// Render time in seconds: median, smallest and largest.
    pub seconds: Interval,
    /// Median of rays traced.
    pub rays: f64,
    /// Largest peak of memory in bytes, where it is known.
    pub peak_bytes: Option<u64>,
    /// √ of the mean over seeds of the MSE without the reference's noise.
    pub rmse: f64,
    /// MSE without the reference's noise.
    pub mse: Spread,
    /// relMSE without the reference's noise.
    pub rel_mse: Spread,
    /// Trimmed relMSE.
    pub rel_mse_trimmed: Spread,
    /// 99.9 % quantile of the relative squared errors of pixels.
    pub rel_se_quantile: Spread,
    /// The largest of them.
    pub rel_se_max: Spread,
    /// SMAPE.
    pub smape: Spread,
    /// ꟻLIP.
    pub flip: Spread,
    /// Whether the mean is right.
    pub bias: Bias,
    /// 1/(MSE·seconds), with a bootstrap interval over seeds.
    pub efficiency: Interval,
    /// Its ratio to that of the base with as many samples, or of the base itself where that was not measured;
    /// none within the base's series.
    pub compared: Option<Comparison>,
    /// The same of 1/(trimmed relMSE·seconds), where no few pixels decide.
    pub compared_trimmed: Option<Comparison>,
}

/// Difference of the mean from the reference's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bias {
    /// Mean difference over seeds, pixels and channels.
    pub value: f64,
    /// Its standard error, of which a part is the reference's own.
    pub error: f64,
    /// The same over the reference's mean.
    pub relative: f64,
    /// p-value if there is no bias (Student's t, Welch's degrees of freedom).
    pub p_value: f64,
    /// Whether that is below the corrected significance.
    pub is_biased: bool,
}

/// Settings that differ in the number of samples only.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Series {
    /// Its label.
    pub label: String,
    /// Slope of log RMSE over log samples, with its standard error; for at least three numbers of samples.
    pub slope: Option<(f64, f64)>,
    /// Whether the slope differs from −1/2 by more than chance and [`SLOPE_TOLERANCE`] explain.
    pub verdict: Option<SlopeVerdict>,
}

/// What a slope says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SlopeVerdict {
    /// −1/2, as for independent samples without bias.
    AsExpected,
    /// The error falls faster, as with samples that are spread evenly.
    Steeper,
    /// The error falls more slowly: bias, or samples that are alike.
    Flatter,
}

/// What an experiment found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Findings {
    /// Settings in the order of the experiment; those without runs are missing.
    pub settings: Vec<Summary>,
    /// Series in the order of their first setting.
    pub series: Vec<Series>,
    /// Labels of settings that no other beats in both time and relMSE, fastest first.
    pub pareto: Vec<String>,
}

impl Findings {
    /// What `runs` of `candidates` say, measured against a reference whose mean over pixels and channels has
    /// the standard error `reference_error` ([`mean_error`](super::bench::mean_error)).
    #[must_use]
    pub fn of(candidates: &[Candidate], runs: &[Run], reference_error: f64) -> Self {
        let mut by_label: BTreeMap<&str, Vec<&Run>> = BTreeMap::new();
        for run in runs {
            by_label.entry(&run.setting).or_default().push(run);
        }
        let groups: Vec<(&Candidate, Vec<&Run>)> = candidates
            .iter()
            .filter_map(|c| by_label.get(c.label().as_str()).map(|runs| (c, runs.clone())))
            .collect();
        let tests = groups.len();
        let compared = groups.iter().filter(|(c, _)| !c.in_base_series).count();
        let partner = |candidate: &Candidate| {
            let samples = |c: &Candidate| c.setting.samples_per_pixel;
            let like = groups.iter().filter(|(c, _)| c.in_base_series);
            let same = like.clone().find(|(c, _)| samples(c) == samples(candidate));
            same.or_else(|| like.clone().find(|(c, _)| c.is_base)).map(|(_, runs)| runs)
        };
        let summary = |(candidate, runs): &(&Candidate, Vec<&Run>)| {
            let partner = partner(candidate).filter(|_| !candidate.in_base_series);
            Summary {
                compared: partner.map(|base| compare(runs, base, compared, MSE)),
                compared_trimmed: partner.map(|base| compare(runs, base, compared, TRIMMED)),
                ..summarize(candidate, runs, reference_error, tests)
            }
        };
        let settings: Vec<Summary> = groups.iter().map(summary).collect();
        let series = series(&settings);
        let pareto = pareto(&settings);
        Self { settings, series, pareto }
    }

    /// The base.
    #[must_use]
    pub fn base(&self) -> Option<&Summary> {
        self.settings.iter().find(|s| s.is_base)
    }
}

fn spread(runs: &[&Run], value: impl Fn(&Metrics) -> f64) -> Spread {
    let values: Vec<f64> = runs.iter().map(|r| value(&r.metrics)).collect();
    let Moments { mean, deviation, .. } = Moments::of(&values);
    Spread { mean, deviation }
}

fn summarize(candidate: &Candidate, runs: &[&Run], reference_error: f64, tests: usize) -> Summary {
    let seconds = sorted(runs.iter().map(|r| r.seconds));
    let mse = spread(runs, Metrics::true_mse);
    Summary {
        setting: candidate.label(),
        series: candidate.series(),
        is_base: candidate.is_base,
        in_base_series: candidate.in_base_series,
        samples_per_pixel: candidate.setting.samples_per_pixel,
        runs: runs.len(),
        seconds: Interval {
            value: median(seconds.iter().copied()),
            low: seconds.first().copied().unwrap_or(f64::NAN),
            high: seconds.last().copied().unwrap_or(f64::NAN),
        },
        rays: median(runs.iter().map(|r| r.rays as f64)),
        peak_bytes: runs.iter().filter_map(|r| r.peak_bytes).max(),
        rmse: mse.mean.max(0.0).sqrt(),
        mse,
        rel_mse: spread(runs, Metrics::true_rel_mse),
        rel_mse_trimmed: spread(runs, |m| m.rel_mse_trimmed),
        rel_se_quantile: spread(runs, |m| m.rel_se_quantile),
        rel_se_max: spread(runs, |m| m.rel_se_max),
        smape: spread(runs, |m| m.smape),
        flip: spread(runs, |m| m.flip),
        bias: bias(runs, reference_error, tests),
        efficiency: interval(runs, &|chosen| efficiency(chosen, MSE)),
        compared: None,
        compared_trimmed: None,
    }
}

/// Student's t-test of the mean difference over seeds, where the reference's error counts too.
fn bias(runs: &[&Run], reference_error: f64, tests: usize) -> Bias {
    let values: Vec<f64> = runs.iter().map(|r| r.metrics.bias).collect();
    let moments = Moments::of(&values);
    let (own, its) = (moments.standard_error().powi(2), reference_error.powi(2));
    let error = (own + its).sqrt();
    // Satterthwaite 1946; the reference's error comes from so many pixels that it counts as known.
    let freedom = (own + its).powi(2) / (own * own) * (moments.count as f64 - 1.0);
    let p_value = p_value(moments.mean, error, freedom);
    let means: Vec<f64> = runs.iter().map(|r| r.metrics.reference_mean).collect();
    Bias {
        value: moments.mean,
        error,
        relative: moments.mean / Moments::of(&means).mean,
        p_value,
        is_biased: p_value < significance_each(SIGNIFICANCE, tests),
    }
}

fn series(settings: &[Summary]) -> Vec<Series> {
    let mut labels: Vec<&str> = Vec::new();
    for s in settings {
        if !labels.contains(&s.series.as_str()) {
            labels.push(&s.series);
        }
    }
    let lines: Vec<Option<Line>> = labels
        .iter()
        .map(|&label| {
            let points: Vec<_> = settings
                .iter()
                .filter(|s| s.series == label && s.mse.mean > 0.0 && s.runs > 1)
                .map(|s| {
                    let relative = s.mse.deviation / s.mse.mean / (s.runs as f64).sqrt();
                    let samples = f64::from(s.samples_per_pixel);
                    // Half of the relative error of the MSE is that of its root, and that of the logarithm.
                    (samples.ln(), s.rmse.ln(), 0.5 * relative)
                })
                .collect();
            (points.len() > 2).then(|| fit_line(&points)).flatten()
        })
        .collect();
    let tests = lines.iter().flatten().count();
    let each = |(&label, line): (&&str, &Option<Line>)| Series {
        label: label.to_owned(),
        slope: line.map(|l| (l.slope, l.slope_error)),
        verdict: line.map(|l| slope_verdict(&l, tests)),
    };
    labels.iter().zip(&lines).map(each).collect()
}

fn slope_verdict(line: &Line, tests: usize) -> SlopeVerdict {
    let beyond = line.slope - UNBIASED_SLOPE;
    let p_value = p_value(beyond, line.slope_error, f64::INFINITY);
    if beyond.abs() <= SLOPE_TOLERANCE || p_value >= significance_each(SIGNIFICANCE, tests) {
        SlopeVerdict::AsExpected
    } else if beyond > 0.0 {
        SlopeVerdict::Flatter
    } else {
        SlopeVerdict::Steeper
    }
}

fn pareto(settings: &[Summary]) -> Vec<String> {
    let mut order: Vec<&Summary> = settings.iter().collect();
    order.sort_by(|a, b| a.seconds.value.total_cmp(&b.seconds.value));
    let mut best = f64::INFINITY;
    let front = order.into_iter().filter(|s| {
        let better = s.rel_mse.mean < best;
        best = best.min(s.rel_mse.mean);
        better
    });
    front.map(|s| s.setting.clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intersect::Backend;
    use crate::measure::efficiency::log_cost;
    use crate::measure::knobs::Setting;
    use crate::measure::plan::BASE;
    use crate::measure::statistics::welch;
    use crate::sampler::{Independent, Sampler};
    use crate::scene::tests::description;

    fn candidate(choices: &[(&str, &str)], spp: u32) -> Candidate {
        let setting = Setting::of(&description(), Backend::Rust.into(), 1).expect("a picture");
        Candidate {
            choices: choices.iter().map(|&(k, v)| (k.to_owned(), v.to_owned())).collect(),
            setting: Setting { samples_per_pixel: spp, ..setting },
            is_base: choices.is_empty(),
            in_base_series: choices.is_empty(),
        }
    }

    fn run(setting: &str, repeat: u32, seconds: f64, mse: f64, bias: f64) -> Run {
        Run {
            setting: setting.to_owned(),
            repeat,
            seed: 0,
            seconds,
            build_seconds: 0.0,
            rays: 1000,
            samples: 100,
            non_finite_samples: 0,
            peak_bytes: None,
            metrics: Metrics {
                pixels: 100,
                non_finite: 0,
                mse,
                rel_mse: mse,
                rel_mse_trimmed: mse,
                rel_se_quantile: mse,
                rel_se_max: mse,
                smape: 0.1,
                flip: 0.1,
                bias,
                bias_error: 0.1,
                reference_mean: 2.0,
                reference_noise: None,
            },
        }
    }

    /// A normal number (Box and Muller 1958).
    fn normal(numbers: &Independent, i: u32, j: u32) -> f64 {
        let u = numbers.get_2d(numbers.path(i, j), 0).as_dvec2();
        (-2.0 * (1.0 - u.x).ln()).sqrt() * (std::f64::consts::TAU * u.y).cos()
    }

    /// 2000 experiments of a base and two more settings without any difference or bias: 1 % of them, that is
    /// 20 ± 4.4, may call any of them biased, and as many may tell any from the base; 20 + 4·4.4 at most. (Two
    /// comparisons with one base depend on each other, which makes false alarms rarer.)
    #[test]
    fn false_alarms_are_as_rare_as_stated() {
        let numbers = Independent::new(7);
        let candidates =
            [candidate(&[], 1), candidate(&[("a", "1")], 1), candidate(&[("a", "2")], 1)];
        let (mut biased, mut told_apart) = (0, 0);
        for experiment in 0..2000 {
            let mut runs = Vec::new();
            for (c, candidate) in candidates.iter().enumerate() {
                for k in 0..8 {
                    let draw = |what| normal(&numbers, experiment, 100 * k + 10 * c as u32 + what);
                    let (time, mse) = ((0.05 * draw(0)).exp(), (0.2 * draw(1)).exp());
                    runs.push(run(&candidate.label(), k, time, mse, draw(2)));
                }
            }
            let groups: Vec<Vec<&Run>> = candidates
                .iter()
                .map(|c| runs.iter().filter(|r| r.setting == c.label()).collect())
                .collect();
            let any_bias = groups.iter().any(|runs| bias(runs, 0.0, 3).is_biased);
            let differs = |runs: &Vec<&Run>| {
                welch(&log_cost(runs, MSE), &log_cost(&groups[0], MSE))
                    < significance_each(SIGNIFICANCE, 2)
            };
            biased += u32::from(any_bias);
            told_apart += u32::from(groups[1..].iter().any(differs));
        }
        assert!(biased <= 37 && told_apart <= 37, "{biased} {told_apart}");
        // Tests that never reject would be of no use.
        assert!(biased >= 3 && told_apart >= 3, "{biased} {told_apart}");
    }

    /// The reference's error counts: a mean off by 3 standard errors of its own is no bias if the reference
    /// may be off by as much.
    #[test]
    fn bias_is_judged_against_both_errors() {
        let runs: Vec<Run> = (0..8)
            .map(|k| run(BASE, k, 1.0, 1.0, 0.3 + if k % 2 == 0 { 0.1 } else { -0.1 }))
            .collect();
        let runs: Vec<&Run> = runs.iter().collect();
        let exact = bias(&runs, 0.0, 1);
        // Deviations of ±0.1: s² = 8·0.01/7, of the mean 0.01/7.
        assert!((exact.value - 0.3).abs() < 1e-12 && (exact.relative - 0.15).abs() < 1e-12);
        assert!((exact.error - (0.01_f64 / 7.0).sqrt()).abs() < 1e-12 && exact.is_biased);
        assert!(!bias(&runs, 0.3, 1).is_biased);
    }

    /// Two series over 1, 2, 4, 8 and 16 samples with MSE 1/n and 1/n + 0.2, the latter slower by half.
    #[test]
    fn slopes_pareto_front_and_reach() {
        let (mut candidates, mut runs) = (Vec::new(), Vec::new());
        for (name, floor, time) in [("x", 0.0, 1.0), ("y", 0.2, 1.5)] {
            for spp in [1_u32, 2, 4, 8, 16] {
                let mut c = candidate(&[("s", name), ("spp", &spp.to_string())], spp);
                c.in_base_series = name == "y";
                c.is_base = c.in_base_series && spp == 16;
                for k in 0..8 {
                    let wobble = 1.0 + if k % 2 == 0 { 0.02 } else { -0.02 };
                    let n = f64::from(spp);
                    let off = if k % 2 == 0 { 0.1 } else { -0.1 };
                    runs.push(run(&c.label(), k, time * n, wobble * (1.0 / n + floor), off));
                }
                candidates.push(c);
            }
        }
        let findings = Findings::of(&candidates, &runs, 0.0);
        let [x, y] = findings.series.as_slice() else { panic!("two series") };
        let (slope, _) = x.slope.expect("five points");
        assert!((slope + 0.5).abs() < 1e-6 && x.verdict == Some(SlopeVerdict::AsExpected));
        assert!(y.slope.expect("five points").0 > -0.4 && y.verdict == Some(SlopeVerdict::Flatter));
        let front = ["s=x, spp=1", "s=x, spp=2", "s=x, spp=4", "s=x, spp=8", "s=x, spp=16"];
        assert_eq!(findings.pareto, front);
        // MSE 1/n with n seconds: 1/(MSE·s) is 1 for all of x. A relMSE of 0.1 takes 10 samples and seconds.
        let best = findings.settings.iter().find(|s| s.setting == "s=x, spp=8").expect("there");
        assert!((best.efficiency.value - 1.0).abs() < 1e-12);
        let reach = findings.reach(x, &runs, 0.1).expect("not biased");
        assert!((reach.seconds.value - 10.0).abs() < 1e-9 && !reach.extrapolated);
        assert!((reach.samples_per_pixel - 10.0).abs() < 1e-9);
        assert!(reach.seconds.low < 10.0 && reach.seconds.high > 10.0);
        // The error of y falls more slowly, which its reach takes into account.
        let slow = findings.reach(y, &runs, 0.1).expect("not biased");
        assert!(slow.seconds.value > 1.5 * 10.0 && slow.extrapolated);
        assert!(findings.reach(x, &runs, 0.001).expect("not biased").extrapolated);
        // The base's series with 8 samples has the MSE 1/8 + 0.2 and takes 12 s.
        let base = findings.base().expect("one");
        assert!(base.setting == "s=y, spp=16" && base.compared.is_none());
        let ratio = best.compared.expect("not the base").ratio;
        assert!((ratio.value - 3.9).abs() < 1e-9 && ratio.low < 3.9 && ratio.high > 3.9);
        assert!(best.compared.expect("not the base").differs);
        // Both errors are alike here.
        assert_eq!(best.compared_trimmed, best.compared);
    }
}
