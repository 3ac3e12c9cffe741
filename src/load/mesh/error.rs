//! What can be wrong with a mesh file, and where.

use std::fmt;
use std::io::{self, BufRead, Read};
use std::path::{Path, PathBuf};

use super::source::{Source, Unpacked};
use crate::memory::{Limits, OutOfMemory, readable};
use crate::shape::mesh::MeshError;

/// Longest piece of a file that an error shows, in bytes.
const LONGEST_EXCERPT: usize = 120;

/// A mesh file that could not be loaded: which file, where in it, what is wrong, what would be right.
#[derive(Debug, thiserror::Error)]
#[error("{}{place}: {problem}", .path.display())]
pub struct MeshFileError {
    path: PathBuf,
    place: Place,
    source_line: Option<String>,
    problem: Box<MeshProblem>,
}

impl MeshFileError {
    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What is wrong.
    #[must_use]
    pub fn problem(&self) -> &MeshProblem {
        &self.problem
    }

    /// The line of a text file, from 1.
    #[must_use]
    pub fn line(&self) -> Option<u64> {
        match self.place {
            Place::Line { line, .. } => Some(line),
            Place::File | Place::Record { .. } | Place::Byte { .. } | Place::Data { .. } => None,
        }
    }

    /// The column in that line, in bytes from 1.
    #[must_use]
    pub fn column(&self) -> Option<u64> {
        match self.place {
            Place::Line { column, .. } => Some(column),
            Place::File | Place::Record { .. } | Place::Byte { .. } | Place::Data { .. } => None,
        }
    }

    /// How many bytes of a binary file, or of a mesh in it (once decompressed), come before the offending
    /// value.
    #[must_use]
    pub fn byte_offset(&self) -> Option<u64> {
        match self.place {
            Place::Record { offset, .. } | Place::Byte { offset } | Place::Data { offset, .. } => {
                Some(offset)
            }
            Place::File | Place::Line { .. } => None,
        }
    }

    /// The offending line of a text file, cut off where it is long.
    #[must_use]
    pub fn source_line(&self) -> Option<&str> {
        self.source_line.as_deref()
    }
}

/// What is wrong with a mesh file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshProblem {
    /// The operating system or the decompression failed.
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    /// A line so long that this cannot be a mesh.
    #[error("a line of more than {limit} bytes (is this a text file?)")]
    LongLine {
        /// The longest line that is read.
        limit: usize,
    },
    /// Something else where a number should be.
    #[error("expected a number, found `{found}`")]
    NotANumber {
        /// The word in the file.
        found: String,
    },
    /// Something else where a whole number should be.
    #[error("expected a whole number, found `{found}`")]
    NotAnInteger {
        /// The word in the file.
        found: String,
    },
    /// A line that ends too early.
    #[error("{what} needs at least {least} numbers, but the line has {found}")]
    TooFewNumbers {
        /// What the line describes.
        what: &'static str,
        /// How many it needs.
        least: usize,
        /// How many there are.
        found: usize,
    },
    /// A record that ends too early.
    #[error("a value is missing at the end of the record")]
    MissingValue,
    /// A line that goes on too long.
    #[error("expected the end of the line, found `{found}`")]
    TrailingWord {
        /// The first word too many.
        found: String,
    },
    /// Text in an encoding that is not read.
    #[error("is text in UTF-16 (expected UTF-8: save it in that encoding)")]
    Utf16,
    /// A keyword that OBJ files do not have.
    #[error(
        "unknown keyword `{keyword}` (expected v, vt, vn or f; o, g, s and what is no polygon are ignored)"
    )]
    UnknownKeyword {
        /// The word in the file.
        keyword: String,
    },
    /// A corner of a face that is not written like one.
    #[error("expected a corner such as 3, 3/1, 3//2 or 3/1/2, found `{found}`")]
    NotACorner {
        /// The word in the file.
        found: String,
    },
    /// An index 0 in an OBJ file.
    #[error("index 0 (indices count from 1 forwards or from -1 backwards)")]
    IndexZero,
    /// An index that refers to nothing.
    #[error("{attribute} {index} is out of range (there are {count})")]
    IndexOutOfRange {
        /// What the index refers to.
        attribute: &'static str,
        /// The index as the file has it.
        index: i64,
        /// How many there are to refer to.
        count: u64,
    },
    /// A face that is not even a triangle.
    #[error("a face needs at least 3 vertices, but this has {count}")]
    TooFewCorners {
        /// How many it has.
        count: i64,
    },
    /// A file of vertices alone.
    #[error("has no faces{}", only_points(*.vertices))]
    NoFaces {
        /// How many vertices there are.
        vertices: usize,
    },
    /// A list of texture coordinates that does not suit its face.
    #[error(
        "a list of {found} texture coordinates for {corners} corners (expected {expected}, or 0)"
    )]
    TextureCoordinateCount {
        /// How many numbers there are.
        found: usize,
        /// Corners of the face.
        corners: usize,
        /// Two for each corner.
        expected: usize,
    },
    /// A list with fewer than no entries.
    #[error("a list of {count} entries (expected 0 or more)")]
    NegativeCount {
        /// How many are declared.
        count: i64,
    },
    /// A keyword that STL files do not have.
    #[error(
        "unknown keyword `{keyword}` (expected solid, facet, outer loop, vertex, endloop, endfacet or endsolid)"
    )]
    UnknownStlKeyword {
        /// The word in the file.
        keyword: String,
    },
    /// Not an STL file at all.
    #[error(
        "not an STL file (one is text that begins with `solid`, or has 84 bytes before its facets)"
    )]
    NotStl,
    /// Not a PLY file at all.
    #[error("not a PLY file (the first line of one is `ply`)")]
    NotPly,
    /// Not a mesh in Mitsuba's format.
    #[error("not a serialized mesh (one starts with the bytes 1c 04)")]
    NotSerialized,
    /// Another version of Mitsuba's format.
    #[error("version {version} of the format is not read (expected {expected})")]
    SerializedVersion {
        /// What the file says.
        version: u16,
        /// What would be right.
        expected: &'static str,
    },
    /// An index of a mesh that the file does not have.
    #[error("there is no mesh {index}: the file has {count}, counted from 0")]
    NoSuchMesh {
        /// Which mesh was asked for.
        index: u32,
        /// How many the file has.
        count: u32,
    },
    /// A list of offsets that leads out of the file.
    #[error("{0}")]
    Dictionary(String),
    /// A header line that is not understood.
    #[error("expected {expected}, found `{found}`")]
    HeaderLine {
        /// What would be right.
        expected: &'static str,
        /// The line or word in the file.
        found: String,
    },
    /// A header that promises what cannot be rendered or lacks what is needed.
    #[error("{0}")]
    Header(String),
    /// A file with less in it than its header says.
    #[error("the file ends after {found} of {count} records of the element `{element}`")]
    Truncated {
        /// The element that is incomplete.
        element: String,
        /// How many the header declares.
        count: u64,
        /// How many were complete.
        found: u64,
    },
    /// A file with more in it than its header says.
    #[error("the file goes on after the last element that its header declares")]
    TrailingData,
    /// A compressed file that holds more than it may.
    #[error("a compressed file of {} unpacks to more than {}", readable(*.stored), readable(*.limit))]
    Unpacked {
        /// Bytes of the file.
        stored: u64,
        /// Bytes that it may unpack to.
        limit: u64,
    },
    /// More than there is memory for.
    #[error(transparent)]
    Memory(#[from] OutOfMemory),
    /// More than a mesh can hold.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// Where in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// The file as a whole.
    File,
    /// A place in a text; both count from 1.
    Line { line: u64, column: u64 },
    /// A place in binary data; `number` counts from 0, as indices do.
    Record { offset: u64, element: String, number: u64 },
    /// A place in a binary file as it is stored.
    Byte { offset: u64 },
    /// A place in the data, once decompressed, of one of a file's meshes; in the header if in no record.
    /// All numbers count from 0.
    Data { mesh: u32, offset: u64, record: Option<(&'static str, u64)> },
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line { line, column } => write!(f, ":{line}:{column}"),
            Self::Record { offset, element, number } => {
                write!(f, ": byte {offset} ({element} {number})")
            }
            Self::Byte { offset } => write!(f, ": byte {offset}"),
            Self::Data { mesh, offset, record } => {
                write!(f, ": mesh {mesh}: byte {offset}")?;
                match record {
                    Some((name, number)) => write!(f, " ({name} {number})"),
                    None => Ok(()),
                }
            }
        }
    }
}

