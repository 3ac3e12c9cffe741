//! A line against one triangle: where it crosses, and where it is near.

use glam::{DVec3, Vec3A};

use super::exact::{facing, side, volume};
use super::span::{Line, Span};
use super::{bound, distance_bound};

/// A triangle as seen from a ray: its corners, and the same relative to the origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    corners: [Vec3A; 3],
    seen: [DVec3; 3],
    normal: DVec3,
}

impl Triangle {
    pub(super) fn new(line: &Line, corners: [Vec3A; 3]) -> Self {
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        let seen = [a, b, c].map(|p| p - line.origin);
        // Differences and products of f32 are nearly exact in f64, so slivers have a normal too.
        Self { corners, seen, normal: (b - a).cross(c - a) }
    }

    /// The three edges, each by its corners and the same relative to the ray's origin.
    pub(super) fn edges(&self) -> [([Vec3A; 2], [DVec3; 2]); 3] {
        let edge =
            |i: usize, j: usize| ([self.corners[i], self.corners[j]], [self.seen[i], self.seen[j]]);
        [edge(0, 1), edge(1, 2), edge(2, 0)]
    }

    /// Distance of the farthest corner from the origin, in scene units.
    fn farthest(&self) -> f64 {
        self.seen.map(DVec3::length).into_iter().fold(0.0, f64::max)
    }

    /// The same in units of the line's direction.
    pub(super) fn reach(&self, line: &Line) -> f64 {
        self.farthest() / line.direction.length()
    }

    /// The largest distance that rounding may have moved it by.
    pub(super) fn bound(&self) -> f64 {
        bound(self.farthest())
    }

    /// The scalar product of the line's direction with the normal, with its exact sign: 0 if the triangle
    /// is seen from the side.
    pub(super) fn facing(&self, line: &Line) -> f64 {
        let [a, b, c] = self.corners;
        facing(line.ray.direction, a, b, c)
    }

    /// Distance along the line of the point where it crosses the triangle, borders included. A line in
    /// its plane does not cross it.
    pub(super) fn crossing(&self, line: &Line) -> Option<f64> {
        let [a, b, c] = self.corners;
        let (o, d) = (line.ray.origin, line.ray.direction);
        let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| side(o, d, p, q));
        let inside = sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0);
        let facing = if inside { self.facing(line) } else { 0.0 };
        (facing != 0.0).then(|| volume(o, a, b, c) / facing)
    }

    /// Distance of the line from the nearest edge.
    pub(super) fn clearance(&self, line: &Line) -> f64 {
        let distances = self.edges().map(|(_, [p, q])| line.distance_to_segment(p, q));
        distances.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Whether the line crosses the triangle or comes within its bound.
    pub(super) fn is_near(&self, crossing: Option<f64>, clearance: f64) -> bool {
        crossing.is_some() || clearance <= self.bound()
    }

    /// Length of the longest edge.
    fn longest(&self) -> f64 {
        self.edges().map(|(_, [a, b])| a.distance(b)).into_iter().fold(0.0, f64::max)
    }

    /// How much worse it is shaped than a right-angled isosceles triangle, which has 2: the square of the
    /// longest edge over twice the area.
    fn shape(&self) -> f64 {
        self.longest().powi(2) / self.normal.length()
    }

    /// The distances that a hit with it may be reported at: where the line is within the bound of its plane, no
    /// farther than its corners reach.
    pub(super) fn span(&self, line: &Line) -> Span {
        let d = line.direction;
        let (dd, slack) = (d.length_squared(), distance_bound(self.reach(line), 0.0, 0.0));
        let along = self.seen.map(|p| p.dot(d) / dd);
        let near = along.into_iter().fold(f64::INFINITY, f64::min) - slack;
        let far = along.into_iter().fold(f64::NEG_INFINITY, f64::max) + slack;
        let plane = self.plane_span(line);
        Span { near: near.max(plane.near), far: far.min(plane.far) }
    }

    /// Where the line is within the bound of the triangle's plane, everywhere if it is seen from the side: see
    /// the module on distances.
    fn plane_span(&self, line: &Line) -> Span {
        let facing = line.direction.dot(self.normal);
        let through = self.seen[0].dot(self.normal) / facing;
        let shift = distance_bound(self.farthest(), self.longest(), self.shape());
        let reach = (shift * self.normal.length() / facing).abs();
        if reach.is_finite() {
            Span { near: through - reach, far: through + reach }
        } else {
            Span { near: f64::NEG_INFINITY, far: f64::INFINITY }
        }
    }

    /// Whether the point with the weights `u` and `v` of the second and third corner, clamped as meshes do,
    /// is where the line passes: within the bound of it times the triangle's shape over the cosine, since the two
    /// weights err independently and so in any direction along the triangle.
    pub(super) fn is_passed_at(&self, line: &Line, u: f32, v: f32) -> bool {
        if u.is_nan() || v.is_nan() {
            return false;
        }
        let [a, b, c] = self.seen;
        let u = f64::from(u).clamp(0.0, 1.0);
        let v = f64::from(v).clamp(0.0, 1.0 - u);
        let point = a + (b - a) * u + (c - a) * v;
        let facing = line.direction.dot(self.normal).abs();
        let cosine = facing / (line.direction.length() * self.normal.length());
        // Without limit if seen from the side.
        line.distance_to_segment(point, point) * cosine <= self.bound() * self.shape()
    }
}
