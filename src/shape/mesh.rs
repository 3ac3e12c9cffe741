//! Triangle meshes.

use std::fmt::{self, Display, Formatter};
use std::sync::OnceLock;

use glam::{DVec3, Vec2, Vec3, Vec3A};
use rayon::prelude::*;

use super::neighbours::Neighbours;
use super::primitive_lanes::PrimitiveLane;
use super::triangle::{self, Triangle};
use super::{Arrivals, Geometry, Interaction, Shape, ShapeSample, ShapeSamples, SurfacePoint};
use crate::math::{Aabb, Cone, vector as real};
use crate::ray::{Hit, Ray};

/// Indexed triangles in world space. Counter-clockwise vertices face the viewer.
#[derive(Clone, Debug, Default)]
pub struct TriangleMesh {
    positions: Vec<Vec3A>,
    triangles: Vec<[u32; 3]>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    /// Made when it is first asked for.
    neighbours: OnceLock<Neighbours>,
}

/// Why buffers do not form a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshError {
    /// A triangle refers to a vertex that is not there.
    #[error("triangle {triangle} refers to vertex {vertex}, but there are {vertices} vertices")]
    IndexOutOfRange {
        /// Which triangle, from 0.
        triangle: usize,
        /// The index that it holds.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A vertex attribute has neither no entry nor one for each vertex.
    #[error("{count} {attribute} for {vertices} vertices (expected none, or one for each)")]
    AttributeCount {
        /// `"normals"` or `"texture coordinates"`.
        attribute: &'static str,
        /// How many there are.
        count: usize,
        /// How many vertices there are.
        vertices: usize,
    },
    /// More vertices or triangles than a 32-bit index can name.
    #[error("{count} {what}: more than a 32-bit index can name")]
    TooLarge {
        /// `"vertices"` or `"triangles"`.
        what: &'static str,
        /// How many there are.
        count: usize,
    },
}

/// How many triangles were left out of a mesh, because no ray can be said to hit them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// Triangles with a vertex that is not finite.
    pub not_finite: usize,
    /// Triangles with a vertex of [`Ray::LARGEST_COORDINATE`] or more, which engines cannot take.
    pub too_large: usize,
    /// Triangles without area.
    pub degenerate: usize,
}

impl Dropped {
    /// Whether the mesh is whole.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// As a warning: `left out 1 triangle without area`.
impl Display for Dropped {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let too_large = format!("with coordinates of {:e} or more", Ray::LARGEST_COORDINATE);
        let parts: Vec<_> = [
            (self.degenerate, "without area"),
            (self.not_finite, "with vertices that are not finite"),
            (self.too_large, &too_large),
        ]
        .into_iter()
        .filter(|&(count, _)| count > 0)
        .map(|(count, what)| {
            format!("{count} triangle{} {what}", if count == 1 { "" } else { "s" })
        })
        .collect();
        write!(f, "left out {}", parts.join(" and "))
    }
}

impl TriangleMesh {
    /// A mesh from buffers in world space. `normals` (need not have unit length) and `uvs` are empty or
    /// have one entry for each vertex. Triangles without area and triangles with a vertex that is not
    /// finite are dropped and counted.
    ///
    /// # Errors
    /// An index out of range, or an attribute with the wrong number of entries.
    pub fn new(
        positions: Vec<Vec3A>,
        mut triangles: Vec<[u32; 3]>,
        normals: Vec<Vec3>,
        uvs: Vec<Vec2>,
    ) -> Result<(Self, Dropped), MeshError> {
        let vertices = positions.len();
        for (what, count) in [("vertices", vertices), ("triangles", triangles.len())] {
            // The largest index is kept free: Embree uses it for "no primitive".
            if count >= u32::MAX as usize {
                return Err(MeshError::TooLarge { what, count });
            }
        }
        for (attribute, count) in [("normals", normals.len()), ("texture coordinates", uvs.len())] {
            if count != 0 && count != vertices {
                return Err(MeshError::AttributeCount { attribute, count, vertices });
            }
        }
        let (dropped, defective) = find_defective(&positions, &triangles)?;
        if !defective.is_empty() {
            let mut defective = defective.into_iter().peekable();
            let mut triangle = 0;
            triangles.retain(|_| {
                let keep = defective.next_if_eq(&triangle).is_none();
                triangle += 1;
                keep
            });
            triangles.shrink_to_fit();
        }
        let neighbours = OnceLock::new();
        Ok((Self { positions, triangles, normals, uvs, neighbours }, dropped))
    }

