//! The document: tables, plots and prose.

use std::fmt::Write;

use telamon::measure::efficiency::Comparison;
use telamon::measure::report::plot::{Curve, Plot, Point};
use telamon::measure::report::{self, rough, significant};
use telamon::measure::statistics::{median, quantile, sorted};
use telamon::measure::summary::{Interval, Spread, Summary};

use crate::Found;
use crate::trial::{Measured, Trial};

/// The whole document.
pub(crate) fn document(all: &[Found]) -> String {
    let mut text = HEAD.to_owned();
    for (number, (section, measured)) in all.iter().enumerate() {
        put(&mut text, format_args!("\n## {}. {}\n\n", number + 1, section.title));
        put(&mut text, format_args!("{}\n\n", section.question));
        let [first, second] = (section.shows)(measured);
        put(&mut text, format_args!("**What it shows.** {first} {second}\n"));
        for (trial, measured) in section.trials.iter().zip(measured) {
            text += &table(trial, measured);
        }
    }
    text
}

const HEAD: &str = "\
# The trade

What a second of rendering buys, measured for the choices that a course on path tracing presents. Written by

```sh
cargo run --release --example the_trade
```

from runs that are stored beside the plots in `docs/the-trade/`, with the seed, time and metrics of each; the prose is checked
against them by `cargo test --example the_trade`. The same can be asked of any scene with `telamon measure`.

How to read the tables:

- Every setting is rendered with several seeds, in rounds whose order is shuffled, so that what slows the machine down for a
  while falls on all alike. Times are medians, with the fastest and the slowest run in brackets; they are those of rendering, without
  loading and building.
- Errors are against a reference of the same scene. *relMSE* is the mean of (I - R)² / (R² + 0.01) without the reference's own
  noise; *trimmed* leaves out the worst pixel of each thousand, because those at the edges of a lamp outweigh the rest of a picture. ±
  is the standard deviation between seeds.
- *Bias* is the mean difference from the reference over its mean; **biased** stands where Student's t-test over seeds rejects
  chance (0.01 for all settings of a table together).
- *Efficiency* is 1/(MSE · time) over that of the first setting with as many samples, or of the first of all: what it buys
  at equal time. 2 means half the variance after the same second. In brackets the 95 % interval of a bootstrap over seeds; ~
  where Welch's t-test does not tell the two apart. The last column has the trimmed relMSE in the place of the MSE; it is what the
  sentences speak of.
- Plots are on log axes. Vertical bars are two standard errors, horizontal ones the fastest and the slowest run; dashed is
  what more samples without bias give.
";

/// The plot of a trial: error against time, or the time to build against that to render.
pub(crate) fn figure(trial: &Trial, measured: &Measured) -> String {
    let settings = &measured.findings.settings;
    let point = |s: &Summary| {
        let y = if trial.builds { build_time(measured, s) } else { error(s) };
        Point { name: s.setting.clone(), x: s.seconds, y }
    };
    let curve = |label: &str| {
        let mut points: Vec<Point> =
            settings.iter().filter(|s| s.series == label).map(point).collect();
        points.retain(|p| p.y.value > 0.0);
        points.sort_by(|a, b| a.x.value.total_cmp(&b.x.value));
        Curve { name: label.to_owned(), points }
    };
    let plot = Plot {
        x_label: "render time in seconds",
        y_label: if trial.builds {
            "build time in seconds"
        } else {
            "relMSE without the worst pixel of each thousand"
        },
        curves: measured.findings.series.iter().map(|s| curve(&s.label)).collect(),
        guide: if trial.builds { None } else { Some(-1.0) },
        target: None,
        front: Vec::new(),
    };
    plot.file()
}

/// Mean over seeds, with two standard errors.
fn error(s: &Summary) -> Interval {
    let Spread { mean, deviation } = s.rel_mse_trimmed;
    let error = 2.0 * deviation / (s.runs as f64).sqrt();
    Interval { value: mean, low: mean - error, high: mean + error }
}

