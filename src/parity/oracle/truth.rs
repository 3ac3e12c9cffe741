//! What the referee finds along a ray, and what it says of answers.

use std::cell::OnceCell;

use super::cover::{self, Patch};
use super::nested::Nested;
use super::span::{Line, Span};
use super::triangle::Triangle;
use super::{Oracle, analytic, corners, primitives_of};
use crate::parity::{Answer, Class};
use crate::ray::{Hit, Ray};
use crate::shape::{Crossing, Geometry};

/// A primitive that a ray crosses, or comes near enough for rounding to confuse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encounter {
    /// Index of the shape.
    pub shape: u32,
    /// Index of the shape in the group, if `shape` is an instance; else 0.
    pub member: u32,
    /// Index of the primitive in the shape.
    pub primitive: u32,
    /// Distance along the ray, in units of its direction, of the point where it truly crosses; `None` where
    /// it passes beside, or within the plane.
    pub crossing: Option<f64>,
    /// Distance of the ray's line from the nearest edge or rim, in scene units; of an instance in those of the
    /// group along the ray.
    pub clearance: f64,
    /// The part of the ray that may be within the bound of the primitive.
    pub span: Span,
}

/// What lies along a ray. What is asked for rarely is found out when it is.
#[derive(Debug)]
pub struct Truth<'a> {
    oracle: &'a Oracle,
    line: Option<Line>,
    crossings: Vec<Encounter>,
    surroundings: OnceCell<Surroundings>,
}

/// What is within the bound of a ray.
#[derive(Debug, Default)]
struct Surroundings {
    near: Vec<Encounter>,
    barriers: Vec<Span>,
}

impl<'a> Truth<'a> {
    pub(super) fn new(oracle: &'a Oracle, ray: &Ray) -> Self {
        let line = Line::new(ray);
        let mut crossings = line.map_or(Vec::new(), |line| crossings(oracle, &line));
        let t = |e: &Encounter| e.crossing.unwrap_or(f64::INFINITY);
        crossings.sort_unstable_by(|a, b| t(a).total_cmp(&t(b)).then(a.names().cmp(&b.names())));
        Self { oracle, line, crossings, surroundings: OnceCell::new() }
    }

    /// What the ray truly crosses within its segment, in this order; of several at one point those with the
    /// smallest numbers first.
    #[must_use]
    pub fn crossings(&self) -> &[Encounter] {
        &self.crossings
    }

    /// All that is within its bound of the ray's segment, whether crossed or not, in no order.
    #[must_use]
    pub fn near(&self) -> &[Encounter] {
        &self.surroundings().near
    }

    /// The parts of the ray in which something must be hit.
    #[must_use]
    pub fn barriers(&self) -> &[Span] {
        &self.surroundings().barriers
    }

    fn surroundings(&self) -> &Surroundings {
        self.surroundings.get_or_init(|| {
            self.line.map_or_else(Surroundings::default, |line| surroundings(self.oracle, &line))
        })
    }

    /// What is to be said of an answer.
    #[must_use]
    pub fn judge(&self, answer: &Answer) -> Class {
        let crosses = !self.crossings.is_empty();
        match answer {
            Answer::Closest(Some(hit)) => self.judge_hit(hit),
            Answer::Closest(None) | Answer::Occluded(false) if !crosses => Class::Same,
            Answer::Closest(None) | Answer::Occluded(false) if self.barriers().is_empty() => {
                Class::Silhouette
            }
            Answer::Closest(None) | Answer::Occluded(false) => Class::Leak,
            Answer::Occluded(true) if crosses => Class::Same,
            Answer::Occluded(true) if self.near().is_empty() => Class::False,
            Answer::Occluded(true) => Class::Silhouette,
        }
    }

    fn judge_hit(&self, hit: &Hit) -> Class {
        let Some(span) = self.confirm(hit) else {
            return if self.near().is_empty() { Class::False } else { Class::Wrong };
        };
        let t = f64::from(hit.t);
        let names = |e: &Encounter| e.names() == [hit.shape, hit.member, hit.primitive];
        // Nothing that the ray crosses lies before the first.
        let first = self.crossings.first();
        if first.is_some_and(|f| names(f) && f.span.contains(t)) {
            Class::Same
        } else if self.barriers().iter().any(|b| b.far < span.near) {
            Class::Leak
        } else if first.is_some_and(|f| f.span.meets(span)) && span.contains(t) {
            Class::Twin
        } else {
            Class::Silhouette
        }
    }

