//! The lines of an OBJ file.

use std::ops::AddAssign;

use glam::DVec3;

use super::super::buffers::Placement;
use super::super::error::{Fault, MeshProblem, Place, excerpt};
use super::super::polygons::Polygons;
use super::super::remarks::{Materials, Statements};
use super::super::runs::Runs;
use super::super::text::{Cursor, ends_word, parse_integer};
use super::Attributes;
use super::corners::Corner;

/// What v, vt and vn are called in an error.
const ATTRIBUTES: [&str; 3] = ["vertex index", "texture coordinate index", "normal index"];
/// A position, with a colour or a weight, and then some.
const MOST_NUMBERS: usize = 8;

/// How many `v`, `vt` and `vn` there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts(pub(super) [u64; 3]);

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        for (count, more) in self.0.iter_mut().zip(other.0) {
            *count += more;
        }
    }
}

/// An index, before it is known whether it refers to something.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reference {
    attribute: usize,
    index: i64,
    line: u64,
    column: u64,
}

impl Reference {
    /// An error if there are too few to refer to.
    pub(super) fn check(&self, count: u64) -> Result<(), Fault> {
        if self.index.unsigned_abs() <= count {
            return Ok(());
        }
        let &Self { attribute, index, line, column } = self;
        let attribute = ATTRIBUTES[attribute];
        let place = Place::Line { line, column };
        Err(Fault::new(place, MeshProblem::IndexOutOfRange { attribute, index, count }))
    }

    /// Keeps the larger index, or the earlier of two equal ones.
    pub(super) fn keep_larger(kept: &mut Option<Self>, other: Option<Self>) {
        if let Some(other) = other
            && kept.is_none_or(|kept| other.index > kept.index)
        {
            *kept = Some(other);
        }
    }
}

/// What a part of a file holds.
#[derive(Debug, Default)]
pub(super) struct Part {
    pub(super) attributes: Attributes,
    pub(super) triangles: Vec<[Corner; 3]>,
    pub(super) polygons: Polygons,
    pub(super) materials: Materials,
    pub(super) statements: Statements,
    /// Names after `mtllib`.
    pub(super) libraries: Vec<String>,
    /// Names after `usemtl`.
    pub(super) used: Runs<String>,
    /// Numbers after `s`, 0 for none.
    pub(super) smoothing: Runs<u32>,
    pub(super) furthest: [Option<Reference>; 3],
}

/// Counts without parsing.
pub(super) fn count(cursor: &mut Cursor) -> Counts {
    let mut counts = Counts::default();
    while cursor.find_word() {
        match cursor.word() {
            b"v" => counts.0[0] += 1,
            b"vt" => counts.0[1] += 1,
            b"vn" => counts.0[2] += 1,
            _ => {}
        }
        cursor.next_line();
    }
    counts
}

/// Parses the lines of a part that has `before` before it.
pub(super) fn parse(
    cursor: &mut Cursor,
    before: Counts,
    placement: &Placement,
) -> Result<Part, Fault> {
    let mut part = Part::default();
    let mut known = before;
    while cursor.find_word() {
        match cursor.word() {
            b"v" => {
                let [x, y, z, ..] = numbers(cursor, "a position", 3, MOST_NUMBERS)?;
                part.attributes.positions.push(placement.position(DVec3::new(x, y, z)));
                known.0[0] += 1;
            }
            b"vt" => {
                let [u, v, ..] = numbers(cursor, "a texture coordinate", 1, 3)?;
                part.attributes.uvs.push(placement.uv(u, v));
                known.0[1] += 1;
            }
            b"vn" => {
                let [x, y, z, ..] = numbers(cursor, "a normal", 3, 3)?;
                part.attributes.normals.push(placement.normal(DVec3::new(x, y, z)));
                known.0[2] += 1;
            }
            b"f" => face(cursor, known, &mut part)?,
            b"o" | b"g" => {}
            b"s" => {
                let group = cursor.word();
                // Anything but a number above 0 is `off`.
                let group = parse_integer(group).0.and_then(|g| u32::try_from(g).ok());
                part.smoothing.begin(part.triangles.len(), group.unwrap_or(0));
            }
            b"mtllib" => {
                let name = name(cursor);
                part.materials.libraries.add(&excerpt(name.as_bytes()));
                part.libraries.push(name);
            }
            b"usemtl" => {
                let name = name(cursor);
                part.materials.used.add(&excerpt(name.as_bytes()));
                part.used.begin(part.triangles.len(), name);
            }
            keyword if part.statements.note(keyword) => {}
            keyword => {
                let keyword = excerpt(keyword);
                return Err(cursor.fault(MeshProblem::UnknownKeyword { keyword }));
            }
        }
        cursor.next_line();
    }
    Ok(part)
}

