//! What many runs say together.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::bench::Run;
use super::bias::{Bias, noise_of_sample};
use super::efficiency::{Comparison, MSE, REL_MSE, TRIMMED, compare, efficiency, interval};
use super::metrics::Metrics;
use super::plan::Candidate;
use super::series::{self, Series};
use super::statistics::{Moments, median, sorted};

/// Probability that any setting without bias is called biased, that any setting which is as efficient as the
/// base is called different, or that any series which converges as it should is said not to: of each 0.01.
pub const SIGNIFICANCE: f64 = 0.01;

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
    /// Whether its MSE or relMSE is so small that the reference does not tell it ([`RESOLUTION`]).
    ///
    /// [`RESOLUTION`]: super::metrics::RESOLUTION
    pub is_unresolved: bool,
    /// 1/(MSE·seconds), with a bootstrap interval over seeds; a lower bound if the MSE is unresolved, and infinite
    /// if all pictures are equal to the reference.
    pub efficiency: Interval,
    /// Its ratio to that of the base with as many samples, or of the base itself where that was not measured;
    /// none within the base's series.
    pub compared: Option<Comparison>,
    /// The same of 1/(trimmed relMSE·seconds), where no few pixels decide.
    pub compared_trimmed: Option<Comparison>,
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
        // Samples that are spread evenly are not independent.
        let independent = groups.iter().filter(|(c, _)| c.setting.sampler.about().independent);
        let noise = |candidate: &Candidate| {
            let series = independent.clone().filter(|(c, _)| c.series() == candidate.series());
            noise_of_sample(series.map(|(c, runs)| (runs.as_slice(), c.setting.samples_per_pixel)))
        };
        let summary = |(candidate, runs): &(&Candidate, Vec<&Run>)| {
            let partner = partner(candidate).filter(|_| !candidate.in_base_series);
            let samples = f64::from(candidate.setting.samples_per_pixel) * runs.len() as f64;
            let bias = Bias::of(runs, noise(candidate) / samples, reference_error, tests);
            Summary {
                compared: partner.map(|base| compare(runs, base, compared, MSE)),
                compared_trimmed: partner.map(|base| compare(runs, base, compared, TRIMMED)),
                ..summarize(candidate, runs, bias)
            }
        };
        let settings: Vec<Summary> = groups.iter().map(summary).collect();
        let even: Vec<bool> =
            groups.iter().map(|(c, _)| !c.setting.sampler.about().independent).collect();
        let series = series::of(&settings, &even);
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