/// A problem and its place, before it is said in which file.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) place: Place,
    pub(super) problem: Box<MeshProblem>,
}

impl Fault {
    pub(super) fn new(place: Place, problem: MeshProblem) -> Self {
        Self { place, problem: Box::new(problem) }
    }

    /// The error to hand out. Reads the offending line from the file once more, so that nobody has
    /// to keep lines in case they are needed.
    pub(super) fn in_file(self, path: &Path) -> MeshFileError {
        let source_line = match self.place {
            Place::Line { line, .. } => read_line(path, line).ok(),
            Place::File | Place::Record { .. } | Place::Byte { .. } | Place::Data { .. } => None,
        };
        MeshFileError { path: path.into(), place: self.place, source_line, problem: self.problem }
    }
}

impl From<MeshProblem> for Fault {
    fn from(problem: MeshProblem) -> Self {
        Self::new(Place::File, problem)
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        match error.get_ref().and_then(|inner| inner.downcast_ref()) {
            Some(&Unpacked { stored, limit }) => MeshProblem::Unpacked { stored, limit }.into(),
            None => MeshProblem::from(error).into(),
        }
    }
}

impl From<MeshError> for Fault {
    fn from(error: MeshError) -> Self {
        MeshProblem::from(error).into()
    }
}

/// Bytes of a file as an error shows them: readable, and cut off where they are long.
pub(super) fn excerpt(bytes: &[u8]) -> String {
    let shown = &bytes[..bytes.len().min(LONGEST_EXCERPT)];
    let mut text = visible(String::from_utf8_lossy(shown).trim_end());
    if shown.len() < bytes.len() {
        text.push('…');
    }
    text
}

/// Text with escapes for what cannot be seen, such as byte order marks in the middle of a file.
fn visible(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\t' => shown.push(c),
            '\u{a0}'
            | '\u{ad}'
            | '\u{200b}'..='\u{200f}'
            | '\u{2028}'..='\u{202e}'
            | '\u{2060}'
            | '\u{feff}' => shown.extend(c.escape_unicode()),
            _ if c.is_control() => shown.extend(c.escape_default()),
            _ => shown.push(c),
        }
    }
    shown
}

fn read_line(path: &Path, line: u64) -> Result<String, Fault> {
    let mut source = Source::text(path, &Limits::default())?;
    for _ in 1..line {
        source.reader.skip_until(b'\n')?;
    }
    let mut bytes = Vec::new();
    source.reader.take(LONGEST_EXCERPT as u64 + 1).read_until(b'\n', &mut bytes)?;
    Ok(excerpt(&bytes))
}

/// What a file without faces has.
fn only_points(count: usize) -> String {
    match count {
        0 => " and no points".to_owned(),
        _ => format!(
            ", only {count} points (expected polygons: a cloud of points has no surface until a program such as \
             MeshLab makes one of it)"
        ),
    }
}
