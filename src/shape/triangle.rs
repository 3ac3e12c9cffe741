//! One triangle of a mesh: its normal and area, and the points on it.

use glam::{DVec3, Vec2 as GlamVec2, Vec3A};

use super::{NEAR_EDGE, NearEdge, OFF_EDGE, rounding_of};
use crate::math::real::{Double, Lanes, Mask, Real};
use crate::math::vector::{Vec2, Vec3};
use crate::math::{Frame, UNIT_ROUNDOFF as U};
use crate::ray::Ray;

/// A triangle in each lane with what is derived from its corners, in f64, where the corners' differences are exact or
/// nearly so.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle<R: Real = f32> {
    corner: Vec3<R::Double>,
    edge_1: Vec3<R::Double>,
    edge_2: Vec3<R::Double>,
    /// Product of the edges: along the normal, twice the area long.
    cross: Vec3<R::Double>,
    /// Unit normal: counter-clockwise corners face the viewer.
    pub(super) normal: Vec3<R>,
    pub(super) area: R::Double,
    /// A bound of the length of an edge: the sum of two.
    length: R,
}

/// A point on a triangle in each lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct TrianglePoint<R: Real = f32> {
    pub(super) position: Vec3<R::Double>,
    /// Those of the second and third corner.
    pub(super) weights: Vec2<R>,
}

/// A point of a triangle close to its edge.
pub(super) struct PointNearEdge {
    pub(super) point: TrianglePoint,
    /// See [`Interaction::near_edge`].
    pub(super) near_edge: NearEdge,
    /// Whether the ray passes the triangle by more than rounding of the point explains: an engine errs by more where
    /// triangles are larger than their distance from the origin, and may have taken a neighbour for it.
    pub(super) is_beyond: bool,
}

impl<R: Real> Triangle<R> {
    #[inline(always)]
    pub(super) fn new(corners: [Vec3<R>; 3]) -> Self {
        let [a, b, c] = corners;
        let length = ((b - a).abs() + (c - a).abs()).element_sum();
        let (a, b, c) = (a.widen(), b.widen(), c.widen());
        let (edge_1, edge_2) = (b - a, c - a);
        let cross = edge_1.cross(edge_2);
        let (normal, area) = normal_and_area(cross);
        Self { corner: a, edge_1, edge_2, cross, normal, area, length }
    }

    /// The point at the weights `[u, v]` of the second and third corner; never on an edge, where it would belong to other
    /// surfaces as well, but off it by at least 2⁻³⁰ of the triangle's height.
    #[inline(always)]
    pub(super) fn point(&self, weights: Vec2<R>) -> TrianglePoint<R> {
        const LEAST: f64 = 1.0 / (1u64 << 30) as f64;
        let inside = weights.map(|weight| weight.widen() * (1.0 - 3.0 * LEAST) + LEAST);
        TrianglePoint { position: self.position(inside), weights }
    }

    /// Where the ray that leaves the exact `origin` towards `direction` meets the triangle, and whether that is clear of
    /// its edges: elsewhere [`Triangle::meet_near_edge`] knows. Solved anew from the exact start of the ray, because weights
    /// in f32 place a point by as much as the triangle is large.
    #[inline(always)]
    pub(super) fn meet(
        &self,
        origin: Vec3<R::Double>,
        direction: Vec3<R>,
    ) -> (TrianglePoint<R>, R::Mask) {
        let solved = self.solve(origin, direction);
        let position = self.position(solved);
        let weights = solved.narrow();
        // A weight times twice the area is the distance from an edge times its length. NaN is not clear of edges.
        let third = (-(solved.x + solved.y) + 1.0).narrow();
        let least = weights.x.min(weights.y).min(third);
        let twice_area = self.area.narrow() * 2.0;
        let clear = (least * twice_area).gt(self.rounding(position) * NEAR_EDGE as f32);
        (TrianglePoint { position, weights }, clear)
    }

    /// The weights at which the line from `origin` meets the triangle's plane.
    ///
    /// With s from the corner to the ray's start and r = s × d, the weights are e₂·r and -e₁·r over -(e₁ × e₂)·d (Möller
    /// and Trumbore 1997, equation 6, with the factors of the triple products turned).
    #[inline(always)]
    fn solve(&self, origin: Vec3<R::Double>, direction: Vec3<R>) -> Vec2<R::Double> {
        let direction = direction.widen();
        let r = (origin - self.corner).cross(direction);
        let inverse = R::Double::splat(r.x.token(), -1.0) / self.cross.dot(direction);
        Vec2::new(self.edge_2.dot(r) * inverse, -self.edge_1.dot(r) * inverse)
    }

