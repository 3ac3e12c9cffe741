//! PLY data as text: one record a line.

use super::super::error::{Fault, MeshProblem, Place};
use super::super::source::Source;
use super::super::text::{self, Cursor, TextFormat};
use super::header::Scalar;
use super::record::{Content, Records, Values};

/// Reads all records; the header has so many lines.
pub(super) fn read(
    source: &mut Source,
    header_lines: u64,
    records: &Records,
    content: &mut Content,
) -> Result<(), Fault> {
    let mut format = Ascii { records, content };
    let (lines, mut found) = text::read(source, &mut format, header_lines, 0)?;
    for element in records.elements() {
        if found < element.count {
            let place = Place::Line { line: lines, column: 1 };
            let (element, count) = (element.name.clone(), element.count);
            return Err(Fault::new(place, MeshProblem::Truncated { element, count, found }));
        }
        found -= element.count;
    }
    Ok(())
}

struct Ascii<'a> {
    records: &'a Records<'a>,
    content: &'a mut Content,
}

impl TextFormat for Ascii<'_> {
    /// Records.
    type Count = u64;
    type Part = Content;

    fn count(&self, part: &mut Cursor) -> u64 {
        let mut records = 0;
        while part.find_word() {
            records += 1;
            part.next_line();
        }
        records
    }

    fn parse(&self, part: &mut Cursor, mut before: u64) -> Result<Content, Fault> {
        let mut out = Content::default();
        for (index, element) in self.records.elements().enumerate() {
            while before < element.count {
                if !part.find_word() {
                    return Ok(out);
                }
                self.records.read(index, part, &mut out)?;
                part.expect_line_end()?;
                part.next_line();
                before += 1;
            }
            before -= element.count;
        }
        if part.find_word() {
            return Err(part.fault(MeshProblem::TrailingData));
        }
        Ok(out)
    }

    fn take(&mut self, part: Content) -> Result<(), Fault> {
        self.content.append(&part);
        Ok(())
    }
}

impl Values for Cursor<'_> {
    fn number(&mut self, _: Scalar) -> Result<f64, Fault> {
        Cursor::number(self)?.ok_or_else(|| self.fault(MeshProblem::MissingValue))
    }

    fn integer(&mut self, _: Scalar) -> Result<i64, Fault> {
        Cursor::integer(self)?.ok_or_else(|| self.fault(MeshProblem::MissingValue))
    }

    fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), Fault> {
        (0..count).try_for_each(|_| Values::number(self, scalar).map(drop))
    }

    fn fault(&self, problem: MeshProblem) -> Fault {
        Cursor::fault(self, problem)
    }
}
