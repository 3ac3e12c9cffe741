//! The watertight test: Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (2013).

use super::{Corners, Corners8, RayTriangle, Solution, TriangleHit, same_sign, within};
use crate::intersect::lanes::{F32x8, Lanes};
use crate::ray::Ray;

/// The shear that maps the ray to the z axis of a frame whose axes are those of the world in another
/// order.
///
/// A corner's place in the sheared frame depends on nothing but the corner and the ray, so triangles
/// that share it agree about it, and an edge function is computed by both sides of an edge from the
/// same two places. Its f32 value has the right sign or is 0: rounding is monotonic, and products that
/// differ cannot change their order. Where it is 0 the paper computes it again in f64, where products
/// of two f32 are exact; here each candidate is. So no ray passes between two triangles.
#[derive(Clone, Copy, Debug)]
pub(in crate::intersect) struct Watertight {
    /// World axes that x, y and z of the frame are; z is the one along which the ray is longest.
    axes: [usize; 3],
    /// In the frame's order.
    origin: [f32; 3],
    /// dx/dz and dy/dz, at most 1 in magnitude.
    shear: [f32; 2],
    dz: f32,
}

/// A bound of the error with which a corner is placed, in units of its distance from the origin: six
/// roundings of 2⁻²⁴, times ten for a triangle that leans away from the ray.
const ERROR: f64 = 64.0 * 0.5 * f32::EPSILON as f64;

impl Watertight {
    /// Where a corner is in the frame: f32, and so the same for every triangle that has it.
    fn place(&self, corner: [f32; 3]) -> [f64; 2] {
        let [x, y, z] = self.axes;
        let z = corner[z] - self.origin[2];
        let x = (corner[x] - self.origin[0]) - self.shear[0] * z;
        let y = (corner[y] - self.origin[1]) - self.shear[1] * z;
        [f64::from(x), f64::from(y)]
    }

    /// The hit of the triangle whose corners are where they were placed, which the ray itself passes
    /// by less than the error of the places.
    #[cold]
    fn hit_as_placed(
        &self,
        ray: &Ray,
        corners: &Corners,
        solution: &Solution,
    ) -> Option<TriangleHit> {
        let [a, b, c] = corners.map(|corner| self.place(corner));
        let edge = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
        let (u, v, w) = (edge(c, b), edge(a, c), edge(b, a));
        let mixed = (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0);
        let sum = u + v + w;
        // A ray that starts in the plane, or lies in it, meets nothing of the triangle but its edges.
        if mixed || sum == 0.0 || solution.height == 0.0 {
            return None;
        }
        let depth = |corner: &[f32; 3]| f64::from(corner[self.axes[2]]) - f64::from(self.origin[2]);
        let [za, zb, zc] = corners.each_ref().map(depth);
        let z = (u * za + v * zb + w * zc) / sum;
        // One that has just left the plane does not meet it because far corners are placed in front of it.
        let error = ERROR * za.abs().max(zb.abs()).max(zc.abs());
        if solution.t < 0.0 && z.abs() <= error {
            return None;
        }
        let t = z / f64::from(self.dz);
        within(ray, [t, v / sum, w / sum])
    }
}

/// [`Watertight::place`] of eight corners.
#[inline(always)]
fn place<L: Lanes>(
    lanes: L,
    [x, y, z]: [&F32x8; 3],
    [ox, oy, oz]: [L::Vector; 3],
    [sx, sy]: [L::Vector; 2],
) -> [L::Vector; 2] {
    let z = lanes.sub(lanes.load(z), oz);
    let x = lanes.sub(lanes.load(x), ox);
    let y = lanes.sub(lanes.load(y), oy);
    [lanes.sub(x, lanes.mul(sx, z)), lanes.sub(y, lanes.mul(sy, z))]
}

#[inline(always)]
fn edge<L: Lanes>(lanes: L, p: [L::Vector; 2], q: [L::Vector; 2]) -> L::Vector {
    lanes.sub(lanes.mul(p[0], q[1]), lanes.mul(p[1], q[0]))
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
        Self { axes, origin: axes.map(|axis| origin[axis]), shear, dz: d[z] }
    }

    #[inline(always)]
    fn candidates<L: Lanes>(&self, lanes: L, triangles: &Corners8) -> u32 {
        let [xs, ys, zs] = self.axes.map(|axis| &triangles[axis]);
        let o = self.origin.map(|o| lanes.splat(o));
        let s = self.shear.map(|s| lanes.splat(s));
        let place = |corner| place(lanes, [&xs[corner], &ys[corner], &zs[corner]], o, s);
        let (a, b, c) = (place(0), place(1), place(2));
        same_sign(lanes, [edge(lanes, c, b), edge(lanes, a, c), edge(lanes, b, a)])
    }

    #[inline(always)]
    fn hit(&self, ray: &Ray, corners: &Corners) -> Option<TriangleHit> {
        let solution = Solution::new(ray, corners);
        if solution.is_inside() {
            return within(ray, [solution.t, solution.u, solution.v]);
        }
        self.hit_as_placed(ray, corners, &solution)
    }
}
