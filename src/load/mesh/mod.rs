//! Mesh files in: OBJ, PLY and Mitsuba's own format become a [`TriangleMesh`].
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
mod serialized;
mod source;
mod text;

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
/// since they do not change the triangles; what else of the format is ignored (materials, curves, lines) is in
/// the [`Remarks`].
///
/// # Errors
/// A file that cannot be read or has no faces, any other keyword, a malformed line, an index that refers to
/// nothing.
pub fn load_obj(path: &Path, options: &MeshOptions) -> Result<LoadedMesh, MeshFileError> {
    in_file(path, || obj::load(path, options))
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

/// Loads on rayon's threads: a small file then costs one handover to them and not one per step.
fn in_file(
    path: &Path,
    load: impl FnOnce() -> Result<LoadedMesh, Fault> + Send,
) -> Result<LoadedMesh, MeshFileError> {
    rayon::scope(|_| load()).map_err(|fault| fault.in_file(path))
}

#[cfg(test)]
pub(super) use serialized::tests::example as serialized_example;
#[cfg(test)]
mod tests;