    /// Vertices in world space.
    #[must_use]
    pub fn positions(&self) -> &[Vec3A] {
        &self.positions
    }

    /// Three vertex indices per triangle.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Vertex normals, or nothing.
    #[must_use]
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Texture coordinates per vertex, or nothing.
    #[must_use]
    pub fn uvs(&self) -> &[Vec2] {
        &self.uvs
    }

    #[inline(always)]
    fn corners(&self, primitive: usize) -> [Vec3A; 3] {
        self.triangles[primitive].map(|i| self.positions[i as usize])
    }

    fn triangle(&self, primitive: usize) -> Triangle {
        Triangle::new(self.corners(primitive).map(real::Vec3::from))
    }

    /// The texture coordinates of a triangle's corners.
    fn triangle_uvs(&self, primitive: usize) -> Option<[Vec2; 3]> {
        (!self.uvs.is_empty()).then(|| self.triangles[primitive].map(|i| self.uvs[i as usize]))
    }
}

impl Shape for TriangleMesh {
    fn geometry(&self) -> Geometry<'_> {
        Geometry::Triangles { positions: &self.positions, triangles: &self.triangles }
    }

    fn bounds(&self) -> Aabb {
        // Only the vertices in use: the others may not even be finite.
        Aabb::around(
            self.triangles.iter().flatten().map(|&i| Vec3::from(self.positions[i as usize])),
        )
    }

    fn surface(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        Interaction::new(&Arrivals::one(self, ray, hit), |_| *ray).lane(0)
    }

    fn put(&self, primitive: u32, _time: f32, lane: &mut PrimitiveLane<'_>) {
        let primitive = primitive as usize;
        lane.put_triangle(self.corners(primitive));
        if !self.normals.is_empty() {
            lane.put_normals(self.triangles[primitive].map(|i| self.normals[i as usize]));
        }
    }

    #[cold]
    fn touching(&self, primitive: u32) -> Vec<u32> {
        let neighbours =
            self.neighbours.get_or_init(|| Neighbours::new(&self.positions, &self.triangles));
        let corners = self.corners(primitive as usize);
        let touches = |corner: Vec3A| {
            let has = move |&&other: &&u32| {
                other != primitive && self.corners(other as usize).contains(&corner)
            };
            neighbours.at(corner).iter().filter(has)
        };
        corners.into_iter().flat_map(touches).copied().collect()
    }

    fn uv(&self, _ray: &Ray, hit: &Hit) -> Vec2 {
        triangle::uv(Vec2::new(hit.u, hit.v), self.triangle_uvs(hit.primitive as usize))
    }

    fn tangents(&self, _ray: &Ray, hit: &Hit) -> [Vec3A; 2] {
        let primitive = hit.primitive as usize;
        let corners = self.triangles[primitive].map(|i| self.positions[i as usize]);
        triangle::tangents(corners, self.triangle_uvs(primitive))
    }

    /// Vertex normals may put the front of a triangle on either side, from place to place.
    fn primitive_extent(&self, primitive: usize) -> (Aabb, Cone) {
        let corners = self.triangles[primitive];
        let space = Aabb::around(corners.map(|i| Vec3::from(self.positions[i as usize])));
        let normal = Vec3A::from(self.triangle(primitive).normal);
        let turned = match self.normals.as_slice() {
            [] => [false; 3],
            normals => corners.map(|i| Vec3A::from(normals[i as usize]).dot(normal) < 0.0),
        };
        let normals = match turned {
            [false, false, false] => Cone::direction(normal.into()),
            [true, true, true] => Cone::direction((-normal).into()),
            _ => Cone::ALL,
        };
        (space, normals)
    }

    fn primitive_count(&self) -> usize {
        self.triangles.len()
    }

    fn primitive_area(&self, primitive: usize) -> f64 {
        self.triangle(primitive).area
    }

    fn sample_primitive(&self, primitive: usize, from: DVec3, u: Vec2) -> Option<ShapeSample> {
        let primitives = [primitive as u32];
        ShapeSamples::<f32>::new(&[self], &primitives, from.into(), u.into()).lane(0)
    }

    fn bytes(&self) -> usize {
        size_of_val(self.positions.as_slice())
            + size_of_val(self.triangles.as_slice())
            + size_of_val(self.normals.as_slice())
            + size_of_val(self.uvs.as_slice())
            + self.neighbours.get().map_or(0, Neighbours::bytes)
    }

    fn has_vertex_normals(&self) -> bool {
        !self.normals.is_empty()
    }
}

