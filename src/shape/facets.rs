//! The triangles of some lanes, as shapes put them there.

use glam::{Vec3 as GlamVec3, Vec3A};

use super::SurfacePoint;
use super::triangle::{Triangle, TrianglePoint};
use crate::math::real::Real;
use crate::math::vector::Vec3;

/// A triangle in each lane.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Facets {
    /// x, y and z of the first corner, then of the others.
    corners: [[f32; 8]; 9],
    /// The same of their normals, 0 where they have none.
    normals: [[f32; 8]; 9],
    has_normals: bool,
}

/// Where a shape puts a triangle.
#[derive(Debug)]
pub struct FacetLane<'a> {
    facets: &'a mut Facets,
    /// Below 8.
    lane: usize,
}

impl FacetLane<'_> {
    /// The corners, world space, counter-clockwise for who sees the front.
    #[inline(always)]
    pub fn put(&mut self, corners: [Vec3A; 3]) {
        for (k, corner) in corners.into_iter().enumerate() {
            for (axis, number) in corner.to_array().into_iter().enumerate() {
                self.facets.corners[3 * k + axis][self.lane & 7] = number;
            }
        }
    }

    /// Normals of the corners, of any length.
    #[inline(always)]
    pub fn put_normals(&mut self, normals: [GlamVec3; 3]) {
        self.facets.has_normals = true;
        for (k, normal) in normals.into_iter().enumerate() {
            for (axis, number) in normal.to_array().into_iter().enumerate() {
                self.facets.normals[3 * k + axis][self.lane & 7] = number;
            }
        }
    }
}

impl Facets {
    pub(super) const NONE: Self =
        Self { corners: [[0.0; 8]; 9], normals: [[0.0; 8]; 9], has_normals: false };

    #[inline(always)]
    pub(super) fn lane(&mut self, lane: usize) -> FacetLane<'_> {
        FacetLane { facets: self, lane }
    }

    #[inline(always)]
    pub(super) fn corners<R: Real>(&self, token: R::Token) -> [Vec3<R>; 3] {
        vectors(token, &self.corners)
    }

    /// `None` if no lane has any.
    #[inline(always)]
    pub(super) fn normals<R: Real>(&self, token: R::Token) -> Option<[Vec3<R>; 3]> {
        self.has_normals.then(|| vectors(token, &self.normals))
    }

    /// That of the first lane.
    pub(super) fn triangle(&self) -> Triangle {
        Triangle::new(self.corners::<f32>(()))
    }

    /// The surface at a point of it, away from edges.
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
