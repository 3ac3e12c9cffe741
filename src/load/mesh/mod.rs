//! Stand-in for the mesh loaders.

use std::path::{Path, PathBuf};

use glam::DAffine3;

use crate::shape::mesh::{Dropped, TriangleMesh};

/// How a mesh is read.
#[derive(Clone, Copy, Debug)]
pub struct MeshOptions {
    /// Object to world.
    pub to_world: DAffine3,
    /// Ignore vertex normals.
    pub face_normals: bool,
    /// Turn the normals.
    pub flip_normals: bool,
    /// Turn v upside down.
    pub flip_tex_coords: bool,
}

/// A mesh and what was left out of it.
#[derive(Debug)]
pub struct LoadedMesh {
    /// The mesh.
    pub mesh: TriangleMesh,
    /// What was left out.
    pub dropped: Dropped,
}

/// Why a mesh file cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{}: mesh files are not supported", .path.display())]
pub struct MeshFileError {
    path: PathBuf,
}

impl MeshFileError {
    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Line, from 1.
    #[must_use]
    pub fn line(&self) -> Option<u64> {
        None
    }

    /// Column, from 1.
    #[must_use]
    pub fn column(&self) -> Option<u64> {
        None
    }

    /// The text of the line.
    #[must_use]
    pub fn source_line(&self) -> Option<&str> {
        None
    }
}

/// # Errors
/// Always.
pub fn load_obj(path: &Path, _options: &MeshOptions) -> Result<LoadedMesh, MeshFileError> {
    Err(MeshFileError {
        path: path.to_owned(),
    })
}

/// # Errors
/// Always.
pub fn load_ply(path: &Path, _options: &MeshOptions) -> Result<LoadedMesh, MeshFileError> {
    Err(MeshFileError {
        path: path.to_owned(),
    })
}
