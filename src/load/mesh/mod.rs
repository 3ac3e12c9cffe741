//! Mesh files in: OBJ, PLY, STL and Mitsuba's own format become a [`TriangleMesh`].
//!
//! All are read in blocks of whole lines or records, so a load holds the mesh and a few megabytes
//! beside it, never the file. Text is parsed by all threads; the result is the same for any number
//! of them. Whether a file is compressed with gzip is seen in its first two bytes, not in its name.
//!
//! Convex polygons become fans around their first vertex, as in Mitsuba 3; `polygons` says what becomes of
//! others.

mod buffers;
mod bytes;
mod corners;
mod error;
mod obj;
mod ply;
mod polygons;
mod remarks;
mod runs;
mod serialized;
mod smooth;
mod source;
mod stl;
mod text;
mod weld;

use std::path::Path;

use glam::DAffine3;

pub use error::{MeshFileError, MeshProblem};
pub(super) use polygons::fans;
pub use remarks::{Materials, Names, Remarks};

use self::error::Fault;
use super::precision;
use crate::memory::Limits;
use crate::shape::mesh::{Dropped, TriangleMesh};

/// How a file's mesh is put into the world.
#[derive(Clone, Debug, Default)]
pub struct MeshOptions {
    /// From the file's coordinates to the world's. Positions are transformed in f64 and rounded
    /// once; normals go with the inverse transpose. A mirroring transform leaves the winding as it
    /// is, so without vertex normals what was outside becomes inside: Mitsuba 3 does the same.
    pub to_world: DAffine3,
    /// Ignore the file's vertex normals.
    pub face_normals: bool,
    /// Give the mesh new vertex normals: faces that turn by no more than so many degrees at their common edge share
    /// them, others do not. Whatever the file has is dropped.
    pub max_smooth_angle: Option<f64>,
    /// Turn the surface inside out: winding and vertex normals.
    pub flip_normals: bool,
    /// Read the texture coordinate v as 1 - v (Mitsuba 3 does so for OBJ unless told otherwise, and
    /// not for PLY).
    pub flip_tex_coords: bool,
    /// What the mesh may take, and what a compressed file may unpack to.
    pub limits: Limits,
}

/// What a mesh file held.
#[derive(Clone, Debug)]
pub struct LoadedMesh {
    /// The mesh, in world space.
    pub mesh: TriangleMesh,
    /// Triangles that the mesh is without.
    pub dropped: Dropped,
    /// What else of the file it is without.
    pub remarks: Remarks,
}

impl LoadedMesh {
    /// What is not as the file says: what is left out, and what 32-bit floats distort.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let dropped = (!self.dropped.is_none()).then(|| self.dropped.to_string());
        let others = self.remarks.warnings().into_iter().chain(precision::doubts(&self.mesh));
        dropped.into_iter().chain(others.map(|(what, help)| format!("{what}; {help}"))).collect()
    }
}

/// The mesh in a Wavefront OBJ file. All groups and objects in it become one mesh.
///
/// Read: `v` (a weight or a colour behind the position is ignored), `vt`, `vn` and `f`, with
/// negative indices, comments and continued lines. Corners of a face without a normal get the geometric
/// one, corners without texture coordinates (0, 0), if other faces have them. `o`, `g` and `s` are ignored,
/// since they do not change the triangles (`s` counts where `max_smooth_angle` makes normals); what else of the format is ignored (materials, curves, lines) is in
/// the [`Remarks`].
///
/// # Errors
/// A file that cannot be read or has no faces, any other keyword, a malformed line, an index that refers to
/// nothing.
pub fn load_obj(path: &Path, options: &MeshOptions) -> Result<LoadedMesh, MeshFileError> {
    in_file(path, || obj::load(path, options))
}

/// The meshes of an OBJ file by their materials.
#[derive(Clone, Debug)]
pub struct ObjMaterials {
    /// What stands behind each `mtllib`: the name of a file, or several.
    pub libraries: Vec<String>,
    /// The faces of each material, with its name; `None` for those before the first `usemtl`. The remarks of the first one
    /// are about all.
    pub meshes: Vec<(Option<String>, LoadedMesh)>,
}