fn summarize(candidate: &Candidate, runs: &[&Run], bias: Bias) -> Summary {
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
        bias,
        is_unresolved: [MSE, REL_MSE].into_iter().any(|error| error.is_unresolved(runs)),
        efficiency: interval(runs, &|chosen| efficiency(chosen, MSE)),
        compared: None,
        compared_trimmed: None,
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
pub(super) mod tests {
    use super::*;
    use crate::intersect::Backend;
    use crate::measure::efficiency::p_value;
    use crate::measure::knobs::Setting;
    use crate::measure::reach::Reach;
    use crate::measure::series::SlopeVerdict;
    use crate::measure::statistics::significance_each;
    use crate::render::description::tests::description;
    use crate::sampler::{Independent, Sampler};

    fn candidate(choices: &[(&str, &str)], spp: u32) -> Candidate {
        let setting = Setting::of(&description(), Backend::Rust.into(), 1).expect("a picture");
        Candidate {
            choices: choices.iter().map(|&(k, v)| (k.to_owned(), v.to_owned())).collect(),
            setting: Setting { samples_per_pixel: spp, ..setting },
            is_base: choices.is_empty(),
            in_base_series: choices.is_empty(),
        }
    }

    /// A run of 100 pixels whose errors are all `mse`.
    pub(in crate::measure) fn run(
        setting: &str,
        repeat: u32,
        seconds: f64,
        mse: f64,
        bias: f64,
    ) -> Run {
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
            let any_bias = groups.iter().any(|runs| Bias::of(runs, 0.0, 0.0, 3).is_biased);
            let differs = |runs: &Vec<&Run>| {
                p_value(runs, &groups[0], MSE) < significance_each(SIGNIFICANCE, 2)
            };
            biased += u32::from(any_bias);
            told_apart += u32::from(groups[1..].iter().any(differs));
        }
        assert!(biased <= 37 && told_apart <= 37, "{biased} {told_apart}");
        // Tests that never reject would be of no use.
        assert!(biased >= 3 && told_apart >= 3, "{biased} {told_apart}");
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
        // Between 8 and 16 nothing was measured.
        let reach = findings.reach(x, &runs, 0.1).measured().expect("16 are enough");
        assert_eq!((reach.samples_per_pixel, reach.fewest, reach.most), (16, 9, Some(16)));
        assert!((reach.seconds.value - 16.0).abs() < 1e-9 && !reach.is_upper_bound);
        assert!((reach.seconds.low - 9.0).abs() < 1e-9 && (reach.seconds.high - 16.0).abs() < 1e-9);
        // Of 0.125 half the runs with 8 samples are above, half below.
        let even = findings.reach(x, &runs, 0.125).measured().expect("8 are enough");
        assert_eq!((even.samples_per_pixel, even.fewest, even.most), (8, 5, Some(16)));
        let at_once = findings.reach(x, &runs, 2.0).measured().expect("1 is enough");
        assert_eq!((at_once.samples_per_pixel, at_once.fewest, at_once.most), (1, 1, Some(1)));
        assert!(!at_once.is_upper_bound);
        // y never comes to it, and what its slope tells is no less than what was measured.
        let Reach::Beyond(slow) = findings.reach(y, &runs, 0.1) else { panic!("0.2 at best") };
        assert_eq!(slow.samples_per_pixel, 16);
        assert!(slow.projected.expect("five points").low > 16.0, "{slow:?}");
        // 1/n falls to 0.001 at 1000, which five points on a line tell to a percent.
        let Reach::Beyond(far) = findings.reach(x, &runs, 0.001) else { panic!("16 at most") };
        let projected = far.projected.expect("five points");
        assert!((projected.value - 1000.0).abs() < 1.0, "{projected:?}");
        assert!(projected.low < 999.0 && projected.high > 1001.0, "{projected:?}");
        assert!(projected.low > 800.0 && projected.high < 1250.0, "{projected:?}");
        // The base's series with 8 samples has the MSE 1/8 + 0.2 and takes 12 s.
        let base = findings.base().expect("one");
        assert!(base.setting == "s=y, spp=16" && base.compared.is_none());
        let ratio = best.compared.expect("not the base").ratio;
        assert!((ratio.value - 3.9).abs() < 1e-9 && ratio.low < 3.9 && ratio.high > 3.9);
        assert!(best.compared.expect("not the base").differs);
        // Both errors are alike here.
        assert_eq!(best.compared_trimmed, best.compared);
    }
    /// Pictures that are all equal to the reference, which is black: there is neither bias nor anything to wait
    /// for, and nothing that is shown is not a number.
    #[test]
    fn a_scene_without_noise_is_reached_at_once() {
        let candidates = [candidate(&[], 4), candidate(&[("a", "1")], 4)];
        let mut runs = Vec::new();
        for (c, seconds) in candidates.iter().zip([4.0, 2.0]) {
            for k in 0..4 {
                let mut run = run(&c.label(), k, seconds, 0.0, 0.0);
                run.metrics.reference_mean = 0.0;
                runs.push(run);
            }
        }
        let findings = Findings::of(&candidates, &runs, 0.0);
        assert!(findings.settings.iter().all(|s| !s.bias.is_biased && !s.is_unresolved));
        let reach = findings.reach(&findings.series[1], &runs, 0.01).measured().expect("no error");
        assert!((reach.samples_per_pixel, reach.seconds.value) == (4, 2.0) && reach.is_upper_bound);
        let sentences = crate::measure::report::verdict(&findings, &runs, 0.01);
        let expected = "An error of 10 % of a pixel's brightness (relMSE 0.01) takes at most 2 s (500 ms to 2 s) with \
                        \"a=1\": 4 samples per pixel or fewer, of which none were measured; the base takes at most \
                        4 s (1 s to 4 s): 4 samples per pixel or fewer, of which none were measured. Their intervals \
                        leave open which is faster: \"a=1\" or \"base\".";
        assert_eq!(sentences[0], expected);
        assert_eq!(sentences.len(), 2, "{sentences:?}");
        assert_eq!(crate::measure::report::bias(&findings.settings[0].bias), ["+0 %", "0 %"]);
    }

    /// What no number of samples that can be asked for reaches is not said to be reached.
    #[test]
    fn what_does_not_converge_is_not_reached() {
        let candidates: Vec<_> =
            [1, 4, 16].map(|spp| candidate(&[("spp", &spp.to_string())], spp)).into();
        let runs: Vec<Run> = candidates
            .iter()
            .flat_map(|c| (0..8).map(|k| run(&c.label(), k, 1.0, 1.0 + 0.001 * f64::from(k), 0.0)))
            .collect();
        let findings = Findings::of(&candidates, &runs, 0.0);
        assert_eq!(findings.series[0].verdict, Some(SlopeVerdict::Flatter));
        let reach = findings.reach(&findings.series[0], &runs, 0.01);
        let Reach::Beyond(beyond) = reach else { panic!("{reach:?}") };
        assert_eq!(beyond.projected.map(|i| i.high), Some(f64::INFINITY));
        let sentences = crate::measure::report::verdict(&findings, &runs, 0.01);
        assert_eq!(
            sentences[0],
            "An error of 10 % of a pixel's brightness (relMSE 0.01) takes more samples than were measured: \"base\", \
             which comes nearest, is at relMSE 1 with 16 samples per pixel in 1 s, the most that were measured; its error \
             does not fall for sure."
        );
    }

    /// MSE 1/n, and means that are off: the slope is that of an unbiased estimator, which it is not called.
    #[test]
    fn a_biased_series_is_not_called_unbiased() {
        let candidates: Vec<_> =
            [1, 4, 16].map(|spp| candidate(&[("spp", &spp.to_string())], spp)).into();
        let of = |c: &Candidate, k: u32| {
            let wobble = 1.0 + 0.01 * f64::from(k);
            let mse = wobble / f64::from(c.setting.samples_per_pixel);
            run(&c.label(), k, 1.0, mse, 0.3 * wobble)
        };
        let runs: Vec<Run> = candidates.iter().flat_map(|c| (0..8).map(|k| of(c, k))).collect();
        let findings = Findings::of(&candidates, &runs, 0.0);
        let sentences = crate::measure::report::verdict(&findings, &runs, 0.01);
        let expected = "\"base\": the error falls as samples to the power −0.50 ± 0.00, but only while its noise is \
                        larger than its bias.";
        assert_eq!(sentences[4], expected, "{sentences:?}");
    }
}
