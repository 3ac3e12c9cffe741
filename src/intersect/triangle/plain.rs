//! The test of Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997).

use glam::Vec3;

use super::{Corners, Corners8, RayTriangle, Solution, TriangleHit, same_sign, within};
use crate::intersect::lanes::Lanes;
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

type Vectors<L> = [<L as Lanes>::Vector; 3];

#[inline(always)]
fn sub<L: Lanes>(lanes: L, a: Vectors<L>, b: Vectors<L>) -> Vectors<L> {
    [lanes.sub(a[0], b[0]), lanes.sub(a[1], b[1]), lanes.sub(a[2], b[2])]
}

#[inline(always)]
fn dot<L: Lanes>(lanes: L, a: Vectors<L>, b: Vectors<L>) -> L::Vector {
    let [x, y, z] = [lanes.mul(a[0], b[0]), lanes.mul(a[1], b[1]), lanes.mul(a[2], b[2])];
    lanes.add(lanes.add(x, y), z)
}

#[inline(always)]
fn cross<L: Lanes>(lanes: L, a: Vectors<L>, b: Vectors<L>) -> Vectors<L> {
    [minor(lanes, a, b, 1, 2), minor(lanes, a, b, 2, 0), minor(lanes, a, b, 0, 1)]
}

/// `a[i] b[j] - a[j] b[i]`.
#[inline(always)]
fn minor<L: Lanes>(lanes: L, a: Vectors<L>, b: Vectors<L>, i: usize, j: usize) -> L::Vector {
    lanes.sub(lanes.mul(a[i], b[j]), lanes.mul(a[j], b[i]))
}

impl RayTriangle for Plain {
    #[inline(always)]
    fn new(ray: &Ray) -> Self {
        Self { origin: ray.origin.into(), direction: ray.direction.into() }
    }

    #[inline(always)]
    fn candidates<L: Lanes>(&self, lanes: L, triangles: &Corners8) -> u32 {
        let corner = |i: usize| triangles.each_ref().map(|axis| lanes.load(&axis[i]));
        let direction = self.direction.to_array().map(|d| lanes.splat(d));
        let origin = self.origin.to_array().map(|o| lanes.splat(o));
        let (a, b, c) = (corner(0), corner(1), corner(2));
        let (edge_1, edge_2) = (sub(lanes, b, a), sub(lanes, c, a));
        let p = cross(lanes, direction, edge_2);
        let determinant = dot(lanes, edge_1, p);
        let to_origin = sub(lanes, origin, a);
        let u = dot(lanes, to_origin, p);
        let v = dot(lanes, direction, cross(lanes, to_origin, edge_1));
        let w = lanes.sub(determinant, lanes.add(u, v));
        same_sign(lanes, [u, v, w], lanes.splat(0.0))
    }

    #[inline(always)]
    fn hit(&self, ray: &Ray, corners: &Corners) -> Option<TriangleHit> {
        let Solution { t, u, v, .. } = Solution::new(ray, corners);
        let near = u >= -SLACK && v >= -SLACK && u + v <= 1.0 + SLACK;
        if near { within(ray, [t, u, v]) } else { None }
    }
}
