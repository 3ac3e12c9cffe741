//! PLY data as bytes.

use std::io::Read;

use super::super::buffers::Buffers;
use super::super::error::{Fault, MeshProblem, Place};
use super::super::source::Source;
use super::header::Scalar;
use super::record::{Records, Values};

/// Bytes that are read at once.
const BLOCK: usize = 1 << 20;

/// Reads all records; the header has so many bytes.
pub(super) fn read(
    source: Source,
    header_bytes: u64,
    big_endian: bool,
    records: &Records,
    buffers: &mut Buffers,
) -> Result<(), Fault> {
    let mut bytes =
        Bytes { source, big_endian, block: Vec::new(), at: 0, last: 0, before: header_bytes };
    for (index, element) in records.elements().enumerate() {
        for number in 0..element.count {
            records.read(index, &mut bytes, buffers).map_err(|fault| {
                let (offset, problem) = match *fault.problem {
                    MeshProblem::MissingValue => {
                        let (element, count) = (element.name.clone(), element.count);
                        let found = number;
                        (bytes.end(), MeshProblem::Truncated { element, count, found })
                    }
                    problem => (bytes.last, problem),
                };
                let element = element.name.clone();
                Fault::new(Place::Record { offset, element, number }, problem)
            })?;
        }
    }
    if bytes.remaining(1)? { Err(MeshProblem::TrailingData.into()) } else { Ok(()) }
}

/// Values from a block of bytes that is refilled when it runs out.
struct Bytes {
    source: Source,
    big_endian: bool,
    block: Vec<u8>,
    at: usize,
    /// How many bytes of the file came before the last value.
    last: u64,
    /// How many bytes of the file came before the block.
    before: u64,
}

impl Bytes {
    /// Whether so many more bytes (at most a block) are there; reads on where needed.
    fn remaining(&mut self, count: usize) -> Result<bool, Fault> {
        if self.block.len() - self.at < count {
            self.block.drain(..self.at);
            self.before += self.at as u64;
            self.at = 0;
            let room = (BLOCK - self.block.len()) as u64;
            (&mut self.source.reader).take(room).read_to_end(&mut self.block)?;
        }
        Ok(self.block.len() >= self.at + count)
    }

    /// The next bytes, the least significant first.
    #[inline]
    fn next<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let mut bytes = match self.block[self.at..].first_chunk() {
            Some(bytes) => *bytes,
            None => self.next_in_file()?,
        };
        self.last = self.before + self.at as u64;
        self.at += N;
        if self.big_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// The bytes at `at`, where the block does not hold all of them.
    #[cold]
    fn next_in_file<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        self.remaining(N)?;
        let bytes = self.block[self.at..].first_chunk();
        bytes.copied().ok_or_else(|| MeshProblem::MissingValue.into())
    }

    /// How many bytes of the file were read.
    fn end(&self) -> u64 {
        self.before + self.block.len() as u64
    }
}

impl Values for Bytes {
    fn number(&mut self, scalar: Scalar) -> Result<f64, Fault> {
        Ok(match scalar {
            Scalar::F32 => f32::from_le_bytes(self.next()?).into(),
            Scalar::F64 => f64::from_le_bytes(self.next()?),
            // At most 32 bits, so this is exact.
            integer => self.integer(integer)? as f64,
        })
    }

    fn integer(&mut self, scalar: Scalar) -> Result<i64, Fault> {
        Ok(match scalar {
            Scalar::I8 => i8::from_le_bytes(self.next()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.next()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.next()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.next()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.next()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.next()?).into(),
            // Not asked for: the header was checked. Saturates and maps NaN to 0.
            Scalar::F32 | Scalar::F64 => self.number(scalar)? as i64,
        })
    }

    fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), Fault> {
        let mut bytes = count * scalar.size() as u64;
        while bytes > 0 {
            if !self.remaining(1)? {
                return Err(MeshProblem::MissingValue.into());
            }
            let step = (self.block.len() - self.at).min(usize::try_from(bytes).unwrap_or(BLOCK));
            self.at += step;
            bytes -= step as u64;
        }
        Ok(())
    }

    fn fault(&self, problem: MeshProblem) -> Fault {
        problem.into()
    }
}
