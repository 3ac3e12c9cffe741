//! The primitives of some lanes, as shapes put them there.

use glam::{Vec3 as GlamVec3, Vec3A};

use super::sphere::Spheres;
use super::triangle::{Triangle, TrianglePoint};
use super::{Shape, SurfacePoint};
use crate::math::real::{Mask, Real};
use crate::math::vector::Vec3;

/// A triangle or a sphere in each lane, or nothing.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct PrimitiveLanes {
    /// x, y and z of a triangle's first corner, then of the others; or of a sphere's centre, its radius and side.
    numbers: [[f32; 8]; 9],
    /// x, y and z of the normals of a triangle's corners, 0 where they have none.
    normals: [[f32; 8]; 9],
    has_normals: bool,
    /// In which lanes there is a triangle, by bits.
    triangles: u32,
    /// The same of spheres.
    spheres: u32,
}

/// Where a shape puts a primitive.
#[derive(Debug)]
pub struct PrimitiveLane<'a> {
    lanes: &'a mut PrimitiveLanes,
    /// Below 8.
    lane: usize,
}

impl PrimitiveLane<'_> {
    /// The corners of a triangle, world space, counter-clockwise for who sees the front.
    #[inline(always)]
    pub fn put_triangle(&mut self, corners: [Vec3A; 3]) {
        self.lanes.triangles |= 1 << self.lane;
        for (k, corner) in corners.into_iter().enumerate() {
            for (axis, number) in corner.to_array().into_iter().enumerate() {
                self.lanes.numbers[3 * k + axis][self.lane & 7] = number;
            }
        }
    }

    /// Normals of the corners, of any length.
    #[inline(always)]
    pub fn put_normals(&mut self, normals: [GlamVec3; 3]) {
        self.lanes.has_normals = true;
        for (k, normal) in normals.into_iter().enumerate() {
            for (axis, number) in normal.to_array().into_iter().enumerate() {
                self.lanes.normals[3 * k + axis][self.lane & 7] = number;
            }
        }
    }

    /// A sphere: centre and radius, and as side −1 if its normals point inwards, else 1.
    #[inline(always)]
    pub fn put_sphere(&mut self, center: Vec3A, radius: f32, side: f32) {
        self.lanes.spheres |= 1 << self.lane;
        let numbers = [center.x, center.y, center.z, radius, side];
        for (row, number) in self.lanes.numbers.iter_mut().zip(numbers) {
            row[self.lane & 7] = number;
        }
    }
}

impl PrimitiveLanes {
    pub(super) const NONE: Self = Self {
        numbers: [[0.0; 8]; 9],
        normals: [[0.0; 8]; 9],
        has_normals: false,
        triangles: 0,
        spheres: 0,
    };

    /// Those of what emits, which is at rest.
    #[inline(always)]
    pub(super) fn at_rest<R: Real>(
        shapes: &R::Each<&dyn Shape>,
        primitives: &R::Each<u32>,
    ) -> Self {
        let mut lanes = Self::NONE;
        for (i, (shape, &primitive)) in shapes.as_ref().iter().zip(primitives.as_ref()).enumerate()
        {
            shape.put(primitive, 0.0, &mut lanes.lane(i));
        }
        lanes
    }

    #[inline(always)]
    pub(super) fn lane(&mut self, lane: usize) -> PrimitiveLane<'_> {
        PrimitiveLane { lanes: self, lane }
    }

    /// Where there are triangles.
    #[inline(always)]
    pub(super) fn are_triangles<R: Real>(&self, token: R::Token) -> R::Mask {
        R::Mask::from_bits(token, self.triangles)
    }

    /// Where there are spheres.
    #[inline(always)]
    pub(super) fn are_spheres<R: Real>(&self, token: R::Token) -> R::Mask {
        R::Mask::from_bits(token, self.spheres)
    }

    /// The triangles; elsewhere what comes of it means nothing.
    #[inline(always)]
    pub(super) fn triangles<R: Real>(&self, token: R::Token) -> Triangle<R> {
        Triangle::new(vectors(token, &self.numbers))
    }

    /// The spheres; elsewhere what comes of it means nothing.
    #[inline(always)]
    pub(super) fn spheres<R: Real>(&self, token: R::Token) -> Spheres<R> {
        let [center, Vec3 { x: radius, y: side, .. }, _] = vectors::<R>(token, &self.numbers);
        Spheres { center: center.widen(), radius: radius.widen(), side }
    }

    /// Normals of the corners; `None` if no lane has any.
    #[inline(always)]
    pub(super) fn normals<R: Real>(&self, token: R::Token) -> Option<[Vec3<R>; 3]> {
        self.has_normals.then(|| vectors(token, &self.normals))
    }

    /// The corners of the first lane's triangle.
    pub(super) fn corners(&self) -> [Vec3A; 3] {
        [0, 3, 6].map(|row| Vec3A::from_array([0, 1, 2].map(|axis| self.numbers[row + axis][0])))
    }

    /// The surface at a point of the first lane's triangle, away from edges.
    pub(super) fn surface(&self, triangle: &Triangle, point: TrianglePoint) -> SurfacePoint {
        let normals = self.normals::<f32>(());
        let (geometric_normal, shading_normal) = triangle.normals(point.weights, normals);
        SurfacePoint {
            position: point.position.into(),
            parameters: point.weights.into(),
            geometric_normal: geometric_normal.into(),
            shading_normal: shading_normal.into(),
            near_edge: None,
            time: 0.0,
        }
    }
}

/// Three vectors in each lane.
#[inline(always)]
fn vectors<R: Real>(token: R::Token, rows: &[[f32; 8]; 9]) -> [Vec3<R>; 3] {
    let number = |row: usize| R::load(token, &rows[row][..R::LANES]);
    let vector = |k: usize| Vec3::new(number(k), number(k + 1), number(k + 2));
    [vector(0), vector(3), vector(6)]
}