/// The numbers in the rest of a line; zero where there are fewer.
fn numbers(
    cursor: &mut Cursor,
    what: &'static str,
    least: usize,
    most: usize,
) -> Result<[f64; MOST_NUMBERS], Fault> {
    let mut numbers = [0.0; MOST_NUMBERS];
    for found in 0..most {
        match cursor.number()? {
            Some(number) => numbers[found] = number,
            None if found < least => {
                return Err(cursor.fault(MeshProblem::TooFewNumbers { what, least, found }));
            }
            None => return Ok(numbers),
        }
    }
    cursor.expect_line_end()?;
    Ok(numbers)
}

/// The rest of a line: names may have spaces.
fn name(cursor: &mut Cursor) -> String {
    let line = if cursor.line_ends() { &[][..] } else { cursor.rest() };
    let end = line.iter().position(|&b| b == b'\n').unwrap_or(line.len());
    String::from_utf8_lossy(line[..end].trim_ascii()).into_owned()
}

/// A polygon as a fan around its first corner.
fn face(cursor: &mut Cursor, known: Counts, part: &mut Part) -> Result<(), Fault> {
    let (mut first, mut previous) = (None, None);
    let mut count = 0;
    while !cursor.line_ends() {
        let corner = corner(cursor, known, &mut part.furthest)?;
        if let (Some(first), Some(previous)) = (first, previous) {
            part.triangles.push([first, previous, corner]);
        }
        previous = first.map(|_| corner);
        first = first.or(Some(corner));
        count += 1;
    }
    if count < 3 {
        return Err(cursor.fault(MeshProblem::TooFewCorners { count }));
    }
    part.polygons.push(count as usize);
    Ok(())
}

/// The corner at the cursor: `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn corner(
    cursor: &mut Cursor,
    known: Counts,
    furthest: &mut [Option<Reference>; 3],
) -> Result<Corner, Fault> {
    let text = cursor.rest();
    let mut indices = [None; 3];
    let mut rest = text;
    for (attribute, index) in indices.iter_mut().enumerate() {
        // The texture coordinate of `v//vn`.
        if attribute != 1 || !rest.starts_with(b"/") {
            let (value, after) = parse_integer(rest);
            let Some(value) = value else { break };
            *index = Some(resolve(cursor, attribute, value, known, &mut furthest[attribute])?);
            rest = after;
        }
        match rest {
            _ if index.is_some() && ends_word(rest) => {
                cursor.advance(text.len() - rest.len());
                let [vertex, uv, normal] = indices;
                // The first attribute is never left out.
                return Ok(Corner { vertex: vertex.unwrap_or_default(), uv, normal });
            }
            [b'/', after @ ..] if attribute < 2 => rest = after,
            _ => break,
        }
    }
    let found = excerpt(cursor.word());
    Err(cursor.fault(MeshProblem::NotACorner { found }))
}

/// An index that counts from 0.
fn resolve(
    cursor: &Cursor,
    attribute: usize,
    index: i64,
    known: Counts,
    furthest: &mut Option<Reference>,
) -> Result<u32, Fault> {
    let count = known.0[attribute];
    let distance = index.unsigned_abs();
    if index == 0 {
        return Err(cursor.fault(MeshProblem::IndexZero));
    }
    if distance > count {
        let (line, column) = cursor.line_and_column();
        let reference = Reference { attribute, index, line, column };
        if index < 0 {
            reference.check(count)?;
        }
        Reference::keep_larger(furthest, Some(reference));
    }
    let from_zero = if index > 0 { distance - 1 } else { count - distance };
    // Indices that do not fit are beyond what any mesh can hold, and so is this one.
    Ok(u32::try_from(from_zero).unwrap_or(u32::MAX - 1))
}
