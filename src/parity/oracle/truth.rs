//! What the referee finds along a ray, and what it says of answers.

use std::cell::OnceCell;
use std::ops::ControlFlow;

use super::cover::{self, Patch};
use super::nested::Nested;
use super::span::{Line, Span};
use super::triangle::Triangle;
use super::{MOST_NEAR, Oracle, analytic, corners, primitives_of};
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
    /// Distance of its farthest corner from the ray's origin, in units of the ray's direction: what its rounding
    /// grows with.
    pub reach: f64,
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
    /// Whether there are more than the referee looks at: `near` has some of them, `barriers` none.
    is_crowded: bool,
}

/// What is true of a hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Confirmed {
    /// Where the primitive is within its bound of the ray.
    pub(super) span: Span,
    /// Whether the distance of the hit is in there.
    pub(super) is_distance_right: bool,
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

    /// All that is within its bound of the ray's segment, whether crossed or not, in no order; some of it if
    /// [`Truth::is_crowded`].
    #[must_use]
    pub fn near(&self) -> &[Encounter] {
        &self.surroundings().near
    }

    /// The parts of the ray in which something must be hit, unless [`Truth::is_crowded`].
    #[must_use]
    pub fn barriers(&self) -> &[Span] {
        &self.surroundings().barriers
    }

    /// Whether more than [`MOST_NEAR`] primitives are within the bound of the ray.
    #[must_use]
    pub fn is_crowded(&self) -> bool {
        self.surroundings().is_crowded
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
            Answer::Closest(None) | Answer::Occluded(false) if self.is_crowded() => {
                Class::Undecided
            }
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
        let Some(Confirmed { span, is_distance_right }) = self.confirm(hit) else {
            return if self.near().is_empty() { Class::False } else { Class::Wrong };
        };
        let names = |e: &Encounter| e.names() == [hit.shape, hit.member, hit.primitive];
        // Nothing that the ray crosses lies before the first.
        let first = self.crossings.first();
        let is_twin = first.is_some_and(|f| f.span.meets(span));
        if !is_distance_right {
            Class::Distance
        } else if first.is_some_and(|f| names(f) && f.span.contains(hit.t.into())) {
            Class::Same
        } else if self.is_crowded() {
            if is_twin { Class::Twin } else { Class::Undecided }
        } else if self.barriers().iter().any(|b| b.far < span.near) {
            Class::Leak
        } else if is_twin {
            Class::Twin
        } else {
            Class::Silhouette
        }
    }

    /// What is true of a hit; `None` if the primitive that it names is nowhere within its bound of the ray, or if
    /// rounding does not explain which point of it the hit names.
    pub(super) fn confirm(&self, hit: &Hit) -> Option<Confirmed> {
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
                let is_there = triangle.is_near(crossing, clearance)
                    && triangle.is_passed_at(&line, hit.u, hit.v);
                let span = triangle.span(&line);
                let is_there = is_there && span.meets(line.segment);
                is_there.then(|| Confirmed { span, is_distance_right: span.contains(t) })
            }
            Geometry::Analytic(analytic) => {
                let span = analytic::span_around(&line, analytic, t)?;
                Some(Confirmed { span, is_distance_right: true })
            }
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
    let mut add = |encounter: Encounter| {
        if encounter.crossing.is_some_and(|t| line.segment.contains(t)) {
            found.push(encounter);
        }
    };
    let member = 0;
    let mut nested = Vec::new();
    oracle.tree.visit_crossed(line, |item| {
        let (index, primitive) = oracle.primitives[item as usize];
        let part = oracle.shapes[index as usize].as_ref();
        let shape = index;
        match part.geometry() {
            Geometry::Triangles { .. } | Geometry::Deforming(_) => {
                let triangle = Triangle::new(line, corners(part, primitive, line.ray.time));
                if let crossing @ Some(_) = triangle.crossing(line) {
                    let (clearance, reach) = (triangle.clearance(line), triangle.reach(line));
                    let span = triangle.span(line);
                    add(Encounter { shape, member, primitive, crossing, clearance, reach, span });
                }
            }
            Geometry::Analytic(analytic) => {
                for (Crossing { t, clearance }, span) in analytic::crossings(line, analytic) {
                    let (crossing, reach) = (Some(t), analytic::reach(line, analytic));
                    add(Encounter { shape, member, primitive, crossing, clearance, reach, span });
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
    let Surroundings { mut near, mut barriers, mut is_crowded } = Surroundings::default();
    let mut patches = Vec::new();
    let all_visited = oracle.tree.visit_near(line, |item| {
        let (index, primitive) = oracle.primitives[item as usize];
        let shape = oracle.shapes[index as usize].as_ref();
        let mut add = |crossing, clearance, reach, span: Span| {
            let meets = span.meets(line.segment);
            if meets {
                let (shape, member) = (index, 0);
                near.push(Encounter { shape, member, primitive, crossing, clearance, reach, span });
            }
            meets
        };
        match shape.geometry() {
            Geometry::Triangles { .. } | Geometry::Deforming(_) => {
                let triangle = Triangle::new(line, corners(shape, primitive, line.ray.time));
                let crossing = triangle.crossing(line);
                let clearance = triangle.clearance(line);
                let (reach, span) = (triangle.reach(line), triangle.span(line));
                if triangle.is_near(crossing, clearance) && add(crossing, clearance, reach, span) {
                    patches.push(Patch { triangle, span, crossed: crossing.is_some() });
                }
            }
            Geometry::Analytic(analytic) => {
                for (Crossing { t, clearance }, span) in analytic::crossings(line, analytic) {
                    if add(Some(t), clearance, analytic::reach(line, analytic), span)
                        && clearance > analytic::bound_of(line, analytic)
                    {
                        barriers.push(span);
                    }
                }
            }
            Geometry::Instance(_) => {}
        }
        if near.len() > MOST_NEAR { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    is_crowded |= all_visited.is_break();
    // All of them: what the bound is in a group's space may be more in the scene's, and so beyond the boxes.
    for (index, shape) in (0..).zip(&oracle.shapes) {
        let Geometry::Instance(instance) = shape.geometry() else { continue };
        if let Some(nested) = Nested::new(oracle, index, instance, &line.ray) {
            near.extend(nested.near().filter(|e| e.span.meets(line.segment)));
            barriers.extend(nested.barriers());
            is_crowded |= nested.is_crowded();
        }
        if near.len() > MOST_NEAR {
            is_crowded = true;
            break;
        }
    }
    if is_crowded {
        return Surroundings { near, barriers: Vec::new(), is_crowded };
    }
    barriers.extend(cover::barriers(line, &patches));
    // At an end of the segment a hit may be left out.
    barriers.retain(|b| b.lies_in(line.segment));
    Surroundings { near, barriers, is_crowded }
}
