//! One triangle of a mesh: its normal and area, and the points on it.

use glam::{DVec3, Vec2, Vec3, Vec3A};

use super::{NEAR_EDGE, NearEdge, OFF_EDGE, SurfacePoint, rounding_of};
use crate::math::{Frame, UNIT_ROUNDOFF as U};
use crate::ray::Ray;

/// A triangle with what is derived from its corners, in f64, where the corners' differences are exact or nearly so.
pub(super) struct Triangle {
    corners: [Vec3A; 3],
    corner: DVec3,
    edge_1: DVec3,
    edge_2: DVec3,
    /// Product of the edges: along the normal, twice the area long.
    cross: DVec3,
    /// Unit normal: counter-clockwise corners face the viewer.
    pub(super) normal: Vec3A,
    pub(super) area: f64,
}

/// A point on a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct TrianglePoint {
    pub(super) position: DVec3,
    /// Those of the second and third corner.
    pub(super) weights: [f32; 2],
    /// See [`SurfacePoint::near_edge`].
    near_edge: Option<NearEdge>,
    /// Whether the ray passes the triangle by more than rounding of the point explains: an engine errs by more where
    /// triangles are larger than their distance from the origin, and may have taken a neighbour for it.
    pub(super) is_beyond: bool,
}

impl Triangle {
    #[inline(always)]
    pub(super) fn new(corners: [Vec3A; 3]) -> Self {
        let [a, b, c] = corners.map(|corner| corner.as_dvec3());
        let (edge_1, edge_2) = (b - a, c - a);
        let cross = edge_1.cross(edge_2);
        let (normal, area) = normal_and_area(cross);
        Self { corners, corner: a, edge_1, edge_2, cross, normal, area }
    }

    /// The point at the weights `[u, v]` of the second and third corner; never on an edge, where it would belong to other
    /// surfaces as well, but off it by at least 2⁻³⁰ of the triangle's height.
    #[inline(always)]
    pub(super) fn point(&self, weights: [f32; 2]) -> TrianglePoint {
        const LEAST: f64 = 1.0 / (1u64 << 30) as f64;
        let [u, v] = weights.map(|weight| f64::from(weight) * (1.0 - 3.0 * LEAST) + LEAST);
        TrianglePoint { position: self.position(u, v), weights, near_edge: None, is_beyond: false }
    }

    /// Where `ray` meets the triangle: solved anew from the exact start of the ray, because weights in f32 place a
    /// point by as much as the triangle is large. `found` are the weights that an engine has.
    #[inline(always)]
    pub(super) fn meet(&self, ray: &Ray, found: [f32; 2]) -> TrianglePoint {
        let [u, v] = self.solve(ray);
        let position = self.position(u, v);
        // A weight times twice the area is the distance from an edge times its length. NaN is not clear of edges.
        let least = u.min(v).min(1.0 - u - v) as f32;
        let clear = least * (2.0 * self.area as f32) > self.rounding(position) * NEAR_EDGE as f32;
        if clear {
            TrianglePoint {
                position,
                weights: [u as f32, v as f32],
                near_edge: None,
                is_beyond: false,
            }
        } else {
            self.meet_near_edge([u, v], found)
        }
    }

    /// The weights at which the line of `ray`, from its exact start, meets the triangle's plane.
    ///
    /// With s from the corner to the ray's start and r = s × d, the weights are e₂·r and -e₁·r over -(e₁ × e₂)·d (Möller
    /// and Trumbore 1997, equation 6, with the factors of the triple products turned).
    #[inline(always)]
    fn solve(&self, ray: &Ray) -> [f64; 2] {
        let direction = ray.direction.as_dvec3();
        let r = (ray.exact_origin() - self.corner).cross(direction);
        let inverse = -1.0 / self.cross.dot(direction);
        [self.edge_2.dot(r) * inverse, -self.edge_1.dot(r) * inverse]
    }

    /// Where `ray` meets the triangle, if it truly does, about at this distance: to a share of the triangle's size that
    /// keeps out those that the ray leaves or meets far behind.
    pub(super) fn meet_inside(&self, ray: &Ray, t: f32) -> Option<TrianglePoint> {
        const SHARE: f64 = 1.0 / 1024.0;
        let [u, v] = self.solve(ray);
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
        let along = (self.position(u, v) - ray.origin.as_dvec3()).dot(ray.direction.as_dvec3());
        let near = (along - f64::from(t)).abs() <= SHARE * f64::from(self.length());
        (inside && near).then(|| self.meet(ray, [u as f32, v as f32]))
    }

