//! What `telamon measure` shows while it runs and when it is done.

use std::time::Duration;

use telamon::intersect::{Accel, Backend};
use telamon::measure::bench::Run;
use telamon::measure::knobs::knobs;
use telamon::measure::plan::{self, Candidate};
use telamon::measure::report;
use telamon::measure::summary::Findings;

use crate::cli::table::table;

/// Seconds that the runs in `order` will take, from those of the same setting so far, or else from the
/// time of a sample; `None` before the first.
pub(super) fn remaining(
    runs: &[Run],
    candidates: &[Candidate],
    labels: &[String],
    order: &[plan::Slot],
) -> Option<f64> {
    let mean = |label: &str| {
        let times: Vec<f64> =
            runs.iter().filter(|r| r.setting == label).map(|r| r.seconds).collect();
        (!times.is_empty()).then(|| times.iter().sum::<f64>() / times.len() as f64)
    };
    let known: Vec<Option<f64>> = labels.iter().map(|label| mean(label)).collect();
    let samples = |c: usize| f64::from(candidates[c].setting.samples_per_pixel);
    let each: Vec<f64> =
        (0..labels.len()).filter_map(|c| known[c].map(|t| t / samples(c))).collect();
    let rate = each.iter().sum::<f64>() / each.len() as f64;
    let time = |&(c, _): &plan::Slot| known[c].unwrap_or(rate * samples(c));
    (!each.is_empty()).then(|| order.iter().map(time).sum())
}

pub(super) fn message(label: &str, left: Option<f64>) -> String {
    let left = left.map_or(String::new(), |seconds| {
        let seconds = Duration::from_secs(seconds.ceil() as u64);
        format!("{} left  ", indicatif::HumanDuration(seconds))
    });
    format!("{left}{label}")
}

/// The table of all settings.
pub(super) fn rows(findings: &Findings) -> String {
    use report::{rough, significant};
    let names = [
        "setting",
        "spp",
        "seconds",
        "Mrays/s",
        "RMSE",
        "relMSE",
        "trimmed",
        "FLIP",
        "bias",
        "efficiency",
        "trimmed",
        "memory",
    ];
    let mut rows = vec![names.map(str::to_owned).to_vec()];
    for s in &findings.settings {
        let spread = |s: telamon::measure::summary::Spread| {
            format!("{} ± {}", significant(s.mean), rough(s.deviation))
        };
        let biased = if s.bias.is_biased { " BIASED" } else { "" };
        rows.push(vec![
            s.setting.clone(),
            s.samples_per_pixel.to_string(),
            format!(
                "{} ({}–{})",
                significant(s.seconds.value),
                rough(s.seconds.low),
                rough(s.seconds.high)
            ),
            format!("{:.2}", s.rays / s.seconds.value * 1e-6),
            significant(s.rmse),
            spread(s.rel_mse),
            significant(s.rel_mse_trimmed.mean),
            spread(s.flip),
            format!("{}{biased}", report::bias(&s.bias)[0]),
            report::compared(s, s.compared),
            report::compared(s, s.compared_trimmed),
            s.peak_bytes.map_or(String::new(), |b| format!("{} MB", b / 1_000_000)),
        ]);
    }
    let numbers: Vec<usize> = (1..names.len()).collect();
    table(&rows, &numbers)
        + "\n  efficiency: 1/(MSE·s) over that of the base with as many samples, and its 95 % interval; ~ if not \
           told apart,\n  ≥ if the error is too small for the reference to tell.\n  trimmed: relMSE without the worst \
           0.1 % of pixels, and the efficiency by that\n"
}

/// The knobs with their values.
pub(super) fn knobs_help() -> String {
    let mut help = "Knob to vary, with the values that it is to have, separated by commas; may be repeated. What \
                    a setting has no use for is left out. Knobs:"
        .to_owned();
    for knob in knobs() {
        help += &format!("\n  {}: {}", knob.name, knob.values);
    }
    for &backend in Backend::AVAILABLE {
        for (key, values) in Accel::modes(backend) {
            help += &format!("\n  {key}: one of: {} (backend {backend})", values.join(", "));
        }
    }
    help += "\nAnother filter, max_depth, integrator or clamp than the reference's makes another picture, and that \
             counts as error.";
    help
}