/// Median, shortest and longest.
fn build_time(measured: &Measured, s: &Summary) -> Interval {
    let builds = sorted(measured.builds(&s.setting).iter().copied());
    Interval {
        value: median(builds.iter().copied()),
        low: quantile(&builds, 0.0),
        high: quantile(&builds, 1.0),
    }
}

/// Plot, table and origin of a trial.
fn table(trial: &Trial, measured: &Measured) -> String {
    let mut text = format!(
        "\n![{}](the-trade/{}.svg)\n\n| Setting | {}Seconds | Mrays/s | relMSE | trimmed | Bias \
         | Efficiency | by trimmed |\n|---|{}---|---|---|---|---|---|---|\n",
        if trial.builds { "Time to build against time to render" } else { "Error against time" },
        trial.name,
        if trial.builds { "Build | " } else { "" },
        if trial.builds { "---|" } else { "" },
    );
    for s in &measured.findings.settings {
        let row = [
            format!("`{}`", s.setting.replace(", ", "` `")),
            interval(&s.seconds),
            significant(s.rays / s.seconds.value * 1e-6),
            spread(&s.rel_mse),
            spread(&s.rel_mse_trimmed),
            bias(s),
            report::compared(s, s.compared),
            report::compared(s, s.compared_trimmed),
        ];
        let (setting, rest) = row.split_first().expect("eight cells");
        let build = if trial.builds {
            format!(" {} |", interval(&build_time(measured, s)))
        } else {
            String::new()
        };
        put(&mut text, format_args!("| {setting} |{build} {} |\n", rest.join(" | ")));
    }
    if !measured.stored.leaks.is_empty() {
        text += "\n| Setting | Wrong for random rays | Wrong for aimed rays |\n|---|---|---|\n";
        for leaks in &measured.stored.leaks {
            let setting = leaks.setting.replace(", ", "` `");
            let cell =
                |(rays, wrong): (u64, u64)| format!("{wrong} of {rays} ({})", share((rays, wrong)));
            let (random, aimed) = (cell(leaks.random), cell(leaks.aimed));
            put(&mut text, format_args!("| `{setting}` | {random} | {aimed} |\n"));
        }
    }
    text + &origin(trial, measured)
}

fn origin(trial: &Trial, measured: &Measured) -> String {
    let fixed: Vec<_> = trial.fixed.iter().map(|(k, v)| format!("`{k}={v}`")).collect();
    let fixed = if fixed.is_empty() { String::new() } else { format!(", {}", fixed.join(" ")) };
    format!(
        "\n<sub>{} at {}x{}{fixed}; {} seeds; reference with {} samples per pixel. {}, commit {}, {}, {} on {} \
         threads. [Runs](the-trade/{}.json)</sub>\n",
        trial.subject.name(),
        trial.size.0,
        trial.size.1,
        trial.repeats,
        measured.stored.reference_samples_per_pixel,
        measured.stored.date,
        measured.stored.commit,
        measured.stored.engines.join("; "),
        measured.stored.processor,
        measured.stored.threads,
        trial.name
    )
}

fn interval(i: &Interval) -> String {
    format!("{} ({}–{})", significant(i.value), rough(i.low), rough(i.high))
}

fn spread(s: &Spread) -> String {
    format!("{} ± {}", significant(s.mean), rough(s.deviation))
}

fn bias(s: &Summary) -> String {
    let text = report::bias(&s.bias).join(" ± ");
    if s.bias.is_biased { format!("{text} **biased**") } else { text }
}

/// The share of rays that are wrong: `0.12 %`, or `none`.
pub(crate) fn share((rays, wrong): (u64, u64)) -> String {
    match wrong {
        0 => "none".to_owned(),
        _ => format!("{} %", rough(100.0 * wrong as f64 / rays as f64)),
    }
}

/// `2.1 (1.9 to 2.3)`, or that this is not told apart from 1.
pub(crate) fn times(comparison: Option<Comparison>) -> String {
    let Some(c) = comparison else { return "1".to_owned() };
    let Interval { value, low, high } = c.ratio;
    let known = if c.differs { "" } else { ", not told apart from 1" };
    format!("{} ({} to {}{known})", rough(value), rough(low), rough(high))
}

fn put(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    text.write_fmt(arguments).expect("a string takes all that is written");
}
