//! A closed triangle mesh: what can be counted on it, and its file.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use glam::Vec3;
use rayon::prelude::*;
use telamon::film::output::AtomicFile;

use crate::figure::Figure;

/// Triangles seen counter-clockwise from outside the figure that they were cut from.
pub(crate) struct Mesh {
    pub(crate) figure: Figure,
    pub(crate) vertices: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Mesh {
    pub(crate) fn of(figure: Figure) -> Self {
        Self { figure, vertices: Vec::new(), triangles: Vec::new() }
    }

    /// The number of connected pieces, by union-find over the triangles.
    pub(crate) fn components(&self) -> usize {
        let mut parents: Vec<u32> = (0..self.vertices.len() as u32).collect();
        let mut pieces = parents.len();
        for &[a, b, c] in &self.triangles {
            for (a, b) in [(a, b), (b, c)] {
                let (a, b) = (root(&mut parents, a), root(&mut parents, b));
                parents[a.max(b) as usize] = a.min(b);
                pieces -= usize::from(a != b);
            }
        }
        pieces
    }

    /// The number of handles: Euler's V - E + F = 2 (components - genus), where a closed mesh has
    /// E = 3 F / 2.
    pub(crate) fn genus(&self) -> i64 {
        let euler = self.vertices.len() as i64 - self.triangles.len() as i64 / 2;
        self.components() as i64 - euler / 2
    }
}

/// The representative of the piece that holds `v`; halves the way there for the next one to ask.
fn root(parents: &mut [u32], mut v: u32) -> u32 {
    while parents[v as usize] != v {
        let above = parents[parents[v as usize] as usize];
        parents[v as usize] = above;
        v = above;
    }
    v
}

/// Writes binary little-endian PLY. The file appears whole or not at all.
pub(crate) fn write_ply(mesh: &Mesh, normals: bool, path: &Path) -> io::Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let file = AtomicFile::create(path).map_err(io::Error::other)?;
    let mut out = BufWriter::with_capacity(1 << 20, file);
    encode(mesh, normals, &mut out)?;
    out.into_inner()?.finish().map_err(io::Error::other)
}

pub(crate) fn encode(mesh: &Mesh, normals: bool, out: &mut impl Write) -> io::Result<()> {
    let coordinates = |names: [&str; 3]| names.map(|n| format!("property float {n}\n")).concat();
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\ncomment telamon, examples/sculpt.rs\n\
         element vertex {}\n{}{}element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.vertices.len(),
        coordinates(["x", "y", "z"]),
        if normals { coordinates(["nx", "ny", "nz"]) } else { String::new() },
        mesh.triangles.len(),
    )?;
    let mut put = |v: Vec3| v.to_array().iter().try_for_each(|c| out.write_all(&c.to_le_bytes()));
    // In blocks, so that the normals are found in parallel but not all held.
    for block in mesh.vertices.chunks(1 << 20) {
        let of_block: Vec<Vec3> = if normals {
            block.par_iter().map(|&p| mesh.figure.normal(p)).collect()
        } else {
            Vec::new()
        };
        for (i, &p) in block.iter().enumerate() {
            put(p)?;
            of_block.get(i).map_or(Ok(()), |&n| put(n))?;
        }
    }
    for triangle in &mesh.triangles {
        out.write_all(&[3])?;
        triangle.iter().try_for_each(|i| out.write_all(&i.to_le_bytes()))?;
    }
    out.flush()
}
