//! What an experiment found, in plain sentences.

use super::super::bench::Run;
use super::super::reach::{Beyond, Measured, Reach};
use super::super::series::{Series, SlopeVerdict};
use super::super::statistics::significance_each;
use super::super::summary::{Findings, Interval, SIGNIFICANCE, Summary};
use super::{rough, seconds, significant};

/// The sentences, the most useful first.
#[must_use]
pub fn verdict(findings: &Findings, runs: &[Run], target: f64) -> Vec<String> {
    let mut sentences = vec![reached(findings, runs, target)];
    sentences.extend(findings.settings.iter().filter(|s| s.bias.is_biased).map(biased));
    sentences.extend(findings.series.iter().filter_map(|series| slope(findings, series)));
    sentences.extend(unresolved(findings));
    let alike = alike(findings);
    if !alike.is_empty() {
        sentences
            .push(format!("Not told apart from the base in efficiency: {}.", alike.join("; ")));
    }
    let lost: u64 = runs.iter().map(|r| r.non_finite_samples).sum();
    if lost > 0 {
        sentences.push(format!("Samples that were not finite and are left out: {lost}."));
    }
    sentences.push(method(findings));
    sentences
}

/// How fast a series converges.
fn slope(findings: &Findings, series: &Series) -> Option<String> {
    let ((slope, error), verdict) = (series.slope?, series.verdict?);
    let mut settings = findings.settings.iter().filter(|s| s.series == series.label);
    let is_biased = settings.any(|s| s.bias.is_biased);
    let what = match verdict {
        SlopeVerdict::AsExpected | SlopeVerdict::NotToldApart if is_biased => {
            "but only while its noise is larger than its bias"
        }
        SlopeVerdict::AsExpected => "as an unbiased estimator does",
        SlopeVerdict::NotToldApart => {
            "which is not told apart from the −0.5 of an unbiased estimator"
        }
        SlopeVerdict::Steeper if series.is_even => {
            "faster than with independent samples, as is expected of such as are spread evenly"
        }
        SlopeVerdict::Steeper => "faster than independent samples do",
        SlopeVerdict::Flatter => "more slowly than an unbiased estimator does",
    };
    Some(format!(
        "\"{}\": the error falls as samples to the power {} ± {error:.2}, {what}.",
        series.label,
        format!("{slope:.2}").replace('-', "−")
    ))
}

/// Settings that the reference is too noisy for.
fn unresolved(findings: &Findings) -> Option<String> {
    let unresolved = findings.settings.iter().filter(|s| s.is_unresolved);
    let labels: Vec<_> = unresolved.map(|s| format!("\"{}\"", s.setting)).collect();
    (!labels.is_empty()).then(|| {
        format!(
            "Errors of less than half the reference's own noise, which are hardly known and count as that half: {}. \
             A reference with more samples tells them.",
            labels.join("; ")
        )
    })
}

/// Series that are nowhere told apart from the base.
fn alike(findings: &Findings) -> Vec<String> {
    let alike = |s: &Summary| s.compared.is_some_and(|c| !c.differs) && !s.bias.is_biased;
    let members = |label: &str| {
        let label = label.to_owned();
        findings.settings.iter().filter(move |s| s.series == label)
    };
    let series = findings.series.iter().filter(|series| members(&series.label).all(alike));
    series.map(|series| format!("\"{}\"", series.label)).collect()
}

/// Which series reaches the target first, and what the base needs.
fn reached(findings: &Findings, runs: &[Run], target: f64) -> String {
    // The root of a mean of squares over those of the true values.
    let what = format!(
        "An error of {} % of a pixel's brightness (relMSE {})",
        rough(100.0 * target.sqrt()),
        significant(target)
    );
    let reaches = findings.reaches(runs, target);
    let mut able: Vec<(&Summary, Measured)> =
        reaches.iter().filter_map(|(s, reach)| Some((*s, reach.measured()?))).collect();
    able.sort_by(|a, b| a.1.seconds.value.total_cmp(&b.1.seconds.value));
    let base = reaches.iter().find(|(s, _)| s.series == findings.base_series());
    let Some(&(best, reach)) = able.first() else {
        return format!("{what} {}", not_reached(&reaches));
    };
    let mut text =
        format!("{what} takes {} with {}: {}", time(&reach), quoted(best), samples(&reach));
    match base {
        Some((s, _)) if s.series == best.series && able.len() > 1 => {
            text += "; no setting is faster than the base.";
        }
        Some((s, _)) if s.series == best.series => text += ".",
        Some((_, Reach::Measured(reach))) => {
            text += &format!("; the base takes {}: {}.", time(reach), samples(reach));
        }
        Some((_, Reach::Beyond(beyond))) => text += &format!(". The base {}", not_yet(beyond)),
        Some((_, Reach::Biased)) | None => {
            text += ". The base does not come to it for sure: it is biased.";
        }
    }
    let as_good: Vec<_> = able[1..]
        .iter()
        .filter(|(_, other)| !reach.is_sooner_than(other))
        .map(|(s, _)| quoted(s))
        .collect();
    if !as_good.is_empty() {
        text += &format!(
            " Their intervals leave open which is faster: {} or {}.",
            quoted(best),
            as_good.join(" or ")
        );
    }
    text
}

