//! Mitsuba's own format: meshes one after the other, each a short header and a stream of zlib's, and a list
//! of where they start at the end of the file. All numbers have their least significant byte first.

#[cfg(test)]
pub(super) mod tests;

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use glam::DVec3;

use super::buffers::{Buffers, Placement};
use super::bytes::Bytes;
use super::error::{Fault, MeshProblem, Place};
use super::source::Source;
use super::{LoadedMesh, MeshOptions};
use crate::shape::mesh::MeshError;

/// The first bytes of each mesh.
const MAGIC: u16 = 0x041c;
/// Bytes before the stream of each mesh: these, and the version.
const HEAD: u64 = 4;

const HAS_NORMALS: u32 = 0x0001;
const HAS_UVS: u32 = 0x0002;
/// Set by old exporters; nothing in the file goes with it.
const HAS_TANGENTS: u32 = 0x0004;
const HAS_COLORS: u32 = 0x0008;
const FACE_NORMALS: u32 = 0x0010;
const SINGLE: u32 = 0x1000;
const DOUBLE: u32 = 0x2000;
const KNOWN: u32 =
    HAS_NORMALS | HAS_UVS | HAS_TANGENTS | HAS_COLORS | FACE_NORMALS | SINGLE | DOUBLE;

pub(super) fn load(
    path: &Path,
    shape_index: u32,
    options: &MeshOptions,
) -> Result<LoadedMesh, Fault> {
    let mut file = BufReader::new(File::open(path)?);
    let size = file.get_ref().metadata()?.len();
    let version = read_head(&mut file, 0)?;
    let mut start = 0;
    if shape_index > 0 {
        start = find(&mut file, size, version, shape_index)?;
        file.seek(SeekFrom::Start(start))?;
        let own = read_head(&mut file, start)?;
        if own != version {
            let expected = "that of the first mesh";
            let problem = MeshProblem::SerializedVersion { version: own, expected };
            return Err(Fault::new(Place::Byte { offset: start + 2 }, problem));
        }
    }
    let data = Bytes::new(Source::zlib(file, size, &options.limits), 0, false);
    Mesh { data, index: shape_index, start: start + HEAD, is_double: false }.read(version, options)
}

/// The version in the header of the mesh at `offset`.
fn read_head(file: &mut impl Read, offset: u64) -> Result<u16, Fault> {
    let mut head = [0; 4];
    let problem = match file.read_exact(&mut head) {
        Err(error) if error.kind() != io::ErrorKind::UnexpectedEof => return Err(error.into()),
        Ok(()) if u16::from_le_bytes([head[0], head[1]]) == MAGIC => {
            match u16::from_le_bytes([head[2], head[3]]) {
                version @ 3..=4 => return Ok(version),
                version => MeshProblem::SerializedVersion { version, expected: "3 or 4" },
            }
        }
        _ => MeshProblem::NotSerialized,
    };
    let into_head = if matches!(problem, MeshProblem::NotSerialized) { 0 } else { 2 };
    Err(Fault::new(Place::Byte { offset: offset + into_head }, problem))
}

/// Where the mesh of that index starts: offsets of all of them and their number end the file.
fn find(file: &mut BufReader<File>, size: u64, version: u16, index: u32) -> Result<u64, Fault> {
    // A file that is not one of the disk may have no size; then seeking fails.
    let end = size.saturating_sub(4);
    let at = |offset| move |problem| Fault::new(Place::Byte { offset }, problem);
    let mut bytes = [0; 4];
    file.seek(SeekFrom::Start(end))?;
    file.read_exact(&mut bytes)?;
    let count = u32::from_le_bytes(bytes);
    if index >= count {
        return Err(at(end)(MeshProblem::NoSuchMesh { index, count }));
    }
    let entry_size = if version == 4 { 8 } else { 4 };
    let entry = end.checked_sub(entry_size * u64::from(count - index)).ok_or_else(|| {
        at(end)(MeshProblem::Dictionary(format!("the file is too short for {count} meshes")))
    })?;
    let mut bytes = [0; 8];
    file.seek(SeekFrom::Start(entry))?;
    file.read_exact(&mut bytes[..entry_size as usize])?;
    let offset = u64::from_le_bytes(bytes);
    if offset >= entry {
        let message = format!(
            "mesh {index} is said to start at byte {offset}, behind all meshes of a file of {size} bytes"
        );
        return Err(at(entry)(MeshProblem::Dictionary(message)));
    }
    Ok(offset)
}

/// The data of one mesh.
struct Mesh {
    data: Bytes,
    /// Which mesh of the file it is.
    index: u32,
    /// Where in the file its stream starts.
    start: u64,
    is_double: bool,
}