    /// Where the primitive that a hit names is within its bound of the ray; `None` if it is nowhere, or if
    /// rounding does not explain what the hit says of it.
    pub(super) fn confirm(&self, hit: &Hit) -> Option<Span> {
        let line = self.line?;
        // Within two roundings of the ends of the segment.
        const SLACK: f32 = 2.0 * f32::EPSILON;
        let Ray { t_min, t_max, .. } = line.ray;
        let within = hit.t >= t_min * (1.0 - SLACK) && hit.t <= t_max * (1.0 + SLACK);
        let t = f64::from(hit.t);
        let shape = self.oracle.shapes.get(hit.shape as usize)?;
        if !within || !t.is_finite() {
            return None;
        }
        if let Geometry::Instance(instance) = shape.geometry() {
            return Nested::new(self.oracle, hit.shape, instance, &line.ray)?.confirm(hit);
        }
        if hit.member != 0 || hit.primitive >= primitives_of(shape.as_ref()) {
            return None;
        }
        match shape.geometry() {
            Geometry::Triangles { .. } | Geometry::Deforming(_) => {
                let corners = corners(shape.as_ref(), hit.primitive, line.ray.time);
                let triangle = Triangle::new(&line, corners);
                let (crossing, clearance) = (triangle.crossing(&line), triangle.clearance(&line));
                let confirmed = triangle.is_near(crossing, clearance)
                    && triangle.plane_span(&line).contains(t)
                    && triangle.is_passed_at(&line, hit.u, hit.v);
                confirmed.then(|| triangle.span(&line))
            }
            Geometry::Analytic(analytic) => analytic::span_around(&line, analytic, t),
            Geometry::Instance(_) => None,
        }
    }
}

impl Encounter {
    fn names(&self) -> [u32; 3] {
        [self.shape, self.member, self.primitive]
    }
}

/// What the ray crosses within its segment.
fn crossings(oracle: &Oracle, line: &Line) -> Vec<Encounter> {
    let mut found = Vec::new();
    let mut add = |shape, primitive, t, clearance, span| {
        if line.segment.contains(t) {
            let crossing = Some(t);
            found.push(Encounter { shape, member: 0, primitive, crossing, clearance, span });
        }
    };
    let mut nested = Vec::new();
    oracle.tree.visit_crossed(line, |item| {
        let (index, primitive) = oracle.primitives[item as usize];
        let shape = oracle.shapes[index as usize].as_ref();
        match shape.geometry() {
            Geometry::Triangles { .. } | Geometry::Deforming(_) => {
                let triangle = Triangle::new(line, corners(shape, primitive, line.ray.time));
                if let Some(t) = triangle.crossing(line) {
                    add(index, primitive, t, triangle.clearance(line), triangle.span(line));
                }
            }
            Geometry::Analytic(analytic) => {
                for (crossing, span) in analytic::crossings(line, analytic) {
                    add(index, primitive, crossing.t, crossing.clearance, span);
                }
            }
            Geometry::Instance(instance) => {
                nested.extend(Nested::new(oracle, index, instance, &line.ray));
            }
        }
    });
    let within = |e: &Encounter| e.crossing.is_some_and(|t| line.segment.contains(t));
    found.extend(nested.iter().flat_map(Nested::crossings).filter(within));
    found
}

/// What is within the bound of the ray's segment.
fn surroundings(oracle: &Oracle, line: &Line) -> Surroundings {
    let Surroundings { mut near, mut barriers } = Surroundings::default();
    let mut patches = Vec::new();
    oracle.tree.visit_near(line, |item| {
        let (index, primitive) = oracle.primitives[item as usize];
        let shape = oracle.shapes[index as usize].as_ref();
        let mut add = |crossing, clearance, span: Span| {
            let meets = span.meets(line.segment);
            if meets {
                let (shape, member) = (index, 0);
                near.push(Encounter { shape, member, primitive, crossing, clearance, span });
            }
            meets
        };
        match shape.geometry() {
            Geometry::Triangles { .. } | Geometry::Deforming(_) => {
                let triangle = Triangle::new(line, corners(shape, primitive, line.ray.time));
                let crossing = triangle.crossing(line);
                let clearance = triangle.clearance(line);
                let span = triangle.span(line);
                if triangle.is_near(crossing, clearance) && add(crossing, clearance, span) {
                    patches.push(Patch { triangle, span, crossed: crossing.is_some() });
                }
            }
            Geometry::Analytic(analytic) => {
                for (Crossing { t, clearance }, span) in analytic::crossings(line, analytic) {
                    if add(Some(t), clearance, span)
                        && clearance > analytic::bound_of(line, analytic)
                    {
                        barriers.push(span);
                    }
                }
            }
            Geometry::Instance(_) => {}
        }
    });
    // All of them: what the bound is in a group's space may be more in the scene's, and so beyond the boxes.
    for (index, shape) in (0..).zip(&oracle.shapes) {
        let Geometry::Instance(instance) = shape.geometry() else { continue };
        if let Some(nested) = Nested::new(oracle, index, instance, &line.ray) {
            near.extend(nested.near().filter(|e| e.span.meets(line.segment)));
            barriers.extend(nested.barriers());
        }
    }
    barriers.extend(cover::barriers(line, &patches));
    // At an end of the segment a hit may be left out.
    barriers.retain(|b| b.lies_in(line.segment));
    Surroundings { near, barriers }
}
