//! The buffers of a mesh while it is read, and how they are put into the world.

use std::mem;

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3, Vec3A};

use super::error::{Fault, MeshProblem};
use super::polygons::{self, Polygons};
use super::remarks::Remarks;
use super::runs::Runs;
use super::{LoadedMesh, MeshOptions, smooth};
use crate::shape::TriangleMesh;
use crate::shape::mesh::{Dropped, MeshError};

/// A mesh, or the piece of one that a block of a file holds.
#[derive(Debug, Default)]
pub(super) struct Buffers {
    pub(super) positions: Vec<Vec3A>,
    pub(super) normals: Vec<Vec3>,
    pub(super) uvs: Vec<Vec2>,
    /// Fans of the polygons.
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) polygons: Polygons,
    pub(super) remarks: Remarks,
    /// Groups of faces that are smooth among each other, 0 for those that are flat; `None` where the file does not say.
    pub(super) smoothing: Runs<Option<u32>>,
}

impl Buffers {
    /// Where a vertex is.
    pub(super) fn position(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize].as_dvec3()
    }

    /// Bytes of a vertex with these attributes.
    pub(super) fn vertex_bytes(has_normals: bool, has_uvs: bool) -> u64 {
        let if_kept = |kept, size| if kept { size } else { 0 };
        (size_of::<Vec3A>()
            + if_kept(has_normals, size_of::<Vec3>())
            + if_kept(has_uvs, size_of::<Vec2>())) as u64
    }

    /// Bytes of a triangle.
    pub(super) const TRIANGLE_BYTES: u64 = size_of::<[u32; 3]>() as u64;

    /// Adds a piece at the end. Its triangles already have the indices of the whole mesh.
    pub(super) fn append(&mut self, piece: &Self) {
        self.positions.extend_from_slice(&piece.positions);
        self.normals.extend_from_slice(&piece.normals);
        self.uvs.extend_from_slice(&piece.uvs);
        self.triangles.extend_from_slice(&piece.triangles);
        self.polygons.append(&piece.polygons);
    }

    /// Cuts polygons, makes normals where they are asked for, and says what was left out.
    pub(super) fn prepare(&mut self, options: &MeshOptions) -> Result<Remarks, Fault> {
        if self.triangles.is_empty() {
            return Err(MeshProblem::NoFaces { vertices: self.positions.len() }.into());
        }
        let polygons::Outcome { mut replaced, crossing } =
            self.polygons.triangulate(&self.positions, &mut self.triangles);
        for uv in &mut self.uvs {
            if !uv.is_finite() {
                self.remarks.not_finite_uvs += 1;
                *uv = Vec2::ZERO;
            }
        }
        if options.flip_normals {
            polygons::flip(&mut replaced);
            for triangle in &mut self.triangles {
                triangle.swap(1, 2);
            }
        }
        if let Some(angle) = options.max_smooth_angle {
            let groups = (!self.smoothing.is_empty())
                .then(|| self.smoothing.values(self.triangles.len(), None, &replaced));
            smooth::smooth(self, angle, groups.as_deref())?;
        }
        Ok(Remarks { replaced, crossing, ..mem::take(&mut self.remarks) })
    }

    /// The mesh.
    pub(super) fn loaded(mut self, options: &MeshOptions) -> Result<LoadedMesh, Fault> {
        let remarks = self.prepare(options)?;
        let (mesh, dropped) = self.finish()?;
        Ok(LoadedMesh { mesh, dropped, remarks })
    }

    /// The mesh, prepared, with no memory to spare.
    fn finish(mut self) -> Result<(TriangleMesh, Dropped), Fault> {
        self.positions.shrink_to_fit();
        self.normals.shrink_to_fit();
        self.uvs.shrink_to_fit();
        self.triangles.shrink_to_fit();
        Ok(TriangleMesh::new(self.positions, self.triangles, self.normals, self.uvs)?)
    }

    /// The meshes, prepared, of the triangles of each number below `count`, unless there are none; each has the
    /// vertices that it uses.
    pub(super) fn split(self, numbers: &[u32], count: usize) -> Result<Vec<PartOfMesh>, Fault> {
        let vertices = self.positions.len();
        let mut triangles_of = vec![Vec::new(); count];
        for (triangle, &number) in self.triangles.iter().zip(numbers) {
            if let Some(&vertex) = triangle.iter().find(|&&i| i as usize >= vertices) {
                return Err(MeshError::IndexOutOfRange { triangle: 0, vertex, vertices }.into());
            }
            triangles_of[number as usize].push(*triangle);
        }
        // For each vertex, for which part it was last taken, and its index there.
        let mut taken = vec![(usize::MAX, 0_u32); vertices];
        let mut parts = Vec::new();
        for (number, mut triangles) in triangles_of.into_iter().enumerate() {
            if triangles.is_empty() {
                continue;
            }
            let mut used = Vec::new();
            for vertex in triangles.as_flattened_mut() {
                let place = &mut taken[*vertex as usize];
                if place.0 != number {
                    *place = (number, used.len() as u32);
                    used.push(*vertex as usize);
                }
                *vertex = place.1;
            }
            let part = Self {
                positions: used.iter().map(|&i| self.positions[i]).collect(),
                normals: gather(&self.normals, &used),
                uvs: gather(&self.uvs, &used),
                triangles,
                ..Self::default()
            };
            let (mesh, dropped) = part.finish()?;
            parts.push(PartOfMesh { number: number as u32, mesh, dropped });
        }
        Ok(parts)
    }
}

/// The triangles of one number.
#[derive(Debug)]
pub(super) struct PartOfMesh {
    pub(super) number: u32,
    pub(super) mesh: TriangleMesh,
    pub(super) dropped: Dropped,
}

/// The values of some vertices; nothing if there are none.
fn gather<T: Copy>(values: &[T], used: &[usize]) -> Vec<T> {
    if values.is_empty() { Vec::new() } else { used.iter().map(|&i| values[i]).collect() }
}

/// What happens to each value of a file on its way into the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    to_world: DAffine3,
    normal_to_world: DMat3,
    flip_tex_coords: bool,
}

impl Placement {
    pub(super) fn new(options: &MeshOptions) -> Self {
        let m = options.to_world.matrix3;
        let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
        // The cofactors are the inverse transpose times the determinant. They exist for a singular
        // matrix too, and only the determinant's sign matters: normals are normalised.
        let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        let outward = if options.flip_normals { -1.0 } else { 1.0 };
        Self {
            to_world: options.to_world,
            normal_to_world: cofactors * (outward * m.determinant().signum()),
            flip_tex_coords: options.flip_tex_coords,
        }
    }

    /// A position in the world, rounded once.
    pub(super) fn position(&self, p: DVec3) -> Vec3A {
        self.to_world.transform_point3(p).as_vec3a()
    }

    /// A unit normal in the world; zero where the file's has no direction.
    pub(super) fn normal(&self, n: DVec3) -> Vec3 {
        (self.normal_to_world * n).normalize_or_zero().as_vec3()
    }

    /// Texture coordinates.
    pub(super) fn uv(&self, u: f64, v: f64) -> Vec2 {
        let v = if self.flip_tex_coords { 1.0 - v } else { v };
        Vec2::new(u as f32, v as f32)
    }
}