    /// As [`Triangle::meet`], for weights close to an edge or, by the rounding of an engine, beyond: moved off the edge,
    /// to the triangle's side, by a few roundings of f64, so that it is decided on which side of others that share
    /// the edge the point is. Where the solved weights are not those that were found by more than rounding explains, as
    /// for a ray in the triangle's plane, those are taken.
    #[cold]
    fn meet_near_edge(&self, solved: [f64; 2], found: [f32; 2]) -> TrianglePoint {
        // Of a distance from an edge, times the edge's length, over twice the area.
        let edges = [self.edge_2, self.edge_1, self.edge_2 - self.edge_1].map(DVec3::length);
        let weight = |distance: f64| edges.map(|length| distance * length / (2.0 * self.area));
        let found = found.map(f64::from);
        let near = [0, 1].iter().all(|&i| (solved[i] - found[i]).abs() < 1e-3);
        let [u, v] = if near { solved } else { found };
        let beyond = weight(8.0 * rounding_of(self.position(u, v)));
        let is_beyond = near && (u < -beyond[0] || v < -beyond[1] || 1.0 - u - v < -beyond[2]);
        let u = u.clamp(0.0, 1.0);
        let v = v.clamp(0.0, 1.0 - u);
        let size = self.position(u, v).abs().element_sum() + f64::from(self.length());
        let [u, v] = at_least([u, v], weight(OFF_EDGE * size));
        let position = self.position(u, v);
        let shifted = |distance: f64| {
            let [u, v] = at_least([u, v], weight(distance));
            self.position(u, v)
        };
        TrianglePoint {
            position,
            weights: [u as f32, v as f32],
            near_edge: Some(NearEdge::new(position, self.length().into(), shifted)),
            is_beyond,
        }
    }

    #[inline(always)]
    fn position(&self, u: f64, v: f64) -> DVec3 {
        self.corner + (self.edge_1 * u + self.edge_2 * v)
    }

    /// What rounding of a position to f32 moves it by, times a bound of the length of an edge. The second term is for
    /// points at the origin, which f64 places by roundings of the corners.
    #[inline(always)]
    fn rounding(&self, position: DVec3) -> f32 {
        const AT_ORIGIN: f32 = 1.0 / (1u32 << 16) as f32;
        let length = self.length();
        U * (position.as_vec3a().abs().element_sum() + AT_ORIGIN * length) * length
    }

    /// A bound of the length of an edge: the sum of two.
    #[inline(always)]
    fn length(&self) -> f32 {
        let [a, b, c] = self.corners;
        ((b - a).abs() + (c - a).abs()).element_sum()
    }

    /// The surface at one of its points, for the normals of its corners if they have any.
    // Inlined for the same reason as `Tracer::closest_vertex`.
    #[inline(always)]
    pub(super) fn surface(
        &self,
        point: TrianglePoint,
        vertex_normals: Option<[Vec3; 3]>,
    ) -> SurfacePoint {
        let TrianglePoint { position, weights: [u, v], near_edge, .. } = point;
        let (mut geometric_normal, mut shading_normal) = (self.normal, self.normal);
        if let Some([n0, n1, n2]) = vertex_normals {
            // A zero or non-finite interpolated normal leaves the geometric one.
            if let Some(n) = (n0 * (1.0 - u - v) + n1 * u + n2 * v).try_normalize() {
                shading_normal = n.into();
                // A file's vertex normals say which side is out, even where its winding does not.
                if shading_normal.dot(geometric_normal) < 0.0 {
                    geometric_normal = -geometric_normal;
                }
            }
        }
        let parameters = Vec2::new(u, v);
        SurfacePoint {
            position,
            parameters,
            geometric_normal,
            shading_normal,
            near_edge,
            time: 0.0,
        }
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
pub(super) fn clamp(b: Vec2) -> [f32; 2] {
    let inside = b.x >= 0.0 && b.y >= 0.0 && b.x + b.y <= 1.0;
    if inside {
        return [b.x, b.y];
    }
    let u = b.x.clamp(0.0, 1.0);
    [u, b.y.clamp(0.0, 1.0 - u)]
}

/// Texture coordinates at a point, for those of the corners: its weights where they have none.
pub(super) fn uv(weights: Vec2, corners: Option<[Vec2; 3]>) -> Vec2 {
    let [u, v] = clamp(weights);
    corners.map_or(Vec2::new(u, v), |[t0, t1, t2]| t0 * (1.0 - u - v) + t1 * u + t2 * v)
}

/// Derivatives of the position after both texture coordinates, for those of the corners: directions along the
/// triangle where they have none, or two the same.
pub(super) fn tangents(corners: [Vec3A; 3], uvs: Option<[Vec2; 3]>) -> [Vec3A; 2] {
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
        let frame = Frame::from_normal(Triangle::new(corners).normal.into());
        [frame.s, frame.t].map(Vec3A::from)
    })
}

/// The unit normal of a triangle and its area, from the product of its edges in f64, which is exact to a few roundings
/// of that. In f32 where the square of its length stays in range.
#[inline(always)]
fn normal_and_area(cross: DVec3) -> (Vec3A, f64) {
    let n = cross.as_vec3a();
    let length_squared = n.length_squared();
    if (1e-30..1e30).contains(&length_squared) {
        let length = length_squared.sqrt();
        return (n / length, 0.5 * f64::from(length));
    }
    let length = cross.length();
    ((cross / length).as_vec3a(), 0.5 * length)
}
