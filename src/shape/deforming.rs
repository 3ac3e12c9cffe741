//! Meshes that change their form while the shutter is open.

use std::sync::Arc;

use glam::{Vec2, Vec3, Vec3A};

use super::triangle;
use super::{Arrivals, Geometry, Interaction, PrimitiveLane, Shape, SurfacePoint, TriangleMesh};
use crate::math::{Aabb, Keys, KeysError};
use crate::ray::{Hit, Ray};

/// A mesh whose vertices, and vertex normals, go along straight lines from each key mesh to the next.
///
/// One tree, in Rust, answers for it in every engine, so that all of them see the same triangles: Embree's own
/// interpolation, in f32, places vertices elsewhere, by roundings of their coordinates.
#[derive(Debug)]
pub struct DeformingMesh {
    /// Meshes of the same triangles, by moments in units of the shutter.
    keys: Keys<Arc<TriangleMesh>>,
    bounds: Aabb,
}

/// Why meshes are not the keys of a deforming one.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DeformingError {
    /// What is wrong with the moments.
    #[error(transparent)]
    Keys(#[from] KeysError),
    /// A key with other triangles than the first.
    #[error(
        "key {key} has other triangles than the first: all need the same vertices in the same faces"
    )]
    Topology {
        /// Which, from 0.
        key: usize,
    },
    /// A key that has what the first lacks, or the other way round.
    #[error("key {key} and the first do not both have {attribute}")]
    Attribute {
        /// Which, from 0.
        key: usize,
        /// `"vertex normals"` or `"texture coordinates"`.
        attribute: &'static str,
    },
}

impl DeformingMesh {
    /// The mesh that is `keys` at their moments, in units of the shutter, and before the first and after the last
    /// rests. Texture coordinates are those of the first.
    ///
    /// # Errors
    /// No key, moments that do not ascend, meshes of different topology.
    pub fn new(keys: Vec<(f64, Arc<TriangleMesh>)>) -> Result<Self, DeformingError> {
        let keys = Keys::new(keys)?;
        let first = keys.first();
        for (key, (_, mesh)) in keys.as_slice().iter().enumerate() {
            let vertices = mesh.positions().len() == first.positions().len();
            if !vertices || mesh.triangles() != first.triangles() {
                return Err(DeformingError::Topology { key });
            }
            let pairs = [
                ("vertex normals", mesh.normals().len() == first.normals().len()),
                ("texture coordinates", mesh.uvs().len() == first.uvs().len()),
            ];
            if let Some((attribute, _)) = pairs.into_iter().find(|(_, alike)| !alike) {
                return Err(DeformingError::Attribute { key, attribute });
            }
        }
        let bounds =
            keys.as_slice().iter().fold(Aabb::EMPTY, |all, (_, mesh)| all.union(mesh.bounds()));
        Ok(Self { keys, bounds })
    }

    /// The triangles of all keys, as three vertex indices each.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        self.keys.first().triangles()
    }

    /// The corners of a triangle at a moment within the shutter, formed in f64 and rounded once: never outside of
    /// the box around those of the keys.
    #[must_use]
    pub fn corners(&self, primitive: usize, time: f32) -> [Vec3A; 3] {
        let (from, to, part) = self.keys.around(time.into());
        self.triangles()[primitive].map(|i| {
            let [p, q] = [from, to].map(|mesh| mesh.positions()[i as usize]);
            p.as_dvec3().lerp(q.as_dvec3(), part).as_vec3a().clamp(p.min(q), p.max(q))
        })
    }

    /// The ends of the shutter, and the moments between them at which vertices turn.
    #[must_use]
    pub fn moments(&self) -> Vec<f32> {
        let turns = self.keys.as_slice().iter().map(|(time, _)| *time as f32);
        let mut moments = vec![0.0];
        moments.extend(turns.filter(|time| (f32::MIN_POSITIVE..1.0).contains(time)));
        moments.push(1.0);
        moments.dedup();
        moments
    }

    /// The box around a triangle at all moments.
    #[must_use]
    pub fn primitive_bounds(&self, primitive: usize) -> Aabb {
        let corners = self.keys.as_slice().iter().flat_map(|(_, mesh)| {
            self.triangles()[primitive].map(|i| Vec3::from(mesh.positions()[i as usize]))
        });
        Aabb::around(corners)
    }

    /// The vertex normals of a triangle at a moment.
    fn normals(&self, primitive: usize, time: f32) -> Option<[Vec3; 3]> {
        let (from, to, part) = self.keys.around(time.into());
        (!from.normals().is_empty()).then(|| {
            self.triangles()[primitive].map(|i| {
                let [m, n] = [from, to].map(|mesh| mesh.normals()[i as usize]);
                m.lerp(n, part as f32)
            })
        })
    }

    /// The texture coordinates of a triangle's corners.
    fn uvs(&self, primitive: usize) -> Option<[Vec2; 3]> {
        let uvs = self.keys.first().uvs();
        (!uvs.is_empty()).then(|| self.triangles()[primitive].map(|i| uvs[i as usize]))
    }

    /// The mesh as it is at a moment.
    #[must_use]
    pub fn at(&self, time: f32) -> TriangleMesh {
        let (from, to, part) = self.keys.around(time.into());
        let positions = from.positions().iter().zip(to.positions());
        let positions = positions.map(|(p, q)| p.as_dvec3().lerp(q.as_dvec3(), part).as_vec3a());
        let normals = from.normals().iter().zip(to.normals());
        let normals = normals.map(|(m, n)| m.as_dvec3().lerp(n.as_dvec3(), part).as_vec3());
        let (positions, normals) = (positions.collect(), normals.collect());
        let triangles = self.triangles().to_vec();
        let mesh =
            TriangleMesh::new(positions, triangles, normals, self.keys.first().uvs().to_vec());
        mesh.expect("as many vertices and the same indices as the keys").0
    }
}

impl Shape for DeformingMesh {
    fn geometry(&self) -> Geometry<'_> {
        Geometry::Deforming(self)
    }

    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn surface(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        Interaction::new(&Arrivals::one(self, ray, hit), |_| *ray).lane(0)
    }

    fn put(&self, primitive: u32, time: f32, lane: &mut PrimitiveLane<'_>) {
        let primitive = primitive as usize;
        lane.put_triangle(self.corners(primitive, time));
        if let Some(normals) = self.normals(primitive, time) {
            lane.put_normals(normals);
        }
    }

    /// At the beginning.
    fn touching(&self, primitive: u32) -> Vec<u32> {
        self.keys.first().touching(primitive)
    }

    fn uv(&self, _ray: &Ray, hit: &Hit) -> Vec2 {
        triangle::uv(Vec2::new(hit.u, hit.v), self.uvs(hit.primitive as usize))
    }

    fn tangents(&self, ray: &Ray, hit: &Hit) -> [Vec3A; 2] {
        let primitive = hit.primitive as usize;
        triangle::tangents(self.corners(primitive, ray.time), self.uvs(primitive))
    }

    fn primitive_count(&self) -> usize {
        self.triangles().len()
    }

    fn bytes(&self) -> usize {
        self.keys.as_slice().iter().map(|(_, mesh)| mesh.bytes()).sum()
    }

    fn has_vertex_normals(&self) -> bool {
        !self.keys.first().normals().is_empty()
    }

    fn moves(&self) -> bool {
        true
    }
}
