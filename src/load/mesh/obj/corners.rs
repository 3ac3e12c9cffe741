//! The corners of faces, with an index for each attribute.

use super::super::buffers::Buffers;
use super::super::corners::{Attributed, Split};
use super::super::error::Fault;
use super::Attributes;

/// A corner of a triangle. All indices count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Corner {
    pub(super) vertex: u32,
    pub(super) uv: Option<u32>,
    pub(super) normal: Option<u32>,
}

/// The triangles of a file. As long as all indices of each corner are the same, the file's vertices
/// are the mesh's and nothing is looked up.
#[derive(Debug, Default)]
pub(super) struct Corners {
    triangles: Vec<[u32; 3]>,
    /// Like which corner all are, but for the value of its indices.
    pattern: Option<Corner>,
    split: Option<Split<Corner>>,
}

impl Corners {
    /// Adds a triangle; the file had so many vertices until now.
    pub(super) fn push(&mut self, corners: [Corner; 3], known: usize) -> Result<(), Fault> {
        let pattern = *self.pattern.get_or_insert(corners[0]);
        if self.split.is_none() && corners.iter().all(|corner| *corner == pattern.at(corner.vertex))
        {
            self.triangles.push(corners.map(|corner| corner.vertex));
            return Ok(());
        }
        let split = match &mut self.split {
            Some(split) => split,
            none => {
                let mut split = Split::default();
                for triangle in &mut self.triangles {
                    *triangle = split.triangle(triangle.map(|vertex| pattern.at(vertex)), known)?;
                }
                none.insert(split)
            }
        };
        self.triangles.push(split.triangle(corners, known)?);
        Ok(())
    }

    /// The buffers of the mesh. All indices must be known to refer to something.
    pub(super) fn finish(self, attributes: Attributes) -> Buffers {
        let Attributes { mut positions, mut uvs, mut normals } = attributes;
        let mut buffers = Buffers::default();
        if let Some(split) = self.split {
            let vertices = split.into_vertices();
            // One after the other, so that each old buffer makes room for the next new one.
            let has_uv = |corner: &Corner| corner.uv.is_some();
            buffers.remarks.some_lack_uvs =
                vertices.iter().any(has_uv) && !vertices.iter().all(has_uv);
            positions = vertices.iter().map(|corner| positions[corner.vertex as usize]).collect();
            uvs = gather(&uvs, vertices.iter().map(|corner| corner.uv));
            normals = gather(&normals, vertices.iter().map(|corner| corner.normal));
        } else {
            let has_uvs = self.pattern.is_some_and(|corner| corner.uv.is_some());
            let has_normals = self.pattern.is_some_and(|corner| corner.normal.is_some());
            uvs.resize_with(if has_uvs { positions.len() } else { 0 }, Default::default);
            normals.resize_with(if has_normals { positions.len() } else { 0 }, Default::default);
        }
        Buffers { positions, normals, uvs, triangles: self.triangles, ..buffers }
    }
}

impl Attributed for Corner {
    fn vertex(&self) -> u32 {
        self.vertex
    }
}

impl Corner {
    /// A corner with the same attributes as this one and a single index for all.
    fn at(self, vertex: u32) -> Self {
        Self { vertex, uv: self.uv.map(|_| vertex), normal: self.normal.map(|_| vertex) }
    }
}

/// The value of an attribute for each vertex, zero where it has none; nothing if none has any.
fn gather<T: Copy + Default>(
    values: &[T],
    indices: impl Iterator<Item = Option<u32>> + Clone,
) -> Vec<T> {
    if indices.clone().all(|index| index.is_none()) {
        return Vec::new();
    }
    indices.map(|index| index.map_or_else(T::default, |i| values[i as usize])).collect()
}