    #[inline(always)]
    fn position(&self, weights: Vec2<R::Double>) -> Vec3<R::Double> {
        self.corner + (self.edge_1 * weights.x + self.edge_2 * weights.y)
    }

    /// What rounding of a position to f32 moves it by, times a bound of the length of an edge. The second term is for
    /// points at the origin, which f64 places by roundings of the corners.
    #[inline(always)]
    fn rounding(&self, position: Vec3<R::Double>) -> R {
        const AT_ORIGIN: f32 = 1.0 / (1u32 << 16) as f32;
        let size = position.narrow().abs().element_sum() + self.length * AT_ORIGIN;
        size * U * self.length
    }

    /// The geometric and the shading normal at one of its points, for the normals of its corners if they have any.
    #[inline(always)]
    pub(super) fn normals(
        &self,
        weights: Vec2<R>,
        vertex_normals: Option<[Vec3<R>; 3]>,
    ) -> (Vec3<R>, Vec3<R>) {
        let Some([n0, n1, n2]) = vertex_normals else { return (self.normal, self.normal) };
        let Vec2 { x: u, y: v } = weights;
        let interpolated = n0 * ((-u + 1.0) - v) + n1 * u + n2 * v;
        // A zero or non-finite interpolated normal leaves the geometric one.
        let (n, exists) = interpolated.try_normalize();
        let shading = Vec3::select(exists, n, self.normal);
        // A file's vertex normals say which side is out, even where its winding does not.
        let turned = shading.dot(self.normal).lt(0.0);
        (Vec3::select(turned, -self.normal, self.normal), shading)
    }
}

impl Triangle {
    /// Where the ray truly meets the triangle, if it does, about at the distance `t`: to a share of the triangle's size that
    /// keeps out those that the ray leaves or meets far behind.
    pub(super) fn meet_inside(
        &self,
        ray: &Ray,
        t: f32,
    ) -> Option<(TrianglePoint, Option<NearEdge>)> {
        const SHARE: f64 = 1.0 / 1024.0;
        let origin = ray.exact_origin().into();
        let direction = ray.direction.into();
        let solved = self.solve(origin, direction);
        let Vec2 { x: u, y: v } = solved;
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
        let from_start = self.position(solved) - Vec3::from(ray.origin.as_dvec3());
        let along = from_start.dot(direction.widen());
        let near = (along - f64::from(t)).abs() <= SHARE * f64::from(self.length);
        if !(inside && near) {
            return None;
        }
        let (point, clear) = self.meet(origin, direction);
        if clear {
            return Some((point, None));
        }
        let close = self.meet_near_edge(origin, direction, solved.narrow());
        Some((close.point, Some(close.near_edge)))
    }

    /// As [`Triangle::meet`], for weights close to an edge or, by the rounding of an engine, beyond: moved off the edge,
    /// to the triangle's side, by a few roundings of f64, so that it is decided on which side of others that share
    /// the edge the point is. Where the solved weights are not those that were found by more than rounding explains, as
    /// for a ray in the triangle's plane, those are taken.
    #[cold]
    pub(super) fn meet_near_edge(
        &self,
        origin: Vec3<f64>,
        direction: Vec3,
        found: Vec2,
    ) -> PointNearEdge {
        // Of a distance from an edge, times the edge's length, over twice the area.
        let edges = [self.edge_2, self.edge_1, self.edge_2 - self.edge_1].map(Vec3::length);
        let weight = |distance: f64| edges.map(|length| distance * length / (2.0 * self.area));
        let solved = self.solve(origin, direction).to_array();
        let found = found.widen().to_array();
        let near = [0, 1].iter().all(|&i| (solved[i] - found[i]).abs() < 1e-3);
        let [u, v] = if near { solved } else { found };
        let place = |[u, v]: [f64; 2]| DVec3::from(self.position(Vec2::new(u, v)));
        let beyond = weight(8.0 * rounding_of(place([u, v])));
        let is_beyond = near && (u < -beyond[0] || v < -beyond[1] || 1.0 - u - v < -beyond[2]);
        let u = u.clamp(0.0, 1.0);
        let v = v.clamp(0.0, 1.0 - u);
        let size = place([u, v]).abs().element_sum() + f64::from(self.length);
        let [u, v] = at_least([u, v], weight(OFF_EDGE * size));
        let position = place([u, v]);
        let shifted = |distance: f64| place(at_least([u, v], weight(distance)));
        PointNearEdge {
            point: TrianglePoint {
                position: position.into(),
                weights: Vec2::new(u as f32, v as f32),
            },
            near_edge: NearEdge::new(position, self.length.into(), shifted),
            is_beyond,
        }
    }

