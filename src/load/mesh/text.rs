//! Text in blocks of whole lines, parsed by all threads.
//!
//! A block is cut into parts. All parts are first counted, so that each knows how many lines (and
//! vertices, ...) come before it, then parsed side by side, then taken in the order of the file
//! while another thread already reads the next block.

use std::io::Read;
use std::mem;

use rayon::prelude::*;

use super::error::{Fault, MeshProblem, Place, excerpt};
use super::source::Source;

/// Bytes that are read at once. Large enough to occupy a few dozen threads, small beside a mesh that
/// takes long to load.
const BLOCK: usize = 2 << 20;
/// Bytes that one thread parses at once.
const PART: usize = 64 << 10;
/// A file with a longer line is no mesh; there must be a limit, or it would be read into memory.
const LONGEST_LINE: usize = 32 << 20;

/// A text format that can be parsed in parts.
pub(super) trait TextFormat: Sync {
    /// How much of what comes before a part its parsing depends on.
    type Count: Copy + Send + Sync + std::ops::AddAssign;
    /// What a part holds.
    type Part: Send;

    /// Counts what a part holds.
    fn count(&self, part: &mut Cursor) -> Self::Count;
    /// Parses a part that begins after `before`.
    fn parse(&self, part: &mut Cursor, before: Self::Count) -> Result<Self::Part, Fault>;
    /// Adds the next part to the whole.
    fn take(&mut self, part: Self::Part) -> Result<(), Fault>;
}

/// Reads the rest of a file, whose next line is number `line`; `count` is what came before. Returns
/// both at the end of the file.
pub(super) fn read<F: TextFormat + Send>(
    source: &mut Source,
    format: &mut F,
    mut line: u64,
    mut count: F::Count,
) -> Result<(u64, F::Count), Fault> {
    let mut blocks = Blocks { source, rest: Vec::new() };
    let mut block = blocks.next()?;
    while !block.is_empty() {
        let (next, done) =
            rayon::join(|| blocks.next(), || read_block(&block, format, &mut line, &mut count));
        done?;
        block = next?;
    }
    Ok((line, count))
}

fn read_block<F: TextFormat + Send>(
    block: &[u8],
    format: &mut F,
    line: &mut u64,
    count: &mut F::Count,
) -> Result<(), Fault> {
    let parts = split(block);
    let counts: Vec<_> = parts
        .par_iter()
        .map(|part| {
            let mut cursor = Cursor::new(part, 0);
            let count = format.count(&mut cursor);
            (cursor.line, count)
        })
        .collect();
    let mut before = Vec::with_capacity(parts.len());
    for (lines, counted) in counts {
        before.push((*line, *count));
        *line += lines;
        *count += counted;
    }
    let parsed: Vec<_> = parts
        .par_iter()
        .zip(before)
        .map(|(part, (line, count))| format.parse(&mut Cursor::new(part, line), count))
        .collect();
    parsed.into_iter().try_for_each(|part| format.take(part?))
}

/// Cuts a block into parts of whole lines.
fn split(block: &[u8]) -> Vec<&[u8]> {
    let mut parts = Vec::with_capacity(block.len() / PART + 1);
    let mut rest = block;
    while rest.len() > PART {
        let Some(end) = (PART..rest.len()).find(|&i| ends_line(rest, i)) else {
            break;
        };
        let (part, after) = rest.split_at(end + 1);
        parts.push(part);
        rest = after;
    }
    parts.push(rest);
    parts
}

/// Whether a line that is not continued ends with the byte at `i`.
fn ends_line(text: &[u8], i: usize) -> bool {
    text[i] == b'\n' && !text[..i].ends_with(b"\\") && !text[..i].ends_with(b"\\\r")
}

/// Whether a word is over, if this text follows.
pub(super) fn ends_word(text: &[u8]) -> bool {
    match text {
        [] => true,
        [b'\\', after @ ..] => after.starts_with(b"\n") || after.starts_with(b"\r\n"),
        [byte, ..] => byte.is_ascii_whitespace(),
    }
}

/// Blocks of whole lines.
struct Blocks<'a> {
    source: &'a mut Source,
    /// The beginning of a line whose end was not in the last block.
    rest: Vec<u8>,
}

impl Blocks<'_> {
    /// The next block; nothing at the end of the file.
    fn next(&mut self) -> Result<Vec<u8>, Fault> {
        let mut block = mem::take(&mut self.rest);
        loop {
            block.reserve(BLOCK);
            let read = (&mut self.source.reader).take(BLOCK as u64).read_to_end(&mut block)?;
            if read == 0 {
                return Ok(block);
            }
            if let Some(end) = (0..block.len()).rev().find(|&i| ends_line(&block, i)) {
                self.rest = block.split_off(end + 1);
                return Ok(block);
            }
            if block.len() > LONGEST_LINE {
                return Err(MeshProblem::LongLine { limit: LONGEST_LINE }.into());
            }
        }
    }
}

