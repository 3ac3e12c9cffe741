//! Hits that rounding makes up at the ends of a ray, and how they are told from true ones.
//!
//! A ray that leaves a surface starts from a point in f32 beside the exact one, and an engine places the primitives
//! around it by a few roundings of their size. So it may find the primitive that was left, one that shares an edge with
//! it, or one that passes between the exact point and its neighbour, where the ray from the exact point meets nothing.
//! No offset of the start is right: one that keeps clear of an engine's error on a large triangle jumps over whatever is
//! small beside it. Instead, each hit that is close enough to an end of its ray to be made up is decided in f64
//! from the exact point, in every engine and for both kinds of query, and passed over if it is not there.
//!
//! What decides is, in this order:
//! 1. A ray never meets what lies on or behind the plane that it leaves. This settles the primitive itself, coplanar
//!    neighbours and those beyond a convex edge, without any distance that could cancel.
//! 2. Else it meets what is before the exact point. If that is not clear from the distance, the side of the other plane
//!    decides on which the exact point is, if it is on one of them to the rounding of f64. Points of a mesh are kept off
//!    the edges of their triangle by more than that (`Triangle::meet`), so in the corner of a room each is before the
//!    other wall.
//!
//! 3. Next to a corner the exact point is within a rounding of several planes, and the rounded ray may pass an edge on the
//!    other side than the exact one. There what either meets counts: the rounded ray has been started behind its surface,
//!    and meets a closed mesh again after it has crossed the plane that it leaves.
//!
//! The exact point is that of the path, to 2⁻⁴⁸ of its coordinates; f32 rounds to 2⁻²⁴.

use glam::{DVec3, Vec3A};

use crate::math::UNIT_ROUNDOFF as U;
use crate::ray::{Between, Ray, RayEnd, Side};
use crate::shape::{Analytic, rounding_of};

/// Distances along a ray at which hits are in doubt.
#[derive(Clone, Copy, Debug)]
pub(super) struct Doubt {
    near: f32,
    far: f32,
}

impl Doubt {
    /// For an engine over shapes whose coordinates are `reach` at most.
    ///
    /// Let R = 2 `reach`: along an axis no vertex is farther from a start among them. The start and the engine's place of a
    /// plane are off by less than 32 u R (u = 2⁻²⁴; 8 u R for Embree's robust test, 6 u R for the lift and the roundings of the start), so
    /// a plane is met falsely at t ≤ 32 u R / cos, where cos is that of the ray with the plane's normal. For
    /// primitives in the plane that is left cos is known; others are in doubt up to 2¹¹ u R, which covers those that the
    /// ray meets at a cosine of more than 2⁻⁶, and starts that are kept from an edge. At an edge rays start in the plane of
    /// a neighbour, too, and there they are in doubt up to 2¹⁶ u R, for cosines of more than 2⁻¹¹.
    #[inline(always)]
    pub(super) fn new(ray: Between, reach: f32) -> Self {
        let length = |normal: Vec3A, others: f32| {
            let cosine = normal.dot(ray.direction).abs();
            reach * (others + 64.0 * U / cosine)
        };
        let (flat, flatter) = (4096.0 * U, 131_072.0 * U);
        let from_start = if ray.starts_at_edge { flatter } else { flat };
        Self {
            near: ray.start.map_or(-1.0, |normal| length(normal, from_start)),
            far: ray.end.map_or(f32::INFINITY, |normal| ray.t_max - length(normal, flat)),
        }
    }

    /// Whether a hit at this distance may be made up.
    #[inline(always)]
    pub(super) fn covers(self, t: f32) -> bool {
        t <= self.near || t >= self.far
    }
}

