//! A plot on log axes, as SVG.

use std::fmt::Write;

use super::super::summary::Interval;
use super::{escape, significant};

const WIDTH: f64 = 680.0;
const HEIGHT: f64 = 440.0;
/// Left, right, top and bottom.
const MARGINS: [f64; 4] = [76.0, 16.0, 14.0, 52.0];

/// Height of a line of text.
const LINE: f64 = 20.0;

/// Colours that people with any kind of sight can tell apart (Okabe and Ito 2008).
const COLORS: [&str; 7] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#555555"];

/// How the parts of a plot look, as CSS.
pub(super) const STYLE: &str = "
svg text { fill: #222 }
.frame { fill: none; stroke: #999 } .grid { stroke: #e6e6e6 } .curve { stroke-width: 1.5; opacity: .8 }
.bar { stroke-width: 1.5 } .guide { stroke: #888; stroke-dasharray: 5 5 } .target { stroke: #a00; stroke-dasharray: 2 3 }
.front { fill: none; stroke: #bbb; stroke-width: 7; stroke-linejoin: round; opacity: .6 }
";

/// Points of one colour, joined by a line, by rising x.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// What they have in common.
    pub name: String,
    /// The points.
    pub points: Vec<Point>,
}

/// A point with error bars.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// What is shown to who points at it.
    pub name: String,
    /// Across, above 0.
    pub x: Interval,
    /// Up, above 0.
    pub y: Interval,
}

/// What is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// What x is, with its unit.
    pub x_label: &'static str,
    /// What y is.
    pub y_label: &'static str,
    /// The curves, each in a colour of its own.
    pub curves: Vec<Curve>,
    /// Slope of a dashed line to compare with.
    pub guide: Option<f64>,
    /// A horizontal line.
    pub target: Option<f64>,
    /// Corners of the Pareto front, by rising x.
    pub front: Vec<(f64, f64)>,
}

/// The colour of curve number `index`.
pub(super) fn color(index: usize) -> &'static str {
    COLORS[index % COLORS.len()]
}

/// One axis: from numbers above 0 to places on the page.
struct Axis {
    /// Logarithms to base 10.
    low: f64,
    high: f64,
    /// Where they are drawn.
    from: f64,
    to: f64,
}

impl Axis {
    /// An axis that holds all of `values`, with some room at both ends.
    fn over(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let logs: Vec<f64> = values.filter(|v| *v > 0.0 && v.is_finite()).map(f64::log10).collect();
        let low = logs.iter().copied().fold(f64::INFINITY, f64::min);
        let high = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if low > high {
            return Self { low: 0.0, high: 1.0, from, to };
        }
        let room = (0.06 * (high - low)).max(0.1);
        Self { low: low - room, high: high + room, from, to }
    }