/// A place in a text that reads word by word and does not leave its line by itself.
///
/// A `#` ends the line, and a backslash at its end continues it: OBJ asks for both, and PLY has
/// neither in its numbers.
pub(super) struct Cursor<'a> {
    text: &'a [u8],
    at: usize,
    /// How many lines were left behind, in the file.
    line: u64,
    line_start: usize,
}

impl<'a> Cursor<'a> {
    /// At the beginning of a text, which has so many lines before it.
    pub(super) fn new(text: &'a [u8], lines_before: u64) -> Self {
        Self { text, at: 0, line: lines_before, line_start: 0 }
    }

    /// Goes to the next line with a word in it, unless this one has. False at the end of the text.
    pub(super) fn find_word(&mut self) -> bool {
        while self.at < self.text.len() {
            if !self.line_ends() {
                return true;
            }
            self.next_line();
        }
        false
    }

    /// Goes to the beginning of the next line.
    pub(super) fn next_line(&mut self) {
        while let Some(skipped) = self.text[self.at..].iter().position(|&b| b == b'\n') {
            let (start, end) = (self.at, self.at + skipped);
            self.enter_line(end + 1);
            // The backslash at the end of a comment continues nothing: it may end a path.
            if ends_line(self.text, end) || self.text[start..end].contains(&b'#') {
                return;
            }
        }
        self.at = self.text.len();
    }

    /// Whether there is no further word in the line.
    pub(super) fn line_ends(&mut self) -> bool {
        loop {
            match self.text[self.at..] {
                [b' ' | b'\t' | b'\r' | b'\x0c', ..] => self.at += 1,
                [b'\\', b'\n', ..] => self.enter_line(self.at + 2),
                [b'\\', b'\r', b'\n', ..] => self.enter_line(self.at + 3),
                [] | [b'\n' | b'#', ..] => return true,
                _ => return false,
            }
        }
    }

    /// The next word of the line, or nothing.
    pub(super) fn word(&mut self) -> &'a [u8] {
        if self.line_ends() {
            return &[];
        }
        let rest = &self.text[self.at..];
        let length = (1..rest.len()).find(|&i| ends_word(&rest[i..])).unwrap_or(rest.len());
        self.at += length;
        &rest[..length]
    }

    /// The next number of the line; nothing at its end.
    pub(super) fn number(&mut self) -> Result<Option<f64>, Fault> {
        if self.line_ends() {
            return Ok(None);
        }
        let rest = &self.text[self.at..];
        match fast_float2::parse_partial::<f64, _>(rest) {
            Ok((value, length)) if ends_word(&rest[length..]) => {
                self.at += length;
                Ok(Some(value))
            }
            _ => {
                let found = excerpt(self.word());
                Err(self.fault(MeshProblem::NotANumber { found }))
            }
        }
    }

    /// The next whole number of the line; nothing at its end.
    pub(super) fn integer(&mut self) -> Result<Option<i64>, Fault> {
        if self.line_ends() {
            return Ok(None);
        }
        let rest = &self.text[self.at..];
        match parse_integer(rest) {
            (Some(value), after) if ends_word(after) => {
                self.at += rest.len() - after.len();
                Ok(Some(value))
            }
            _ => {
                let found = excerpt(self.word());
                Err(self.fault(MeshProblem::NotAnInteger { found }))
            }
        }
    }

    /// The text from here on.
    pub(super) fn rest(&self) -> &'a [u8] {
        &self.text[self.at..]
    }

    /// Goes on by so many bytes of the line.
    pub(super) fn advance(&mut self, bytes: usize) {
        self.at += bytes;
    }

    /// An error unless the line ends here.
    pub(super) fn expect_line_end(&mut self) -> Result<(), Fault> {
        match self.word() {
            [] => Ok(()),
            word => Err(self.fault(MeshProblem::TrailingWord { found: excerpt(word) })),
        }
    }

    /// A problem with the word that was read last, or is about to be read.
    pub(super) fn fault(&self, problem: MeshProblem) -> Fault {
        let (line, column) = self.line_and_column();
        Fault::new(Place::Line { line, column }, problem)
    }

    /// Where that word begins, both from 1.
    pub(super) fn line_and_column(&self) -> (u64, u64) {
        let before = &self.text[self.line_start..self.at];
        let start = before.iter().rposition(u8::is_ascii_whitespace).map_or(0, |i| i + 1);
        (self.line + 1, start as u64 + 1)
    }

    fn enter_line(&mut self, start: usize) {
        self.at = start;
        self.line_start = start;
        self.line += 1;
    }
}

/// A whole number at the beginning of a text, if there is one that fits, and what comes behind it.
pub(super) fn parse_integer(text: &[u8]) -> (Option<i64>, &[u8]) {
    let (negative, digits) = match text {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    let length = digits.iter().position(|b| !b.is_ascii_digit()).unwrap_or(digits.len());
    let (digits, rest) = digits.split_at(length);
    // 18 digits fit; more do not name anything in a file.
    if digits.is_empty() || digits.len() > 18 {
        return (None, rest);
    }
    let value = digits.iter().fold(0, |value, digit| value * 10 + i64::from(digit - b'0'));
    (Some(if negative { -value } else { value }), rest)
}
