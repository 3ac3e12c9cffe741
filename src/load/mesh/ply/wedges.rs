//! Texture coordinates of the corners of faces, as MeshLab writes them.

use glam::Vec2;

use super::super::buffers::Buffers;
use super::super::corners::{Attributed, Split};
use super::super::error::Fault;

/// Texture coordinates for the corners of triangles.
#[derive(Debug, Default)]
pub(super) struct Wedges {
    /// For each triangle those of its corners; `None` for faces that have none.
    triangles: Vec<Option<[Vec2; 3]>>,
    /// Smallest and largest of the numbers of the faces' textures.
    textures: Option<(i64, i64)>,
}

/// A vertex with the texture coordinates that one of its corners has.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Corner {
    vertex: u32,
    /// Compared as bits, so that NaN is equal to itself.
    uv: Option<[u32; 2]>,
}

impl Attributed for Corner {
    fn vertex(&self) -> u32 {
        self.vertex
    }
}

impl Wedges {
    /// Adds a face: two numbers for each corner, or none.
    pub(super) fn push(&mut self, uvs: &[Vec2], triangles: usize) {
        let fan = (0..triangles).map(|i| Some([*uvs.first()?, *uvs.get(i + 1)?, *uvs.get(i + 2)?]));
        self.triangles.extend(fan);
    }

    /// Notes the number of a face's texture.
    pub(super) fn texture(&mut self, number: i64) {
        let (least, most) = self.textures.unwrap_or((number, number));
        self.textures = Some((least.min(number), most.max(number)));
    }

    /// Adds the next piece of a file.
    pub(super) fn append(&mut self, piece: &Self) {
        self.triangles.extend_from_slice(&piece.triangles);
        let numbers = piece.textures.into_iter().flat_map(|(least, most)| [least, most]);
        numbers.for_each(|number| self.texture(number));
    }

    /// Gives `buffers` a vertex for each vertex of the file and each of its texture coordinates.
    pub(super) fn split(self, buffers: &mut Buffers) -> Result<(), Fault> {
        buffers.remarks.several_textures = self.textures.is_some_and(|(least, most)| least < most);
        if self.triangles.iter().all(Option::is_none) {
            return Ok(());
        }
        buffers.remarks.some_lack_uvs = self.triangles.iter().any(Option::is_none);
        let known = buffers.positions.len();
        let mut split = Split::default();
        for (triangle, uvs) in buffers.triangles.iter_mut().zip(self.triangles) {
            let bits = uvs.map(|uvs| uvs.map(|uv| uv.to_array().map(f32::to_bits)));
            let corner = |i: usize| Corner { vertex: triangle[i], uv: bits.map(|bits| bits[i]) };
            *triangle = split.triangle([corner(0), corner(1), corner(2)], known)?;
        }
        let corners = split.into_vertices();
        let of = |corner: &Corner| corner.vertex as usize;
        buffers.positions = corners.iter().map(|c| buffers.positions[of(c)]).collect();
        if !buffers.normals.is_empty() {
            buffers.normals = corners.iter().map(|c| buffers.normals[of(c)]).collect();
        }
        let uv = |corner: &Corner| corner.uv.unwrap_or_default().map(f32::from_bits).into();
        buffers.uvs = corners.iter().map(uv).collect();
        Ok(())
    }
}
