//! A line against a sphere or a disk.

use super::bound;
use super::span::{Line, Span};
use crate::shape::{Analytic, Crossing};

/// The bound for an analytic primitive: R is the distance of its box's farthest corner.
pub(super) fn bound_of(line: &Line, analytic: &dyn Analytic) -> f64 {
    bound(farthest(line, analytic))
}

/// Distance of its box's farthest corner, in units of the line's direction.
pub(super) fn reach(line: &Line, analytic: &dyn Analytic) -> f64 {
    farthest(line, analytic) / line.direction.length()
}

fn farthest(line: &Line, analytic: &dyn Analytic) -> f64 {
    let bounds = analytic.bounds();
    let [min, max] = [bounds.min, bounds.max].map(|p| (p.as_dvec3() - line.origin).abs());
    min.max(max).length()
}

/// The crossings, with the part of the line around each that is within the bound.
pub(super) fn crossings(
    line: &Line,
    analytic: &dyn Analytic,
) -> impl Iterator<Item = (Crossing, Span)> {
    let crossings = analytic.crossings(line.origin, line.direction);
    crossings.into_iter().flatten().filter_map(|c| Some((c, span_around(line, analytic, c.t)?)))
}

/// The part of the line around `t` that is within the bound of the primitive; `None` if `t` is not.
pub(super) fn span_around(line: &Line, analytic: &dyn Analytic, t: f64) -> Option<Span> {
    let bound = bound_of(line, analytic);
    let within = |t: f64| analytic.distance(line.origin + line.direction * t) <= bound;
    let end = |sign: f64| {
        let (mut inside, mut outside) = (0.0, bound / line.direction.length());
        // Doubled until it is outside; no primitive is 2^200 bounds long.
        for _ in 0..200 {
            if !within(t + sign * outside) {
                break;
            }
            inside = outside;
            outside *= 2.0;
        }
        for _ in 0..20 {
            let middle = 0.5 * (inside + outside);
            if within(t + sign * middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        t + sign * outside
    };
    within(t).then(|| Span { near: end(-1.0), far: end(1.0) })
}