    /// The weights of the second and third corner at the point of the triangle's plane that is nearest to `position`.
    pub(super) fn weights_at(&self, position: Vec3<f64>) -> Vec2 {
        let from = position - self.corner;
        let inverse = 1.0 / self.cross.length_squared();
        let weight = |cross: Vec3<f64>| (cross.dot(self.cross) * inverse) as f32;
        Vec2::new(weight(from.cross(self.edge_2)), weight(self.edge_1.cross(from)))
    }
}

/// Weights of the second and third corner such that all three, that of the first last, are about at least these, as far as
/// that is possible.
fn at_least([u, v]: [f64; 2], least: [f64; 3]) -> [f64; 2] {
    let weights = [u, v, 1.0 - u - v];
    let [u, v, w] = [0, 1, 2].map(|i| weights[i].max(least[i].min(1.0)));
    [u, v].map(|weight| weight / (u + v + w))
}

/// Weights of a point of the triangle. Engines may report some slightly outside; inside, interpolation
/// cannot overshoot.
#[inline(always)]
pub(super) fn clamp(b: GlamVec2) -> [f32; 2] {
    let inside = b.x >= 0.0 && b.y >= 0.0 && b.x + b.y <= 1.0;
    if inside {
        return [b.x, b.y];
    }
    let u = b.x.clamp(0.0, 1.0);
    [u, b.y.clamp(0.0, 1.0 - u)]
}

/// Texture coordinates at a point, for those of the corners: its weights where they have none.
pub(super) fn uv(weights: GlamVec2, corners: Option<[GlamVec2; 3]>) -> GlamVec2 {
    let [u, v] = clamp(weights);
    corners.map_or(GlamVec2::new(u, v), |[t0, t1, t2]| t0 * (1.0 - u - v) + t1 * u + t2 * v)
}

/// Derivatives of the position after both texture coordinates, for those of the corners: directions along the
/// triangle where they have none, or two the same.
pub(super) fn tangents(corners: [Vec3A; 3], uvs: Option<[GlamVec2; 3]>) -> [Vec3A; 2] {
    let [p0, p1, p2] = corners;
    let by_uv = uvs.map(|uvs| {
        let [t0, t1, t2] = uvs.map(|uv| uv.as_dvec2());
        let (t1, t2) = (t1 - t0, t2 - t0);
        let (e1, e2) = ((p1 - p0).as_dvec3(), (p2 - p0).as_dvec3());
        let determinant = t1.perp_dot(t2);
        [(e1 * t2.y - e2 * t1.y) / determinant, (e2 * t1.x - e1 * t2.x) / determinant]
            .map(|d| d.as_vec3a())
    });
    by_uv.filter(|[u, v]| u.is_finite() && v.is_finite()).unwrap_or_else(|| {
        let frame = Frame::from_normal(Triangle::<f32>::new(corners.map(Vec3::from)).normal);
        [frame.s, frame.t].map(Vec3A::from)
    })
}

/// The unit normal of a triangle and its area, from the product of its edges in f64, which is exact to a few roundings
/// of that. In f32 where the square of its length stays in range.
#[inline(always)]
fn normal_and_area<R: Real>(cross: Vec3<R::Double>) -> (Vec3<R>, R::Double) {
    let n = cross.narrow();
    let length_squared = n.length_squared();
    let in_range = length_squared.ge(1e-30) & length_squared.lt(1e30);
    let length = length_squared.sqrt();
    let (normal, area) = (n / length, length.widen() * 0.5);
    if in_range.all() {
        return (normal, area);
    }
    let length = cross.length();
    let (exact, exact_area) = ((cross / length).narrow(), length * 0.5);
    (Vec3::select(in_range, normal, exact), R::Double::select(in_range, area, exact_area))
}
