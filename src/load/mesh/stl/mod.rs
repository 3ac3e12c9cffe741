//! STL: triangles one by one, each with its own three points. Points at the same place become one vertex.
//!
//! Normals of facets are not read: the order of the points says the same. Of binary files, the two bytes that
//! some programs use for colours are skipped.

mod ascii;
mod binary;

#[cfg(test)]
mod tests;

use std::io::{Cursor, Read};
use std::path::Path;

use glam::Vec3A;

use super::buffers::{Buffers, Placement};
use super::error::{Fault, MeshProblem};
use super::source::Source;
use super::{LoadedMesh, MeshOptions, weld};

/// How much of a file is looked at to tell text from binary data.
const SAMPLE: u64 = 1024;

/// Of UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

pub(super) fn load(path: &Path, options: &MeshOptions) -> Result<LoadedMesh, Fault> {
    let mut source = Source::open(path, &options.limits)?;
    let mut start = Vec::new();
    (&mut source.reader).take(SAMPLE).read_to_end(&mut start)?;
    let is_text = is_text(&start);
    if !is_text && start.len() as u64 == SAMPLE && !start.iter().any(|&b| is_control(b)) {
        // Of another format: as bytes it would be said to end after some of a billion facets.
        return Err(MeshProblem::NotStl.into());
    }
    if is_text && start.starts_with(BYTE_ORDER_MARK) {
        drop(start.drain(..BYTE_ORDER_MARK.len()));
    }
    source.reader = Box::new(Cursor::new(start).chain(source.reader));
    let placement = Placement::new(options);
    let corners = if is_text {
        ascii::read(&mut source, &placement)?
    } else {
        binary::read(source, &placement)?
    };
    indexed(&corners)?.loaded(options)
}

/// Whether a file that begins so is text. Binary ones may begin with `solid` as well, but have control characters
/// soon: the count of their triangles has four bytes, of which the last is 0 below 16.7 million.
fn is_text(start: &[u8]) -> bool {
    let start = start.strip_prefix(BYTE_ORDER_MARK).unwrap_or(start).trim_ascii_start();
    start.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
        && !start.iter().any(|&b| is_control(b))
}

fn is_control(byte: u8) -> bool {
    byte < b' ' && !byte.is_ascii_whitespace()
}

/// Triangles with a vertex for each place, in the order in which they occur.
fn indexed(corners: &[Vec3A]) -> Result<Buffers, Fault> {
    let mut buffers = Buffers::default();
    let first = weld::first_at_place(corners);
    let mut vertex_of = vec![0u32; corners.len()];
    for (corner, &first) in first.iter().enumerate() {
        vertex_of[corner] = if first as usize == corner {
            buffers.positions.push(corners[corner]);
            buffers.positions.len() as u32 - 1
        } else {
            vertex_of[first as usize]
        };
    }
    let (triangles, _) = vertex_of.as_chunks::<3>();
    buffers.triangles = triangles.to_vec();
    Ok(buffers)
}

/// Asks for the memory of so many triangles while their points are put together.
fn claim(source: &Source, triangles: u64) -> Result<(), Fault> {
    source.claim(triangles.saturating_mul(3 * (size_of::<Vec3A>() as u64 + 32 + 8)))
}

/// More corners than 32 bits can count.
fn check_count(corners: usize) -> Result<(), Fault> {
    if corners < u32::MAX as usize {
        return Ok(());
    }
    let (what, count) = ("corners", corners);
    Err(MeshProblem::from(crate::shape::mesh::MeshError::TooLarge { what, count }).into())
}
