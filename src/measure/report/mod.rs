//! One page of HTML that needs nothing else: verdict, plots, tables, crops and how it was measured.

pub mod plot;
mod verdict;

pub use verdict::verdict;

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::bias::Bias;
use super::crops::{Shot, Shots};
use super::efficiency::Comparison;
use super::record::{Record, ReferenceOrigin};
use super::summary::{Findings, Interval, Spread, Summary};
use plot::{Curve, Plot, Point, color};

/// The page.
#[must_use]
pub fn html(
    record: &Record,
    findings: &Findings,
    sentences: &[String],
    shots: Option<&Shots>,
    target: f64,
) -> String {
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>Measured: {0}</title>\n<style>{STYLE}{1}</style>\n<h1>What a second buys: {0}</h1>\n",
        escape(&record.origin.scene),
        plot::STYLE
    );
    page += "<ul class=\"verdict\">\n";
    for sentence in sentences {
        add(&mut page, format_args!("<li>{}</li>\n", escape(sentence)));
    }
    page += "</ul>\n";
    page += &plots(findings, target);
    page += &table(findings);
    if let Some(shots) = shots {
        page += &crops(shots);
    }
    page += &origin(record);
    page += "</html>\n";
    page
}

const STYLE: &str = "
body { font: 16px/1.5 system-ui, sans-serif; max-width: 1400px; margin: 2em auto; padding: 0 1em; color: #222 }
h1 { font-size: 1.6em } h2 { font-size: 1.2em; margin-top: 2em }
.verdict li:first-child { font-size: 1.15em; font-weight: 600 }
.plots { display: flex; flex-wrap: wrap; gap: 1em } figure { margin: 0; flex: 1 1 480px }
svg { width: 100%; height: auto } figcaption { color: #555; font-size: .9em }
.key { display: flex; flex-wrap: wrap; gap: .3em 1.4em; font-size: .9em } .key i { display: inline-block; width: .8em;
height: .8em; border-radius: 50%; margin-right: .4em }
.wide { overflow-x: auto } table { border-collapse: collapse; font-size: .85em }
th, td { padding: .25em .6em; border-bottom: 1px solid #ddd; text-align: right; white-space: nowrap }
th:first-child, td:first-child { text-align: left } .bad { color: #a00; font-weight: 600 } small { color: #777 }
.crops { display: flex; flex-wrap: wrap; gap: 1em } .crops figure { flex: 0 0 192px }
.crops img { width: 192px; image-rendering: pixelated; display: block }
";

/// Error against time, twice.
fn plots(findings: &Findings, target: f64) -> String {
    let rmse = |s: &Summary| {
        let relative = 0.5 * s.mse.deviation / s.mse.mean / (s.runs as f64).sqrt();
        around(s.rmse, 2.0 * relative * s.rmse)
    };
    let rel_mse =
        |s: &Summary| around(s.rel_mse.mean, 2.0 * s.rel_mse.deviation / (s.runs as f64).sqrt());
    let front = findings
        .pareto
        .iter()
        .filter_map(|label| findings.settings.iter().find(|s| s.setting == *label))
        .map(|s| (s.seconds.value, s.rel_mse.mean))
        .collect();
    let rmse = Plot {
        x_label: "render time in seconds",
        y_label: "RMSE",
        curves: curves(findings, &rmse),
        guide: Some(-0.5),
        target: None,
        front: Vec::new(),
    };
    let rel_mse = Plot {
        x_label: "render time in seconds",
        y_label: "relMSE",
        curves: curves(findings, &rel_mse),
        guide: Some(-1.0),
        target: Some(target),
        front,
    };
    let mut html = String::from("<h2>Error against time</h2>\n<div class=\"key\">\n");
    for (index, series) in findings.series.iter().enumerate() {
        let slope = series.slope.map_or(String::new(), |(slope, error)| {
            format!(" <small>slope {slope:.2} ± {error:.2}</small>")
        });
        add(
            &mut html,
            format_args!(
                "<span><i style=\"background:{}\"></i>{}{slope}</span>\n",
                color(index),
                escape(&series.label)
            ),
        );
    }
    add(
        &mut html,
        format_args!(
            "</div>\n<div class=\"plots\">\n<figure>\n{}<figcaption>Dashed: slope −1/2, as independent \
             samples give without bias. Slopes are of RMSE over samples.</figcaption>\n</figure>\n\
             <figure>\n{}<figcaption>Grey: the Pareto front; no setting is better in both. Dashed: slope \
             −1.</figcaption>\n</figure>\n</div>\n<p><small>Points are means over seeds of the error without \
             the reference's own noise; vertical bars are two standard errors of it, horizontal ones the \
             fastest and the slowest run.</small></p>\n",
            rmse.svg(),
            rel_mse.svg()
        ),
    );
    html
}

fn around(value: f64, error: f64) -> Interval {
    Interval { value, low: value - error, high: value + error }
}

fn curves(findings: &Findings, error: &dyn Fn(&Summary) -> Interval) -> Vec<Curve> {
    let curve = |label: &str| {
        let mut points: Vec<Point> = findings
            .settings
            .iter()
            .filter(|s| s.series == label)
            .map(|s| Point { name: s.setting.clone(), x: s.seconds, y: error(s) })
            .filter(|p| p.y.value > 0.0)
            .collect();
        points.sort_by(|a, b| a.x.value.total_cmp(&b.x.value));
        Curve { name: label.to_owned(), points }
    };
    findings.series.iter().map(|s| curve(&s.label)).collect()
}

/// All settings with all metrics.
fn table(findings: &Findings) -> String {
    let mut html = String::from(
        "<h2>All settings</h2>\n<div class=\"wide\"><table>\n<tr><th>setting<th>spp<th>runs\
         <th>seconds<th>Mrays<th>RMSE<th>relMSE<th>trimmed<th>99.9 %<th>largest<th>SMAPE<th>FLIP\
         <th>bias<th>1/(MSE·s)<th>times the base's<th>by trimmed relMSE<th>memory</tr>\n",
    );
    for s in &findings.settings {
        let bias_class = if s.bias.is_biased { " class=\"bad\"" } else { "" };
        let compared = |comparison: Option<Comparison>| {
            comparison.map_or("1".to_owned(), |c| {
                let mark = if c.differs { "" } else { " <small>not told apart</small>" };
                format!("{}{}{mark}", at_least(s), ends(&c.ratio))
            })
        };
        let [bias, bias_error] = bias(&s.bias);
        let (by_mse, by_trimmed) = (compared(s.compared), compared(s.compared_trimmed));
        add(
            &mut html,
            format_args!(
                "<tr><td>{}<td>{}<td>{}<td>{}<td>{:.2}<td>{}<td>{}<td>{}<td>{}<td>{}<td>{}<td>{}\
                 <td{bias_class}>{bias} <small>± {bias_error}</small><td>{}{}<td>{by_mse}<td>{by_trimmed}<td>{}</tr>\n",
                escape(&s.setting),
                s.samples_per_pixel,
                s.runs,
                ends(&s.seconds),
                s.rays * 1e-6,
                significant(s.rmse),
                with_spread(s.rel_mse),
                with_spread(s.rel_mse_trimmed),
                with_spread(s.rel_se_quantile),
                with_spread(s.rel_se_max),
                with_spread(s.smape),
                with_spread(s.flip),
                at_least(s),
                ends(&s.efficiency),
                s.peak_bytes.map_or("not known".to_owned(), |b| format!("{} MB", b / 1_000_000)),
            ),
        );
    }
    html += "</table></div>\n<p><small>± standard deviation between seeds (of the bias: standard error); in \
             brackets 95 % intervals, of the seconds the fastest and slowest run. Trimmed: relMSE without the \
             worst 0.1 % of pixels; 99.9 % and largest: relative squared error of single pixels. RMSE and relMSE \
             are without the reference's own noise; ≥ where they are less than half of it, and so not known.\
             </small></p>\n";
    html
}

fn crops(shots: &Shots) -> String {
    let mut html = String::from("<h2>Side by side</h2>\n");
    let rows = [
        (format!("Equal time: {}", seconds(shots.seconds)), &shots.equal_time),
        (format!("Equal error: relMSE {}", significant(shots.target)), &shots.equal_error),
    ];
    for (title, row) in rows.into_iter().filter(|(_, row)| !row.is_empty()) {
        add(&mut html, format_args!("<h3>{}</h3>\n<div class=\"crops\">\n", escape(&title)));
        html += &figure(&shots.reference, "reference", "");
        for Shot { label, samples_per_pixel, seconds: time, rel_mse, png } in row {
            let what = format!(
                "{samples_per_pixel} spp, {}, relMSE here {}",
                seconds(*time),
                significant(*rel_mse)
            );
            html += &figure(png, label, &what);
        }
        html += "</div>\n";
    }
    if !shots.too_slow.is_empty() {
        let one = |(label, time): &(String, f64)| format!("{label} ({})", seconds(*time));
        let list: Vec<_> = shots.too_slow.iter().map(one).collect();
        let list = escape(&list.join("; "));
        add(
            &mut html,
            format_args!("<p><small>Too slow to be shown at equal error: {list}.</small></p>\n"),
        );
    }
    html += "<p><small>Where the reference's pixels vary most. Times are those that the whole picture would \
             take.</small></p>\n";
    html
}

fn figure(png: &[u8], label: &str, what: &str) -> String {
    let (data, label, what) = (STANDARD.encode(png), escape(label), escape(what));
    format!(
        "<figure><img alt=\"{label}\" src=\"data:image/png;base64,{data}\"><figcaption>{label}<br>\
         {what}</figcaption></figure>\n"
    )
}

/// How to measure it again.
fn origin(record: &Record) -> String {
    let o = &record.origin;
    let reference = match &o.reference {
        ReferenceOrigin::File { path, .. } => path.clone(),
        ReferenceOrigin::Rendered { samples_per_pixel } => {
            format!("the base with {samples_per_pixel} samples per pixel and seeds of its own")
        }
    };
    let rows = [
        ("Commands", record.commands.join("; ")),
        ("Program", {
            let commit = o.commit.as_deref().unwrap_or("unknown");
            let build = if o.debug_build { ", debug build: times mean little" } else { "" };
            format!("telamon {}, commit {commit}{build}", o.version)
        }),
        ("Engines", record.engines.join(", ")),
        ("Machine", format!("{}, {} threads", o.processor, o.processor_threads)),
        ("Scene", format!("{} (CRC-32 {:08x})", o.scene, o.scene_crc32)),
        ("Film", {
            let (x, y, w, h) = o.crop;
            format!("{}x{}, of which {w}x{h} at {x},{y}", o.film.0, o.film.1)
        }),
        ("Base", o.base.clone()),
        ("Seed", o.seed.to_string()),
        ("Reference", reference),
    ];
    let mut html = String::from("<h2>How it was measured</h2>\n<table>\n");
    for (name, value) in rows {
        add(
            &mut html,
            format_args!(
                "<tr><td>{name}<td style=\"text-align:left;white-space:normal\">{}</tr>\n",
                escape(&value)
            ),
        );
    }
    html += "</table>\n<p><small>Runs were made in rounds of one of each setting, each round in a random order of \
             its own. relMSE = mean((I − R)²/(R² + 0.01)); SMAPE = mean(|I − R|/(|I| + |R| + 0.01)); FLIP after \
             Andersson et al. 2020; bias = mean(I − R) over the reference's mean.</small></p>\n";
    html
}

fn with_spread(s: Spread) -> String {
    format!("{} <small>± {}</small>", significant(s.mean), rough(s.deviation))
}

fn ends(i: &Interval) -> String {
    if i.value.is_infinite() {
        return EXACT.to_owned();
    }
    let (value, low, high) = (significant(i.value), rough(i.low), rough(i.high));
    format!("{value} <small>({low}–{high})</small>")
}

/// In the place of an efficiency that is infinite since there is no error.
const EXACT: &str = "exact";

/// Before an efficiency that is a lower bound.
fn at_least(s: &Summary) -> &'static str {
    if s.is_unresolved { "≥ " } else { "" }
}

/// A setting's efficiency over that of the base: `2.13 (1.9–2.3)`, with ≥ before it if the setting's error is
/// lost in the reference's noise, and ~ after it if the two are not told apart.
#[must_use]
pub fn compared(s: &Summary, comparison: Option<Comparison>) -> String {
    let Some(Comparison { ratio, differs, .. }) = comparison else { return "1".to_owned() };
    if ratio.value.is_infinite() {
        return EXACT.to_owned();
    }
    let mark = if differs { "" } else { " ~" };
    let (value, low, high) = (significant(ratio.value), rough(ratio.low), rough(ratio.high));
    format!("{}{value} ({low}–{high}){mark}", at_least(s))
}

/// A bias and its standard error, over the reference's mean; as they are if that is black.
#[must_use]
pub fn bias(bias: &Bias) -> [String; 2] {
    if bias.relative.is_infinite() {
        return [significant(bias.value), rough(bias.error)];
    }
    [percent(bias.relative), format!("{} %", rough(100.0 * bias.relative_error.abs()))]
}

fn add(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    text.write_fmt(arguments).expect("a string takes all that is written");
}

/// Text as HTML and SVG need it.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A number with three significant digits.
#[must_use]
pub fn significant(value: f64) -> String {
    digits(value, 3)
}

/// A number with two significant digits, as errors and the ends of intervals need.
#[must_use]
pub fn rough(value: f64) -> String {
    digits(value, 2)
}

fn digits(value: f64, count: i32) -> String {
    let fraction = usize::try_from(count - 1).unwrap_or(0);
    let magnitude = value.abs();
    if value.is_infinite() {
        return if value > 0.0 { "∞" } else { "−∞" }.to_owned();
    }
    if value == 0.0 || value.is_nan() {
        return value.to_string();
    }
    if !(1e-3..9.995e5).contains(&magnitude) {
        return format!("{value:.fraction$e}");
    }
    // The exponent after rounding, so that 9.999 takes as many digits as 10.
    let rounded = format!("{magnitude:.fraction$e}");
    let exponent: i32 = rounded.split('e').nth(1).and_then(|e| e.parse().ok()).unwrap_or(0);
    let decimals = usize::try_from(count - 1 - exponent).unwrap_or(0);
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// A time with its unit.
#[must_use]
pub fn seconds(value: f64) -> String {
    if value < 0.9995 {
        return format!("{} ms", significant(1000.0 * value));
    }
    if value < 600.0 {
        format!("{} s", significant(value))
    } else {
        format!("{} min", significant(value / 60.0))
    }
}

/// A fraction in percent, with its sign.
#[must_use]
pub fn percent(value: f64) -> String {
    let text = significant(100.0 * value);
    if value >= 0.0 { format!("+{text} %") } else { format!("{} %", text.replace('-', "−")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        for (value, text) in [
            (0.0, "0"),
            (0.012_345, "0.0123"),
            (0.5, "0.5"),
            (9.999, "10"),
            (12.34, "12.3"),
            (123_456.0, "123456"),
            (1e6, "1.00e6"),
            (-1.5e-5, "-1.50e-5"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(significant(value), text);
        }
        assert_eq!([rough(0.012_345), rough(9.99), rough(1234.0)], ["0.012", "10", "1234"]);
        assert_eq!(seconds(0.0123), "12.3 ms");
        assert_eq!(seconds(12.0), "12 s");
        assert_eq!(seconds(1200.0), "20 min");
        assert_eq!(percent(-0.281), "−28.1 %");
        assert_eq!(percent(0.0012), "+0.12 %");
        assert_eq!(escape("a<b & \"c\""), "a&lt;b &amp; &quot;c&quot;");
    }
}
