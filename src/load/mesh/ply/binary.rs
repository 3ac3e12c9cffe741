//! PLY data as bytes.

use super::super::bytes::Bytes;
use super::super::error::{Fault, MeshProblem, Place};
use super::super::source::Source;
use super::header::Scalar;
use super::record::{Content, Records, Values};

/// Reads all records; the header has so many bytes.
pub(super) fn read(
    source: Source,
    header_bytes: u64,
    big_endian: bool,
    records: &Records,
    content: &mut Content,
) -> Result<(), Fault> {
    let mut bytes = Bytes::new(source, header_bytes, big_endian);
    for (index, element) in records.elements().enumerate() {
        for number in 0..element.count {
            records.read(index, &mut bytes, content).map_err(|fault| {
                let (offset, problem) = match *fault.problem {
                    MeshProblem::MissingValue => {
                        let (element, count) = (element.name.clone(), element.count);
                        let found = number;
                        (bytes.end(), MeshProblem::Truncated { element, count, found })
                    }
                    problem => (bytes.last(), problem),
                };
                let element = element.name.clone();
                Fault::new(Place::Record { offset, element, number }, problem)
            })?;
        }
    }
    if bytes.remaining(1)? { Err(MeshProblem::TrailingData.into()) } else { Ok(()) }
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
        self.skip_bytes(count * scalar.size() as u64)
    }

    fn fault(&self, problem: MeshProblem) -> Fault {
        problem.into()
    }
}
