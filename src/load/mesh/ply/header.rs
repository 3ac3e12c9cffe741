//! The header of a PLY file: lines of text, whatever encoding the data has.

use std::io::{BufRead, Read};
use std::str::SplitAsciiWhitespace;

use super::super::error::{Fault, MeshProblem, Place, excerpt};

/// A longer header, in bytes, is none: what follows may be anything.
const LONGEST_HEADER: u64 = 1 << 20;

/// How the data is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Binary { big_endian: bool },
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    const EXPECTED: &str = "a type (char, uchar, short, ushort, int, uint, float, double, int8 to \
                            uint32, float32, float64)";

    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes that it takes in binary data.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// What a property holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

/// A value, or a list of values, of each record of an element.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
}

/// A table of the file.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    /// Which line of the header declares it, from 1.
    pub(super) line: u64,
}

/// A PLY header.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    /// In the order of the data.
    pub(super) elements: Vec<Element>,
    /// How many lines the header has.
    pub(super) lines: u64,
    /// How many bytes the header has.
    pub(super) bytes: u64,
}

impl Header {
    /// Reads up to the end of the line `end_header`.
    pub(super) fn read(reader: &mut impl BufRead) -> Result<Self, Fault> {
        let mut lines = Lines { reader: reader.take(LONGEST_HEADER), text: Vec::new(), number: 0 };
        if !lines.next()? || lines.text.trim_ascii_end() != b"ply" {
            return Err(Fault::new(Place::Line { line: 1, column: 1 }, MeshProblem::NotPly));
        }
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        while lines.next()? {
            let text = String::from_utf8_lossy(&lines.text);
            let mut words = text.split_ascii_whitespace();
            match words.next() {
                None | Some("comment" | "obj_info") => {}
                Some("format") => encoding = Some(lines.encoding(&mut words)?),
                Some("element") => elements.push(lines.element(&mut words)?),
                Some("property") => {
                    let property = lines.property(&mut words)?;
                    let Some(element) = elements.last_mut() else {
                        return Err(lines.fault("an `element` before the first `property`"));
                    };
                    element.properties.push(property);
                }
                Some("end_header") => {
                    let Some(encoding) = encoding else {
                        return Err(lines.fault("a line `format` before the end of the header"));
                    };
                    let bytes = LONGEST_HEADER - lines.reader.limit();
                    return Ok(Self { encoding, elements, lines: lines.number, bytes });
                }
                Some(_) => {
                    return Err(
                        lines.fault("comment, obj_info, format, element, property or end_header")
                    );
                }
            }
        }
        Err(lines.fault("the line `end_header`"))
    }
}

/// The lines of a header.
struct Lines<R> {
    reader: R,
    text: Vec<u8>,
    number: u64,
}

impl<R: BufRead> Lines<R> {
    /// Goes to the next line; false at the end of the file.
    fn next(&mut self) -> Result<bool, Fault> {
        self.text.clear();
        self.number += 1;
        Ok(self.reader.read_until(b'\n', &mut self.text)? > 0)
    }

    fn encoding(&self, words: &mut SplitAsciiWhitespace) -> Result<Encoding, Fault> {
        match (words.next(), words.next()) {
            (Some("ascii"), Some("1.0")) => Ok(Encoding::Ascii),
            (Some("binary_little_endian"), Some("1.0")) => {
                Ok(Encoding::Binary { big_endian: false })
            }
            (Some("binary_big_endian"), Some("1.0")) => Ok(Encoding::Binary { big_endian: true }),
            _ => {
                Err(self
                    .fault("format ascii 1.0, binary_little_endian 1.0 or binary_big_endian 1.0"))
            }
        }
    }

    fn element(&self, words: &mut SplitAsciiWhitespace) -> Result<Element, Fault> {
        let (Some(name), Some(Ok(count))) = (words.next(), words.next().map(str::parse)) else {
            return Err(self.fault("element, a name and the number of its records"));
        };
        Ok(Element { name: name.into(), count, properties: Vec::new(), line: self.number })
    }

    fn property(&self, words: &mut SplitAsciiWhitespace) -> Result<Property, Fault> {
        let scalar = |words: &mut SplitAsciiWhitespace| {
            let word = words.next();
            if word == Some("list") {
                return Ok(None);
            }
            let scalar = word.and_then(Scalar::named);
            scalar.map(Some).ok_or_else(|| self.fault(Scalar::EXPECTED))
        };
        let kind = match scalar(words)? {
            Some(scalar) => Kind::Scalar(scalar),
            None => match (scalar(words)?, scalar(words)?) {
                (Some(count), Some(item)) if count.is_integer() => Kind::List { count, item },
                _ => return Err(self.fault("a list whose count is of an integer type")),
            },
        };
        match words.next() {
            Some(name) => Ok(Property { name: name.into(), kind }),
            None => Err(self.fault("the property's name behind its type")),
        }
    }

    /// The line is not what was expected.
    fn fault(&self, expected: &'static str) -> Fault {
        let found = match excerpt(&self.text) {
            text if text.is_empty() => "the end of the file".into(),
            text => text,
        };
        let place = Place::Line { line: self.number, column: 1 };
        Fault::new(place, MeshProblem::HeaderLine { expected, found })
    }
}