/// Why no series comes to an error that was measured.
fn not_reached(reaches: &[(&Summary, Reach)]) -> String {
    let beyond = |(s, reach): &(&Summary, Reach)| match reach {
        Reach::Beyond(beyond) => Some((quoted(s), *beyond)),
        Reach::Measured(_) | Reach::Biased => None,
    };
    let nearest =
        reaches.iter().filter_map(beyond).min_by(|a, b| a.1.rel_mse.total_cmp(&b.1.rel_mse));
    nearest.map_or(
        "is not reached for sure: no setting is without bias.".to_owned(),
        |(name, beyond)| {
            format!(
                "takes more samples than were measured: {name}, which comes nearest, {}",
                not_yet(&beyond)
            )
        },
    )
}

/// How near a series came.
fn not_yet(beyond: &Beyond) -> String {
    let Beyond { samples_per_pixel, rel_mse, seconds: time, projected } = *beyond;
    let mut text = format!(
        "is at relMSE {} with {} in {}, the most that were measured",
        significant(rel_mse),
        per_pixel(samples_per_pixel),
        seconds(time)
    );
    match projected {
        Some(i) if i.high.is_finite() && i.value <= f64::from(u32::MAX) => {
            let [value, low, high] = [i.value, i.low, i.high].map(rough);
            text += &format!(
                "; if its error goes on falling as it did, {value} ({low} to {high}) are enough."
            );
        }
        Some(_) => text += "; its error does not fall for sure.",
        None => text += ".",
    }
    text
}

/// `5 ms (4.9 ms to 5.3 ms)`.
fn time(reach: &Measured) -> String {
    let Interval { value, low, high } = reach.seconds;
    let most = if high.is_finite() { seconds(high) } else { "more than was measured".to_owned() };
    let at_most = if reach.is_upper_bound { "at most " } else { "" };
    format!("{at_most}{} ({} to {most})", seconds(value), seconds(low))
}

/// `4 samples per pixel (3 to 4)`.
fn samples(reach: &Measured) -> String {
    let Measured { samples_per_pixel, fewest, most, is_upper_bound, .. } = *reach;
    let text = per_pixel(samples_per_pixel);
    match most {
        _ if is_upper_bound => format!("{text} or fewer, of which none were measured"),
        Some(most) if fewest == most => text,
        Some(most) => format!("{text} ({fewest} to {most})"),
        None => format!("{text} ({fewest} to more than were measured)"),
    }
}

fn per_pixel(samples: u32) -> String {
    format!("{samples} {} per pixel", if samples == 1 { "sample" } else { "samples" })
}

fn biased(s: &Summary) -> String {
    let p = s.bias.p_value;
    format!(
        "\"{}\" is biased: its mean is off by {} (p {}).",
        s.setting,
        super::bias(&s.bias).join(" ± "),
        if p < f64::MIN_POSITIVE { "< 1e-307".to_owned() } else { format!("= {p:.1e}") }
    )
}

/// How the tests were made.
fn method(findings: &Findings) -> String {
    let seeds = findings.settings.iter().map(|s| s.runs).min().unwrap_or(0);
    let tests = findings.settings.len();
    let level = significance_each(SIGNIFICANCE, tests);
    format!(
        "From {seeds} seeds for each setting. A setting is called biased if p < {level:.2e} (Student's t, \
         Šidák's correction for {tests} settings): in {} % of experiments without bias one is called so by \
         chance, or in more where light is so rare that few pictures meet it. The same holds for settings that differ from the base (Welch's t), and for slopes (Student's t). Intervals \
         hold 95 % (bootstrap over seeds; of numbers of samples Student's t).",
        SIGNIFICANCE * 100.0
    )
}

fn quoted(s: &Summary) -> String {
    format!("\"{}\"", s.series)
}