    fn place(&self, value: f64) -> f64 {
        let log = value.max(f64::MIN_POSITIVE).log10().clamp(self.low, self.high);
        self.from + (log - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Powers of 10, with 2 and 5 times of them on short axes; on very short ones even steps.
    fn ticks(&self) -> Vec<f64> {
        let length = self.high - self.low;
        if length < 0.8 {
            return self.even_ticks();
        }
        let steps: &[f64] = if length > 2.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let decades = self.low.floor() as i32..=self.high.ceil() as i32;
        let all = decades.flat_map(|d| steps.iter().map(move |s| s * 10_f64.powi(d)));
        all.filter(|t| (self.low..=self.high).contains(&t.log10())).collect()
    }

    /// Multiples of 1, 2 or 5 times a power of 10, of which there are 3 to 8.
    fn even_ticks(&self) -> Vec<f64> {
        let (first, last) = (10_f64.powf(self.low), 10_f64.powf(self.high));
        let power = 10_f64.powf((0.25 * (last - first)).log10().floor());
        let step = [5.0, 2.0, 1.0].map(|s| s * power).into_iter().find(|s| 3.0 * s <= last - first);
        let step = step.unwrap_or(power);
        let counts = (first / step).ceil() as u32..=(last / step) as u32;
        counts.map(|n| f64::from(n) * step).collect()
    }
}

impl Plot {
    /// The plot as an SVG element of a page that has a style for it and names the curves.
    pub(super) fn svg(&self) -> String {
        format!(
            "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" font-size=\"13\">\n{}</svg>\n",
            self.inside()
        )
    }

    /// The plot as a file of its own, with the names of its curves below.
    #[must_use]
    pub fn file(&self) -> String {
        let height = HEIGHT + LINE * (self.curves.len() as f64 + 0.5);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" role=\"img\" \
             font-family=\"sans-serif\" font-size=\"13\">\n<style>{STYLE}</style>\n\
             <rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#fff\"/>\n{}",
            self.inside()
        );
        for (index, curve) in self.curves.iter().enumerate() {
            let y = HEIGHT + LINE * (index as f64 + 0.5);
            let (x, color) = (MARGINS[0], color(index));
            push(
                &mut svg,
                format_args!("<circle cx=\"{x}\" cy=\"{y:.1}\" r=\"4\" fill=\"{color}\"/>\n"),
            );
            text(&mut svg, (x + 12.0, y + 4.0), "start", &curve.name);
        }
        svg + "</svg>\n"
    }

    fn inside(&self) -> String {
        let points = || self.curves.iter().flat_map(|c| &c.points);
        let [left, right, top, bottom] = MARGINS;
        let x =
            Axis::over(points().flat_map(|p| [p.x.value, p.x.low, p.x.high]), left, WIDTH - right);
        let ys = points().flat_map(|p| [p.y.value, p.y.low.max(0.3 * p.y.value), p.y.high]);
        let y = Axis::over(ys.chain(self.target), HEIGHT - bottom, top);
        let mut svg = format!(
            "<rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\" class=\"frame\"/>\n",
            WIDTH - left - right,
            HEIGHT - top - bottom
        );
        self.draw_axes(&mut svg, &x, &y);
        self.draw_lines(&mut svg, &x, &y);
        for (index, curve) in self.curves.iter().enumerate() {
            draw_curve(&mut svg, curve, color(index), &x, &y);
        }
        svg
    }

    fn draw_axes(&self, svg: &mut String, x: &Axis, y: &Axis) {
        for tick in x.ticks() {
            let (at, label) = (x.place(tick), significant(tick));
            line(svg, "grid", (at, y.from), (at, y.to));
            text(svg, (at, y.from + 18.0), "middle", &label);
        }
        for tick in y.ticks() {
            let (at, label) = (y.place(tick), significant(tick));
            line(svg, "grid", (x.from, at), (x.to, at));
            text(svg, (x.from - 6.0, at + 4.0), "end", &label);
        }
        text(svg, (0.5 * (x.from + x.to), HEIGHT - 10.0), "middle", self.x_label);
        let middle = 0.5 * (y.from + y.to);
        push(
            svg,
            format_args!(
                "<text transform=\"translate(16 {middle:.1}) rotate(-90)\" text-anchor=\"middle\">\
                 {}</text>\n",
                escape(self.y_label)
            ),
        );
    }

    /// Target, Pareto front and guide.
    fn draw_lines(&self, svg: &mut String, x: &Axis, y: &Axis) {
        if let Some(target) = self.target {
            let at = y.place(target);
            line(svg, "target", (x.from, at), (x.to, at));
            text(svg, (x.to - 6.0, at - 5.0), "end", &format!("target {}", significant(target)));
        }
        let corners: Vec<_> = self.front.iter().map(|&(a, b)| (x.place(a), y.place(b))).collect();
        if let Some(&(first, _)) = corners.first() {
            let mut path = format!("M{first:.1} {:.1}", y.to);
            for (a, b) in &corners {
                push(&mut path, format_args!(" H{a:.1} V{b:.1}"));
            }
            push(&mut path, format_args!(" H{:.1}", x.to));
            push(svg, format_args!("<path d=\"{path}\" class=\"front\"/>\n"));
        }
        let Some(slope) = self.guide else { return };
        // Through the middle of the picture.
        let (width, height) = (x.high - x.low, y.high - y.low);
        let run = width.min(height / slope.abs());
        let (mx, my) = (0.5 * (x.low + x.high), 0.5 * (y.low + y.high));
        let end = |sign: f64| {
            let (a, b) = (mx + 0.5 * sign * run, my + 0.5 * sign * run * slope);
            (x.place(10_f64.powf(a)), y.place(10_f64.powf(b)))
        };
        line(svg, "guide", end(-1.0), end(1.0));
    }
}

fn draw_curve(svg: &mut String, curve: &Curve, color: &str, x: &Axis, y: &Axis) {
    let place = |p: &Point| (x.place(p.x.value), y.place(p.y.value));
    push(svg, format_args!("<g stroke=\"{color}\" fill=\"{color}\">\n"));
    let path: Vec<String> =
        curve.points.iter().map(place).map(|(a, b)| format!("{a:.1},{b:.1}")).collect();
    push(
        svg,
        format_args!("<polyline points=\"{}\" fill=\"none\" class=\"curve\"/>\n", path.join(" ")),
    );
    for p in &curve.points {
        let (a, b) = place(p);
        line(svg, "bar", (x.place(p.x.low), b), (x.place(p.x.high), b));
        line(svg, "bar", (a, y.place(p.y.low)), (a, y.place(p.y.high)));
        push(
            svg,
            format_args!(
                "<circle cx=\"{a:.1}\" cy=\"{b:.1}\" r=\"4\"><title>{}: {} s, {}</title></circle>\n",
                escape(&p.name),
                significant(p.x.value),
                significant(p.y.value)
            ),
        );
    }
    svg.push_str("</g>\n");
}

fn line(svg: &mut String, class: &str, (x1, y1): (f64, f64), (x2, y2): (f64, f64)) {
    push(
        svg,
        format_args!(
            "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" class=\"{class}\"/>\n"
        ),
    );
}

fn text(svg: &mut String, (x, y): (f64, f64), anchor: &str, label: &str) {
    push(
        svg,
        format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>\n",
            escape(label)
        ),
    );
}

fn push(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    text.write_fmt(arguments).expect("a string takes all that is written");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_has_ticks() {
        for (low, high, expected) in [
            (-3.0, 0.5, vec![0.001, 0.01, 0.1, 1.0]),
            (-0.1, 1.1, vec![1.0, 2.0, 5.0, 10.0]),
            (0.0, 0.7, vec![1.0, 2.0, 3.0, 4.0, 5.0]),
            (-1.0, -0.9, vec![0.1, 0.105, 0.11, 0.115, 0.12, 0.125]),
        ] {
            let ticks = Axis { low, high, from: 0.0, to: 1.0 }.ticks();
            let near = |(a, b): (&f64, &f64)| (a / b - 1.0).abs() < 1e-12;
            let alike = ticks.len() == expected.len() && ticks.iter().zip(&expected).all(near);
            assert!(alike, "{low} to {high}: {ticks:?}");
        }
    }
}
