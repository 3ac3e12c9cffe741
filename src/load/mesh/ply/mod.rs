//! Stanford PLY. The header says which elements follow and what a record of each holds.

mod ascii;
mod binary;
mod header;
mod record;
mod wedges;

#[cfg(test)]
mod tests;

use std::path::Path;

use self::header::{Encoding, Header};
use self::record::{Content, Records};
use super::buffers::Placement;
use super::error::Fault;
use super::source::Source;
use super::{LoadedMesh, MeshOptions};

pub(super) fn load(path: &Path, options: &MeshOptions) -> Result<LoadedMesh, Fault> {
    let mut source = Source::text(path, &options.limits)?;
    let header = Header::read(&mut source.reader)?;
    let records = Records::new(&header, options.face_normals, Placement::new(options))?;
    let mut content = Content::default();
    records.reserve(&source, &mut content.buffers)?;
    match header.encoding {
        Encoding::Ascii => ascii::read(&mut source, header.lines, &records, &mut content)?,
        Encoding::Binary { big_endian } => {
            let before = source.skipped + header.bytes;
            binary::read(source, before, big_endian, &records, &mut content)?;
        }
    }
    let Content { mut buffers, wedges, .. } = content;
    wedges.split(&mut buffers)?;
    buffers.loaded(options)
}
