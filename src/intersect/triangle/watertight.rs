//! The watertight test: Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (2013).

use super::{Corners, Corners8, RayTriangle, Solution, TriangleHit, same_sign, within};
use crate::math::UNIT_ROUNDOFF;
use crate::math::real::{Lanes, Real, Simd, f32x8, mask32x8};
use crate::ray::Ray;

/// The shear that maps the ray to the z axis of a frame whose axes are those of the world in another
/// order.
///
/// A corner's place in the sheared frame depends on nothing but the corner and the ray, so triangles
/// that share it agree about it, and an edge function is computed by both sides of an edge from the
/// same two places, with one sign for the one and the other for the other. The paper places corners in
/// f32 and decides about edges at which the f32 edge function is 0 in f64. That no ray slips between two
/// triangles then holds for the places, not for the corners: a ray that starts within their rounding of
/// a reflex edge may be placed on that side of it where the plane lies behind. Here f32 only rules out
/// triangles that the ray passes by more than the rounding of all that led to the edge functions, and f64
/// decides about the others.
#[derive(Clone, Copy, Debug)]
pub(in crate::intersect) struct Watertight {
    /// World axes that x, y and z of the frame are; z is the one along which the ray is longest.
    axes: [usize; 3],
    /// In the frame's order.
    origin: [f32; 3],
    /// dx/dz and dy/dz, at most 1 in magnitude.
    shear: [f32; 2],
}

/// Let u = 2⁻²⁴, r be the largest |x| or |y| of the three places in the sheared frame, and h the largest
/// |z|. A place is x = (X - oX) - s z: with the roundings of both differences, of s and of its product
/// with z, and |X - oX| <= r + h, it errs by no more than u (2r + 4h). An edge function, a difference of
/// two products, then errs by 4r times that, and by 4u r² for its own roundings: 20u r (r + h) at most.
const ERROR: f32 = 24.0 * UNIT_ROUNDOFF;

/// Where corners are in the frame, in f64: the same for every triangle that has the corner.
struct Places {
    /// Edge functions: in proportion to the corners' weights.
    weights: [f64; 3],
    depths: [f64; 3],
    /// The ray's component along the depth.
    dz: f64,
    /// What rounding may make of the edge functions of a triangle that is 2⁵⁰ times smaller than its distance.
    noise: f64,
}

impl Places {
    #[inline(always)]
    fn new(axes: [usize; 3], ray: &Ray, corners: &Corners) -> Self {
        let direction = ray.direction.as_dvec3().to_array();
        let [dx, dy, dz] = axes.map(|axis| direction[axis]);
        let (sx, sy) = (dx / dz, dy / dz);
        let origin = ray.origin.as_dvec3().to_array();
        let place = |corner: [f32; 3]| {
            let [x, y, z] = axes.map(|axis| f64::from(corner[axis]) - origin[axis]);
            [x - sx * z, y - sy * z, z]
        };
        let [a, b, c] = corners.map(place);
        let edge = |p: [f64; 3], q: [f64; 3]| p[0] * q[1] - p[1] * q[0];
        let depths = [a[2], b[2], c[2]];
        let most = |v: [f64; 3]| v[0].abs().max(v[1].abs()).max(v[2].abs());
        let side = most([a[0], b[0], c[0]]).max(most([a[1], b[1], c[1]]));
        let noise = 4.0 * f64::EPSILON * side * (side + (sx.abs() + sy.abs()) * most(depths));
        Self { weights: [edge(c, b), edge(a, c), edge(b, a)], depths, dz, noise }
    }

    /// `[t, u, v]` if the ray's line meets the triangle, and whether they are exact to a few roundings of f32.
    #[inline(always)]
    fn hit(&self) -> Option<([f64; 3], bool)> {
        let [u, v, w] = self.weights;
        let mixed = (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0);
        let sum = u + v + w;
        // A triangle that is seen edge-on is left to those that share its edges.
        if mixed || sum.abs() <= self.noise {
            return None;
        }
        let [za, zb, zc] = self.depths;
        let depth = (u * za + v * zb + w * zc) / sum;
        // Where the weights cancel, as those of slivers do, and close to the plane, where the depths do.
        let farthest = za.abs().max(zb.abs()).max(zc.abs());
        let exact = self.noise < NOISE * sum.abs() && depth.abs() > NEAREST * farthest;
        Some(([depth / self.dz, v / sum, w / sum], exact))
    }
}

/// A share of noise in the weights that is less than a hundredth of the rounding to f32, and the least depth, in
/// units of the corners', at which it is so little of that, too.
const NOISE: f64 = 5e-10;
const NEAREST: f64 = 1e-6;

/// The first two coordinates of eight corners in the frame, and their depths.
#[inline(always)]
fn place<S: Simd>(simd: S, corners: [&[f32; 8]; 3], test: &Watertight) -> [f32x8<S>; 3] {
    let ([x, y, z], [ox, oy, oz], [sx, sy]) = (corners, test.origin, test.shear);
    let z = f32x8::load(simd, z) - oz;
    let x = f32x8::load(simd, x) - ox;
    let y = f32x8::load(simd, y) - oy;
    [x - z * sx, y - z * sy, z]
}

#[inline(always)]
fn edge<R: Real>(p: [R; 3], q: [R; 3]) -> R {
    p[0] * q[1] - p[1] * q[0]
}

/// The largest magnitude.
#[inline(always)]
fn largest<R: Real>(a: R, b: R, c: R) -> R {
    a.abs().max(b.abs()).max(c.abs())
}

impl RayTriangle for Watertight {
    #[inline(always)]
    fn new(ray: &Ray) -> Self {
        let d = ray.direction.to_array();
        let size = d.map(f32::abs);
        let z = if size[0] > size[1] && size[0] > size[2] {
            0
        } else if size[1] > size[2] {
            1
        } else {
            2
        };
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let shear = [d[axes[0]] / d[z], d[axes[1]] / d[z]];
        let origin = ray.origin.to_array();
        Self { axes, origin: axes.map(|axis| origin[axis]), shear }
    }

    #[inline(always)]
    fn candidates<S: Simd>(&self, simd: S, triangles: &Corners8) -> mask32x8<S> {
        let [xs, ys, zs] = self.axes.map(|axis| &triangles[axis]);
        let a = place(simd, [&xs[0], &ys[0], &zs[0]], self);
        let b = place(simd, [&xs[1], &ys[1], &zs[1]], self);
        let c = place(simd, [&xs[2], &ys[2], &zs[2]], self);
        let side = largest(a[0], b[0], c[0]).max(largest(a[1], b[1], c[1]));
        let depth = largest(a[2], b[2], c[2]);
        // The least is for products that are denormal, and so rounded by more than u.
        let error = side * (side + depth) * ERROR + f32::MIN_POSITIVE;
        same_sign([edge(c, b), edge(a, c), edge(b, a)], error)
    }

    #[inline(always)]
    fn hit(&self, ray: &Ray, corners: &Corners) -> Option<TriangleHit> {
        let (hit, exact) = Places::new(self.axes, ray, corners).hit()?;
        if exact {
            return within(ray, hit);
        }
        // From the edges, which are shorter than the way to the corners. A ray that starts in the plane has
        // t = 0 there.
        let Solution { t, u, v } = Solution::new(ray, corners);
        if u.is_nan() || v.is_nan() {
            return None;
        }
        let u = u.clamp(0.0, 1.0);
        within(ray, [t, u, v.clamp(0.0, 1.0 - u)])
    }
}