/// Whether the ray between its exact ends meets a triangle that an engine found, in doubt, at `t`.
#[cold]
pub(super) fn meets_triangle(ray: &Ray, t: f32, corners: [DVec3; 3]) -> bool {
    let (from, direction) = (ray.exact_origin(), exact_direction(ray));
    if ray.start.is_some_and(|start| !rises_from(&start, direction, &corners)) {
        return false;
    }
    if ray.end.is_some_and(|end| !rises_from(&end, -direction, &corners)) {
        return false;
    }
    let plane = Plane::new(corners);
    let facing = plane.cross.dot(direction);
    let unit = ray.direction.as_dvec3();
    let after_start = (ray.origin.as_dvec3() - from).dot(unit) + f64::from(t);
    // A triangle away from an end is met where the engine found it. At an end, its plane has to lie beyond the point; where
    // the rounded ray met it behind its exact start, the exact one has to meet it too, which may pass beside it.
    let starts_before = if plane.may_reach(from) {
        let is_ahead = plane.side(from) * facing < 0.0;
        is_ahead && (after_start > 0.0 || plane.is_met(from, direction))
            || ray.start.is_some_and(|start| plane.is_met_past_corner(ray, &start))
    } else {
        after_start > 0.0
    };
    let ends_behind = ray.end.is_none_or(|end| {
        if plane.may_reach(end.point) {
            plane.side(end.point) * facing > 0.0
        } else {
            after_start < (end.point - from).dot(unit)
        }
    });
    starts_before && ends_behind
}

/// A triangle and its plane.
struct Plane {
    corners: [DVec3; 3],
    edges: [DVec3; 2],
    /// Product of the edges.
    cross: DVec3,
}

impl Plane {
    fn new(corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        let edges = [b - a, c - a];
        Self { corners, edges, cross: edges[0].cross(edges[1]) }
    }

    /// Whether the triangle may pass between a point and what rounding makes of it, or the engine's place of it do so.
    fn may_reach(&self, point: DVec3) -> bool {
        let farthest = self.corners.iter().fold(0.0f64, |most, c| most.max(c.distance(point)));
        let reach = f64::from(U) * (8.0 * point.abs().element_sum() + 32.0 * farthest);
        self.distance(point) <= reach
    }

    /// Distance of a point from the triangle.
    fn distance(&self, point: DVec3) -> f64 {
        let [a, b, c] = self.corners;
        let inside =
            |from: DVec3, to: DVec3| self.cross.dot((to - from).cross(point - from)) >= 0.0;
        if inside(a, b) && inside(b, c) && inside(c, a) {
            return self.cross.dot(point - a).abs() / self.cross.length();
        }
        let to_edge = |from: DVec3, to: DVec3| {
            let along = (point - from).dot(to - from) / from.distance_squared(to);
            point.distance(from.lerp(to, along.clamp(0.0, 1.0)))
        };
        to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
    }

    /// Above 0 before the plane, below behind, and 0 in it, to the rounding of f64.
    fn side(&self, point: DVec3) -> f64 {
        let [a, ..] = self.corners;
        let height = self.cross.dot(point - a);
        let size = self.corners.iter().fold(point.abs(), |most, c| most.max(c.abs())).max_element();
        // A height errs by the roundings of the point and of the corners, and by those of the product of the edges.
        let skew = self.edges[0].length() * self.edges[1].length() * (point - a).length();
        if height.abs() <= TOUCHING * (size * self.cross.length() + skew) { 0.0 } else { height }
    }

    /// Whether a ray that was started behind the surface that it leaves, next to a corner of this triangle, reaches this plane
    /// after it has crossed that of its surface, and sees the side that it left of that: it may cross others from behind
    /// where it has missed its own. If it crosses that too flatly to tell where, not long before it passes the
    /// exact point.
    fn is_met_past_corner(&self, ray: &Ray, start: &RayEnd) -> bool {
        let rounding = rounding_of(start.point);
        let near = BY_CORNER * rounding;
        let unit = ray.direction.as_dvec3();
        let to_point = start.point - ray.origin.as_dvec3();
        let along = to_point.dot(unit);
        let by_corner = self.corners.iter().any(|corner| corner.distance(start.point) <= near);
        let sees_front = self.cross.dot(unit) < 0.0;
        if along <= near || !by_corner || sees_front != (start.side == Side::Front) {
            return false;
        }
        let normal = start.normal.as_dvec3();
        let crossing = normal.dot(to_point) / normal.dot(unit);
        let left =
            if (0.0..along).contains(&crossing) { crossing } else { along - AROUND * rounding };
        let to_corner = self.corners[0] - ray.origin.as_dvec3();
        self.cross.dot(to_corner) / self.cross.dot(unit) > left
    }

