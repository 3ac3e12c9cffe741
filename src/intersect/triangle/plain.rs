//! The test of Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997).

use super::{Corners, Corners8, RayTriangle, Solution, TriangleHit, same_sign, within};
use crate::math::real::{Lanes, Simd, f32x8, mask32x8};
use crate::math::vector::Vec3;
use crate::ray::Ray;

/// How far outside, in barycentric weights, a hit may truly be. Where f32 is farther off it has lost all
/// its digits, as with a triangle that is seen edge-on from afar, and t would be that of another place.
const SLACK: f64 = 1.0 / 16.0;

/// Whether a ray hits is decided in f32, by the signs of the weights times the determinant. No bound
/// other than 0 is involved: it would be a length, and lose small triangles. Two triangles compute
/// the weight of their common edge from different numbers, so a ray that meets it may miss both.
#[derive(Clone, Copy, Debug)]
pub(in crate::intersect) struct Plain {
    origin: Vec3,
    direction: Vec3,
}

/// One corner of eight triangles.
#[inline(always)]
fn corner<S: Simd>(simd: S, triangles: &Corners8, i: usize) -> Vec3<f32x8<S>> {
    let [x, y, z] = triangles;
    Vec3::new(f32x8::load(simd, &x[i]), f32x8::load(simd, &y[i]), f32x8::load(simd, &z[i]))
}

impl RayTriangle for Plain {
    #[inline(always)]
    fn new(ray: &Ray) -> Self {
        Self { origin: ray.origin.into(), direction: ray.direction.into() }
    }

    #[inline(always)]
    fn candidates<S: Simd>(&self, simd: S, triangles: &Corners8) -> mask32x8<S> {
        let [a, b, c] =
            [corner(simd, triangles, 0), corner(simd, triangles, 1), corner(simd, triangles, 2)];
        let (origin, direction) =
            (Vec3::splat(simd, self.origin), Vec3::splat(simd, self.direction));
        let (edge_1, edge_2) = (b - a, c - a);
        let p = direction.cross(edge_2);
        let determinant = edge_1.dot(p);
        let to_origin = origin - a;
        let u = to_origin.dot(p);
        let v = direction.dot(to_origin.cross(edge_1));
        let w = determinant - (u + v);
        same_sign([u, v, w], f32x8::splat(simd, 0.0))
    }

    #[inline(always)]
    fn hit(&self, ray: &Ray, corners: &Corners) -> Option<TriangleHit> {
        let Solution { t, u, v, .. } = Solution::new(ray, corners);
        let near = u >= -SLACK && v >= -SLACK && u + v <= 1.0 + SLACK;
        if near { within(ray, [t, u, v]) } else { None }
    }
}
