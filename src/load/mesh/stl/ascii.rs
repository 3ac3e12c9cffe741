//! STL as text: `facet normal`, `outer loop`, three times `vertex`, `endloop`, `endfacet`.

use glam::{DVec3, Vec3A};

use super::super::buffers::Placement;
use super::super::error::{Fault, MeshProblem, Place, excerpt};
use super::super::source::Source;
use super::super::text::{self, Cursor, TextFormat};

/// A facet takes at least so many bytes of text.
const FACET: u64 = 64;

/// The corners of all triangles.
pub(super) fn read(source: &mut Source, placement: &Placement) -> Result<Vec<Vec3A>, Fault> {
    super::claim(source, source.stored() / FACET)?;
    let mut stl = Stl { placement, corners: Vec::new(), open: Vec::new(), facets: 0 };
    text::read(source, &mut stl, 0, 0)?;
    if !stl.open.is_empty() {
        let (element, found) = ("facet".to_owned(), stl.facets);
        return Err(MeshProblem::Truncated { element, count: found + 1, found }.into());
    }
    Ok(stl.corners)
}

struct Stl<'a> {
    placement: &'a Placement,
    corners: Vec<Vec3A>,
    /// Points of the facet that has not ended yet.
    open: Vec<Vec3A>,
    facets: u64,
}

/// What a part of a file holds.
#[derive(Debug, Default)]
struct Part {
    points: Vec<Vec3A>,
    ends: Vec<End>,
}

/// The end of a facet.
#[derive(Debug)]
struct End {
    /// How many of the part's points come before it.
    points: usize,
    line: u64,
    column: u64,
}

/// More corners than any program writes.
const MOST_CORNERS: usize = 1000;

impl TextFormat for Stl<'_> {
    type Count = u64;
    type Part = Part;

    fn count(&self, part: &mut Cursor) -> u64 {
        while part.find_word() {
            part.next_line();
        }
        0
    }

    fn parse(&self, cursor: &mut Cursor, _before: u64) -> Result<Part, Fault> {
        let mut part = Part::default();
        while cursor.find_word() {
            let word = cursor.word();
            let is = |keyword: &[u8]| word.eq_ignore_ascii_case(keyword);
            if is(b"vertex") {
                part.points.push(self.placement.position(point(cursor)?));
                cursor.expect_line_end()?;
            } else if is(b"endloop") {
                let (line, column) = cursor.line_and_column();
                part.ends.push(End { points: part.points.len(), line, column });
            } else if ![&b"facet"[..], b"outer", b"endfacet", b"solid", b"endsolid"]
                .into_iter()
                .any(is)
            {
                let keyword = excerpt(word);
                return Err(cursor.fault(MeshProblem::UnknownStlKeyword { keyword }));
            }
            // Names may be anything, and normals of facets say nothing new.
            cursor.next_line();
        }
        Ok(part)
    }

    fn take(&mut self, part: Part) -> Result<(), Fault> {
        let mut start = 0;
        for End { points, line, column } in part.ends {
            self.open.extend_from_slice(&part.points[start..points]);
            start = points;
            let [first, rest @ ..] = self.open.as_slice() else {
                return Err(too_few(0, line, column));
            };
            if rest.len() < 2 {
                return Err(too_few(rest.len() + 1, line, column));
            }
            // Some programs write polygons; they are convex.
            for pair in rest.windows(2) {
                self.corners.extend([*first, pair[0], pair[1]]);
            }
            super::check_count(self.corners.len())?;
            self.open.clear();
            self.facets += 1;
        }
        self.open.extend_from_slice(&part.points[start..]);
        if self.open.len() > MOST_CORNERS {
            let message = format!(
                "a facet of more than {MOST_CORNERS} vertices (expected `endloop` after 3)"
            );
            return Err(MeshProblem::Header(message).into());
        }
        Ok(())
    }
}

fn too_few(count: usize, line: u64, column: u64) -> Fault {
    let problem = MeshProblem::TooFewCorners { count: count as i64 };
    Fault::new(Place::Line { line, column }, problem)
}

fn point(cursor: &mut Cursor) -> Result<DVec3, Fault> {
    let mut numbers = [0.0; 3];
    for (found, number) in numbers.iter_mut().enumerate() {
        let Some(value) = cursor.number()? else {
            let (what, least) = ("a vertex", 3);
            return Err(cursor.fault(MeshProblem::TooFewNumbers { what, least, found }));
        };
        *number = value;
    }
    Ok(numbers.into())
}
