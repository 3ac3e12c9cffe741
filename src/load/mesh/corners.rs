//! From corners with an index per attribute to vertices with one index for all.

use super::super::buffers::Buffers;
use super::super::error::Fault;
use super::Attributes;
use crate::shape::mesh::MeshError;

/// How many vertices with the same position are compared before another one is made. More than a
/// few occur only at poles of texture coordinates, where hardly any corner finds its equal; the
/// limit keeps the time linear in the size of any file.
const LONGEST_CHAIN: usize = 32;
/// No vertex: the end of a chain. A mesh never has so many.
const NONE: u32 = u32::MAX;

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
    split: Option<Split>,
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

    /// The mesh. All indices must be known to refer to something.
    pub(super) fn finish(self, attributes: Attributes) -> Buffers {
        let Attributes { mut positions, mut uvs, mut normals } = attributes;
        if let Some(split) = self.split {
            let vertices = split.vertices;
            // One after the other, so that each old buffer makes room for the next new one.
            drop((split.older, split.newest));
            positions = vertices.iter().map(|corner| positions[corner.vertex as usize]).collect();
            uvs = gather(&uvs, vertices.iter().map(|corner| corner.uv));
            normals = gather(&normals, vertices.iter().map(|corner| corner.normal));
        } else {
            let has_uvs = self.pattern.is_some_and(|corner| corner.uv.is_some());
            let has_normals = self.pattern.is_some_and(|corner| corner.normal.is_some());
            uvs.resize_with(if has_uvs { positions.len() } else { 0 }, Default::default);
            normals.resize_with(if has_normals { positions.len() } else { 0 }, Default::default);
        }
        Buffers { positions, normals, uvs, triangles: self.triangles }
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

/// One vertex for each combination of indices. Vertices at the same position form a chain, the
/// newest first: faces that share a vertex are mostly neighbours in the file too, so this touches
/// less memory than a hash table.
#[derive(Debug, Default)]
struct Split {
    vertices: Vec<Corner>,
    /// For each vertex, the one before it in its chain.
    older: Vec<u32>,
    /// For each of the file's vertices, the newest vertex of its chain.
    newest: Vec<u32>,
}

impl Split {
    fn triangle(&mut self, corners: [Corner; 3], known: usize) -> Result<[u32; 3], Fault> {
        let [a, b, c] = corners;
        self.newest.resize(known.max(self.newest.len()), NONE);
        Ok([self.vertex(a)?, self.vertex(b)?, self.vertex(c)?])
    }

    fn vertex(&mut self, corner: Corner) -> Result<u32, Fault> {
        let vertex = u32::try_from(self.vertices.len()).unwrap_or(NONE);
        if vertex == NONE {
            let (what, count) = ("vertices", self.vertices.len());
            return Err(MeshError::TooLarge { what, count }.into());
        }
        // A vertex that the file has not defined yet, and perhaps never will, gets no chain.
        let mut older = NONE;
        if let Some(newest) = self.newest.get_mut(corner.vertex as usize) {
            let mut candidate = *newest;
            for _ in 0..LONGEST_CHAIN {
                if candidate == NONE {
                    break;
                }
                if self.vertices[candidate as usize] == corner {
                    return Ok(candidate);
                }
                candidate = self.older[candidate as usize];
            }
            older = std::mem::replace(newest, vertex);
        }
        self.vertices.push(corner);
        self.older.push(older);
        Ok(vertex)
    }
}
