//! From corners with attributes of their own to vertices with one index for all.

use super::error::Fault;
use crate::shape::mesh::MeshError;

/// How many vertices with the same position are compared before another one is made. More than a
/// few occur only at poles of texture coordinates, where hardly any corner finds its equal; the
/// limit keeps the time linear in the size of any file.
const LONGEST_CHAIN: usize = 32;
/// No vertex: the end of a chain. A mesh never has so many.
const NONE: u32 = u32::MAX;

/// A corner of a triangle with attributes of its own.
pub(super) trait Attributed: Copy + PartialEq {
    /// The file's vertex.
    fn vertex(&self) -> u32;
}

/// One vertex for each combination of indices. Vertices at the same position form a chain, the
/// newest first: faces that share a vertex are mostly neighbours in the file too, so this touches
/// less memory than a hash table.
#[derive(Debug)]
pub(super) struct Split<C> {
    vertices: Vec<C>,
    /// For each vertex, the one before it in its chain.
    older: Vec<u32>,
    /// For each of the file's vertices, the newest vertex of its chain.
    newest: Vec<u32>,
}

impl<C> Default for Split<C> {
    fn default() -> Self {
        Self { vertices: Vec::new(), older: Vec::new(), newest: Vec::new() }
    }
}

impl<C: Attributed> Split<C> {
    /// The vertices of a triangle; the file had so many until now.
    pub(super) fn triangle(&mut self, corners: [C; 3], known: usize) -> Result<[u32; 3], Fault> {
        let [a, b, c] = corners;
        self.newest.resize(known.max(self.newest.len()), NONE);
        Ok([self.vertex(a)?, self.vertex(b)?, self.vertex(c)?])
    }

    fn vertex(&mut self, corner: C) -> Result<u32, Fault> {
        let vertex = u32::try_from(self.vertices.len()).unwrap_or(NONE);
        if vertex == NONE {
            let (what, count) = ("vertices", self.vertices.len());
            return Err(MeshError::TooLarge { what, count }.into());
        }
        // A vertex that the file has not defined yet, and perhaps never will, gets no chain.
        let mut older = NONE;
        if let Some(newest) = self.newest.get_mut(corner.vertex() as usize) {
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

    /// A corner for each vertex; what it took to find them is given back first, so that it makes room for
    /// what is made of them.
    pub(super) fn into_vertices(self) -> Vec<C> {
        self.vertices
    }
}