impl Mesh {
    fn read(mut self, version: u16, options: &MeshOptions) -> Result<LoadedMesh, Fault> {
        let header = self.header(version);
        let (flags, [vertices, triangles]) = header.map_err(|fault| self.locate(None, fault))?;
        self.is_double = flags & DOUBLE != 0;
        let has_normals = flags & HAS_NORMALS != 0;
        let keeps_normals = has_normals && !options.face_normals && flags & FACE_NORMALS == 0;
        let has_uvs = flags & HAS_UVS != 0;

        let source = self.data.source();
        let vertex_bytes = if self.is_double { 24 } else { 12 };
        let room = source.plausible(vertices, vertex_bytes);
        let kept = Buffers::vertex_bytes(keeps_normals, has_uvs);
        source.claim(
            source.possible(vertices, vertex_bytes).saturating_mul(kept)
                + source.possible(triangles, 12).saturating_mul(Buffers::TRIANGLE_BYTES),
        )?;
        let placement = Placement::new(options);
        let mut buffers = Buffers {
            positions: Vec::with_capacity(room),
            normals: Vec::with_capacity(if keeps_normals { room } else { 0 }),
            uvs: Vec::with_capacity(if has_uvs { room } else { 0 }),
            triangles: Vec::with_capacity(source.plausible(triangles, 12)),
            ..Buffers::default()
        };
        self.vectors("vertex", vertices, |[x, y, z]| {
            buffers.positions.push(placement.position(DVec3::new(x, y, z)));
        })?;
        if has_normals {
            self.vectors("normal", vertices, |[x, y, z]| {
                if keeps_normals {
                    buffers.normals.push(placement.normal(DVec3::new(x, y, z)));
                }
            })?;
        }
        if has_uvs {
            self.vectors("texture coordinate", vertices, |[u, v]| {
                buffers.uvs.push(placement.uv(u, v));
            })?;
        }
        if flags & HAS_COLORS != 0 {
            self.vectors("colour", vertices, |[_, _, _]| {})?;
        }
        for number in 0..triangles {
            let triangle = self.triangle(vertices);
            let triangle = triangle
                .map_err(|fault| self.locate(Some(("triangle", number, triangles)), fault))?;
            buffers.triangles.push(triangle);
        }
        // Reads on to the checksum.
        match self.data.remaining(1) {
            Ok(false) => buffers.loaded(options),
            Ok(true) => {
                let place =
                    Place::Data { mesh: self.index, offset: self.data.position(), record: None };
                Err(Fault::new(place, MeshProblem::TrailingData))
            }
            Err(fault) => Err(self.locate(None, fault)),
        }
    }

    /// Flags, number of vertices, number of triangles.
    fn header(&mut self, version: u16) -> Result<(u32, [u64; 2]), Fault> {
        let flags = u32::from_le_bytes(self.data.next()?);
        let header = |message: String| Err(MeshProblem::Header(message).into());
        if flags & !KNOWN != 0 {
            return header(format!("the flags {:#x} are not known", flags & !KNOWN));
        }
        if flags & SINGLE != 0 && flags & DOUBLE != 0 {
            return header("the flags say both single and double precision".into());
        }
        if version == 4 {
            // The name of the mesh, up to a zero.
            while self.data.next()? != [0] {}
        }
        let mut counts = [0; 2];
        for (count, what) in counts.iter_mut().zip(["vertices", "triangles"]) {
            *count = u64::from_le_bytes(self.data.next()?);
            // From there on, indices would have 64 bits.
            if *count >= u64::from(u32::MAX) {
                let count = usize::try_from(*count).unwrap_or(usize::MAX);
                return Err(MeshError::TooLarge { what, count }.into());
            }
        }
        Ok((flags, counts))
    }

    /// Hands `count` vectors of numbers to `take`.
    fn vectors<const N: usize>(
        &mut self,
        name: &'static str,
        count: u64,
        mut take: impl FnMut([f64; N]),
    ) -> Result<(), Fault> {
        for number in 0..count {
            let mut vector = [0.0; N];
            for value in &mut vector {
                *value = self
                    .number()
                    .map_err(|fault| self.locate(Some((name, number, count)), fault))?;
            }
            take(vector);
        }
        Ok(())
    }

    #[inline]
    fn number(&mut self) -> Result<f64, Fault> {
        Ok(if self.is_double {
            f64::from_le_bytes(self.data.next()?)
        } else {
            f32::from_le_bytes(self.data.next()?).into()
        })
    }

    #[inline]
    fn triangle(&mut self, vertices: u64) -> Result<[u32; 3], Fault> {
        let mut triangle = [0; 3];
        for vertex in &mut triangle {
            *vertex = u32::from_le_bytes(self.data.next()?);
            if u64::from(*vertex) >= vertices {
                let (attribute, index) = ("vertex index", i64::from(*vertex));
                let problem = MeshProblem::IndexOutOfRange { attribute, index, count: vertices };
                return Err(problem.into());
            }
        }
        Ok(triangle)
    }

    /// Where the data went wrong: in the record of that name and number among so many, or in the header.
    #[cold]
    fn locate(&self, record: Option<(&'static str, u64, u64)>, fault: Fault) -> Fault {
        let (offset, problem) = match (*fault.problem, record) {
            // Which of the bytes are wrong, the decompression does not tell.
            (problem @ MeshProblem::Io(_), _) => {
                return Fault::new(Place::Byte { offset: self.start }, problem);
            }
            (MeshProblem::MissingValue, Some((name, found, count))) => {
                let element = name.to_owned();
                (self.data.end(), MeshProblem::Truncated { element, count, found })
            }
            (MeshProblem::MissingValue, None) => {
                (self.data.end(), MeshProblem::Header("the data ends inside the header".into()))
            }
            (problem, _) => (self.data.last(), problem),
        };
        let record = record.map(|(name, number, _)| (name, number));
        Fault::new(Place::Data { mesh: self.index, offset, record }, problem)
    }
}