    /// Whether the line through `from` meets the triangle.
    fn is_met(&self, from: DVec3, direction: DVec3) -> bool {
        let r = (from - self.corners[0]).cross(direction);
        let facing = self.cross.dot(direction);
        let [u, v] = [-self.edges[1].dot(r) / facing, self.edges[0].dot(r) / facing];
        u >= 0.0 && v >= 0.0 && u + v <= 1.0
    }
}

/// The next distance after this one, which is 0 or more.
pub(super) fn after(t: f32) -> f32 {
    // The sum turns -0 into 0.
    f32::from_bits((t + 0.0).to_bits() + 1)
}

/// The first hit of an analytic primitive that is not made up.
pub(super) fn intersect_analytic(
    ray: &Ray,
    analytic: &dyn Analytic,
    doubt: Doubt,
) -> Option<(f32, f32, f32)> {
    let mut rest = *ray;
    loop {
        let hit = analytic.intersect(&rest)?;
        if !doubt.covers(hit.0) || meets_analytic(ray, analytic, hit.0) {
            return Some(hit);
        }
        rest.t_min = after(hit.0);
    }
}

/// Whether the ray between its exact ends meets an analytic primitive about at `t`: its crossing there has to be clear
/// of both ends.
#[cold]
fn meets_analytic(ray: &Ray, analytic: &dyn Analytic, t: f32) -> bool {
    let (from, direction) = (ray.exact_origin(), ray.direction.as_dvec3());
    let t = f64::from(t);
    let crossings = analytic.crossings(from, direction).into_iter().flatten().map(|c| c.t);
    let Some(crossing) = crossings.min_by(|a, b| (a - t).abs().total_cmp(&(b - t).abs())) else {
        // Only the rounded ray meets it, at its rim.
        return true;
    };
    let bounds = analytic.bounds();
    let reach = f64::from(bounds.min.abs().max(bounds.max.abs()).max_element());
    let clear = |end: &RayEnd, along: f64| {
        let cosine = end.normal.as_dvec3().dot(direction).abs();
        along * cosine > TOUCHING * (reach + end.point.abs().max_element())
    };
    ray.start.is_none_or(|start| clear(&start, crossing))
        && ray.end.is_none_or(|end| clear(&end, (end.point - from).dot(direction) - crossing))
}

/// Along the ray, of any length: between the exact ends where there are two.
fn exact_direction(ray: &Ray) -> DVec3 {
    match (ray.start, ray.end) {
        (Some(start), Some(end)) => end.point - start.point,
        _ => ray.direction.as_dvec3(),
    }
}

/// Whether any corner lies before the plane of a ray's end, on the side that `direction` leads to from there.
fn rises_from(end: &RayEnd, direction: DVec3, corners: &[DVec3; 3]) -> bool {
    let normal = end.normal.as_dvec3();
    let side = normal.dot(direction).signum();
    corners.iter().any(|&corner| {
        let to = corner - end.point;
        side * normal.dot(to) > NORMAL_ERROR * to.length()
    })
}

/// Distance from a surface, over the largest coordinate, below which a point is on it: 2⁻⁴⁸, 32 roundings of f64, since
/// the point may have gone through an instance's transform.
const TOUCHING: f64 = 3.552_713_678_800_501e-15;

/// Distance from a corner, in roundings of a point, within which a point is next to it. Points next to edges start their rays
/// by more than that behind their surface, and all others by less.
const BY_CORNER: f64 = 32.0;

/// Within this distance of an exact point, in the same unit, rays that leave it flatly may cross other surfaces.
const AROUND: f64 = 8.0;

/// By how much a unit normal in f32 may be turned: 2⁻²¹. What rises less from a plane is in it.
const NORMAL_ERROR: f64 = 4.768_371_582_031_25e-7;
