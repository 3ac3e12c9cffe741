//! What an experiment found, in plain sentences.

use super::super::bench::Run;
use super::super::reach::Reach;
use super::super::series::{Series, SlopeVerdict};
use super::super::statistics::significance_each;
use super::super::summary::{Findings, Interval, SIGNIFICANCE, Summary};
use super::{seconds, significant};

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
    let reaches = findings.reaches(runs, target);
    let mut able: Vec<(&Summary, Reach)> =
        reaches.iter().filter_map(|(s, reach)| Some((*s, (*reach)?))).collect();
    able.sort_by(|a, b| a.1.seconds.value.total_cmp(&b.1.seconds.value));
    let what = format!("relMSE {}", significant(target));
    let Some((best, reach)) = able.first() else {
        return format!("{what} is not reached: {}.", why_not(findings, None));
    };
    let base_series = findings.base_series();
    let base = able.iter().find(|(s, _)| s.series == base_series);
    let mut text = format!(
        "{what} is reached in {} with {} ({} {} per pixel{})",
        interval(&reach.seconds),
        quoted(best),
        significant(reach.samples_per_pixel),
        if reach.samples_per_pixel == 1.0 { "sample" } else { "samples" },
        if reach.extrapolated { ", extrapolated" } else { "" }
    );
    match base {
        Some((s, _)) if s.series == best.series => text += "; no setting is faster than the base.",
        Some((_, reach)) => {
            text += &format!("; the base needs {}", interval(&reach.seconds));
            text += if reach.extrapolated { " (extrapolated)." } else { "." };
        }
        None => {
            let why = why_not(findings, Some(base_series));
            text += &format!("; the base does not reach it: {why}.");
        }
    }
    let overlapping = |(s, other): &&(&Summary, Reach)| {
        s.series != best.series && other.seconds.low <= reach.seconds.high
    };
    let as_good: Vec<_> = able.iter().skip(1).filter(overlapping).map(|(s, _)| quoted(s)).collect();
    if !as_good.is_empty() {
        text += &format!(" Within the error as fast: {}.", as_good.join("; "));
    }
    text
}

/// Why the settings of a series, or any at all, do not reach an error.
fn why_not(findings: &Findings, series: Option<&str>) -> &'static str {
    let mut settings =
        findings.settings.iter().filter(|s| series.is_none_or(|series| s.series == series));
    match (settings.any(|s| s.bias.is_biased), series) {
        (true, Some(_)) => "it is biased",
        (true, None) => "no setting without bias comes to it",
        (false, _) => "no possible number of samples is enough",
    }
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
         hold 95 % (bootstrap over seeds).",
        SIGNIFICANCE * 100.0
    )
}

fn quoted(s: &Summary) -> String {
    format!("\"{}\"", s.series)
}

fn interval(i: &Interval) -> String {
    format!("{} ({} to {})", seconds(i.value), seconds(i.low), seconds(i.high))
}
