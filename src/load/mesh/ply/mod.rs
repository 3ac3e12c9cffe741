//! Stanford PLY. The header says which elements follow and what a record of each holds.

mod ascii;
mod binary;
mod header;
mod record;

#[cfg(test)]
mod tests;

use std::path::Path;

use self::header::{Encoding, Header};
use self::record::Records;
use super::buffers::{Buffers, Placement};
use super::error::Fault;
use super::source::Source;
use super::{LoadedMesh, MeshOptions};

pub(super) fn load(path: &Path, options: &MeshOptions) -> Result<LoadedMesh, Fault> {
    let mut source = Source::open(path, &options.limits)?;
    let header = Header::read(&mut source.reader)?;
    let records = Records::new(&header, options.face_normals, Placement::new(options))?;
    let mut buffers = Buffers::default();
    records.reserve(&source, &mut buffers)?;
    match header.encoding {
        Encoding::Ascii => ascii::read(&mut source, header.lines, &records, &mut buffers)?,
        Encoding::Binary { big_endian } => {
            binary::read(source, header.bytes, big_endian, &records, &mut buffers)?;
        }
    }
    buffers.finish(options)
}
