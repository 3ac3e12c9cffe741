//! Ray–triangle tests of the Rust engine.
//!
//! A test first rules out triangles of a leaf, eight at a time and in f32, by the signs of three edge
//! functions, and then looks at those that remain one by one in f64. So t, u and v are right to a few
//! roundings however small, large, thin or distant a triangle is.

use std::cmp::Ordering;

use glam::{DVec3, Vec3};

use crate::math::real::{Float, Real, Simd, f32x8, mask32x8};
use crate::ray::Ray;

mod plain;
#[cfg(test)]
pub(super) mod tests;
mod watertight;

pub(super) use plain::Plain;
pub(super) use watertight::Watertight;

/// Corners of eight triangles: by axis, then by corner.
pub(super) type Corners8 = [[[f32; 8]; 3]; 3];

/// Corners of one triangle.
pub(super) type Corners = [[f32; 3]; 3];

/// The same corners, exactly.
#[inline(always)]
pub(super) fn in_f64(corners: &Corners) -> [DVec3; 3] {
    corners.map(|corner| Vec3::from(corner).as_dvec3())
}

/// Distance and the barycentric weights of the second and third corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TriangleHit {
    pub(super) t: f32,
    pub(super) u: f32,
    pub(super) v: f32,
}

/// A test, with what it needs to know of a ray.
pub(super) trait RayTriangle: Copy {
    fn new(ray: &Ray) -> Self;

    /// Whether the line of the ray may meet each triangle.
    fn candidates<S: Simd>(&self, simd: S, triangles: &Corners8) -> mask32x8<S>;

    /// The hit of a candidate, on either side and within the segment of the ray.
    fn hit(&self, ray: &Ray, corners: &Corners) -> Option<TriangleHit>;
}

/// Whether the three numbers have no two different signs, those of no more than `error` having none. The
/// sign of NaN is not known: a number that a NaN hides from `min` or `max` rules nothing out.
#[inline(always)]
fn same_sign<S: Simd>([a, b, c]: [f32x8<S>; 3], error: f32x8<S>) -> mask32x8<S> {
    let least = a.min(b).min(c);
    let most = a.max(b).max(c);
    !((least + error).lt(0.0) & error.lt(most))
}

/// Möller and Trumbore's solution in f64.
struct Solution {
    t: f64,
    /// Weights of the second and third corner.
    u: f64,
    v: f64,
}

impl Solution {
    #[inline(always)]
    fn new(ray: &Ray, corners: &Corners) -> Self {
        let [a, b, c] = in_f64(corners);
        let (origin, direction): (DVec3, DVec3) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let (edge_1, edge_2) = (b - a, c - a);
        let p = direction.cross(edge_2);
        let inverse = 1.0 / edge_1.dot(p);
        let to_origin = origin - a;
        let q = to_origin.cross(edge_1);
        Self {
            t: edge_2.dot(q) * inverse,
            u: to_origin.dot(p) * inverse,
            v: direction.dot(q) * inverse,
        }
    }
}

/// Which of two triangles that a ray meets at the same f32 is the nearer one: `Equal` if it takes both to be in one plane.
/// At an edge at which a surface turns away, its front and its back are that close.
#[cold]
pub(super) fn nearer(ray: &Ray, a: &Corners, b: &Corners) -> Ordering {
    // Far more than f64 errs by, and far less than the spacing of f32.
    const SAME: f64 = 1.0 / (1u64 << 40) as f64;
    let [a, b] = [a, b].map(|corners| Solution::new(ray, corners).t);
    if (a - b).abs() <= SAME * a.abs().max(b.abs()) { Ordering::Equal } else { a.total_cmp(&b) }
}

/// The hit if it is within the segment. Written so that NaN fails.
#[inline(always)]
fn within(ray: &Ray, [t, u, v]: [f64; 3]) -> Option<TriangleHit> {
    let [t, u, v] = [t as f32, u as f32, v as f32];
    let within = t >= ray.t_min && t <= ray.t_max && t < f32::INFINITY;
    within.then_some(TriangleHit { t, u, v })
}