/// Why a triangle is dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Defect {
    NotFinite,
    TooLarge,
    Degenerate,
}

/// What is wrong with a triangle whose indices are in range.
fn defect(positions: &[Vec3A], triangle: [u32; 3]) -> Option<Defect> {
    let [a, b, c] = triangle.map(|i| positions[i as usize]);
    let largest = a.abs().max(b.abs()).max(c.abs());
    // One comparison for nearly all; NaN is lost by max, so it is asked for by itself.
    if a.is_nan() || b.is_nan() || c.is_nan() || largest.max_element() >= Ray::LARGEST_COORDINATE {
        let finite = a.is_finite() && b.is_finite() && c.is_finite();
        return Some(if finite { Defect::TooLarge } else { Defect::NotFinite });
    }
    // In f64, where the products of the smallest f32 differences do not underflow.
    let [a, b, c] = [a, b, c].map(|p| p.as_dvec3());
    ((b - a).cross(c - a) == DVec3::ZERO).then_some(Defect::Degenerate)
}

/// The triangles to be dropped, in order, or the first index out of range.
fn find_defective(
    positions: &[Vec3A],
    triangles: &[[u32; 3]],
) -> Result<(Dropped, Vec<usize>), MeshError> {
    const CHUNK: usize = 1 << 14;
    let vertices = positions.len();
    let check = |(chunk, triangles): (usize, &[[u32; 3]])| {
        let mut defective = Vec::new();
        for (triangle, &indices) in (chunk * CHUNK..).zip(triangles) {
            if let Some(&vertex) = indices.iter().find(|&&i| i as usize >= vertices) {
                return Err(MeshError::IndexOutOfRange { triangle, vertex, vertices });
            }
            defective.extend(defect(positions, indices).map(|defect| (triangle, defect)));
        }
        Ok(defective)
    };
    let checked: Vec<_> = triangles.par_chunks(CHUNK).enumerate().map(check).collect();
    let (mut dropped, mut all) = (Dropped::default(), Vec::new());
    for chunk in checked {
        for (triangle, defect) in chunk? {
            match defect {
                Defect::NotFinite => dropped.not_finite += 1,
                Defect::TooLarge => dropped.too_large += 1,
                Defect::Degenerate => dropped.degenerate += 1,
            }
            all.push(triangle);
        }
    }
    Ok((dropped, all))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(triangles: Vec<[u32; 3]>) -> Result<(TriangleMesh, Dropped), MeshError> {
        let positions =
            vec![Vec3A::ZERO, Vec3A::X, Vec3A::Y, Vec3A::NAN, Vec3A::splat(f32::INFINITY)];
        TriangleMesh::new(positions, triangles, Vec::new(), Vec::new())
    }

    #[test]
    fn defective_triangles_are_dropped_and_counted() {
        // More than one chunk; the order of the others stays.
        let good = |i: usize| if i.is_multiple_of(2) { [0, 1, 2] } else { [1, 2, 0] };
        let mut triangles: Vec<_> = (0..40_000).map(good).collect();
        for (i, bad) in [(0, [0, 1, 1]), (17_000, [0, 1, 3]), (39_998, [2, 4, 1])] {
            triangles[i] = bad;
        }
        let (mesh, dropped) = mesh(triangles).expect("indices are in range");
        assert_eq!(dropped, Dropped { not_finite: 2, too_large: 0, degenerate: 1 });
        let kept = (0..40_000).filter(|i| ![0, 17_000, 39_998].contains(i)).map(good);
        assert!(mesh.triangles().iter().copied().eq(kept));
    }

    #[test]
    fn the_first_index_out_of_range_is_named() {
        let mut triangles = vec![[0, 1, 2]; 100_000];
        triangles[30_000] = [0, 5, 1];
        triangles[90_000] = [7, 5, 1];
        assert_eq!(
            mesh(triangles).expect_err("an index out of range").to_string(),
            "triangle 30000 refers to vertex 5, but there are 5 vertices"
        );
    }
}