/// As [`load_obj`], but a mesh for each material that faces ask for (`usemtl`).
///
/// # Errors
/// As [`load_obj`].
pub fn load_obj_by_material(
    path: &Path,
    options: &MeshOptions,
) -> Result<ObjMaterials, MeshFileError> {
    in_file(path, || obj::load_by_material(path, options))
}

/// The mesh in a PLY file: ASCII, or binary in either byte order.
///
/// Of the element `vertex` this reads x, y, z, nx, ny, nz and texture coordinates (`u v`, `s t`,
/// `texture_u texture_v` or `texture_s texture_t`), of the element `face` the list `vertex_indices`
/// or `vertex_index` and, as texture coordinates of its corners, the list `texcoord`, which counts for more than
/// those of the vertices. All other properties and elements are skipped. In ASCII, each record is a line.
///
/// # Errors
/// A file that cannot be read, has no vertices or faces, has triangle strips, ends early or goes on
/// after the last element, a malformed value, an index that refers to nothing.
pub fn load_ply(path: &Path, options: &MeshOptions) -> Result<LoadedMesh, MeshFileError> {
    in_file(path, || ply::load(path, options))
}

/// The mesh in an STL file, text or binary. Points at the same place become one vertex.
///
/// Normals of facets and colours are not read. Polygons, which some programs write, become fans.
///
/// # Errors
/// A file that cannot be read, has no facets or ends within one, a malformed line.
pub fn load_stl(path: &Path, options: &MeshOptions) -> Result<LoadedMesh, MeshFileError> {
    in_file(path, || stl::load(path, options))
}

/// The mesh of that index, from 0, in a file of Mitsuba's format `serialized`, of version 3 or 4.
///
/// Read: positions, normals and texture coordinates in either precision, triangles, and the flag that asks
/// for face normals. Colours are skipped. The list of meshes at the end of the file is used for all but the
/// first one.
///
/// # Errors
/// A file that cannot be read or is damaged, another version, no mesh of that index, an index that refers to
/// nothing.
pub fn load_serialized(
    path: &Path,
    shape_index: u32,
    options: &MeshOptions,
) -> Result<LoadedMesh, MeshFileError> {
    in_file(path, || serialized::load(path, shape_index, options))
}

/// A format of mesh files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// As [`load_obj`] reads it.
    Obj,
    /// As [`load_ply`] reads it.
    Ply,
    /// As [`load_stl`] reads it.
    Stl,
    /// As [`load_serialized`] reads it.
    Serialized,
}

impl MeshFormat {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Obj, Self::Ply, Self::Stl, Self::Serialized];

    /// What the name of a file says, whatever its case and a last `.gz` aside; `None` if it is no mesh's.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_string_lossy().to_lowercase();
        let name = name.strip_suffix(".gz").unwrap_or(&name);
        let (_, extension) = name.rsplit_once('.')?;
        Self::ALL.into_iter().find(|format| format.plugin() == extension)
    }

    /// The `type` of its shapes in scene files, which is also the extension of its files.
    #[must_use]
    pub fn plugin(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Stl => "stl",
            Self::Serialized => "serialized",
        }
    }

    /// The mesh in a file of this format; the first one of several.
    ///
    /// # Errors
    /// Those of the format.
    pub fn load(self, path: &Path, options: &MeshOptions) -> Result<LoadedMesh, MeshFileError> {
        match self {
            Self::Obj => load_obj(path, options),
            Self::Ply => load_ply(path, options),
            Self::Stl => load_stl(path, options),
            Self::Serialized => load_serialized(path, 0, options),
        }
    }
}

/// Loads on rayon's threads: a small file then costs one handover to them and not one per step.
fn in_file<T: Send>(
    path: &Path,
    load: impl FnOnce() -> Result<T, Fault> + Send,
) -> Result<T, MeshFileError> {
    rayon::scope(|_| load()).map_err(|fault| fault.in_file(path))
}

#[cfg(test)]
pub(super) use serialized::tests::example as serialized_example;
#[cfg(test)]
mod tests;
