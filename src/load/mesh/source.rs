//! Bytes of a file, decompressed if need be.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::path::Path;

use flate2::bufread::{MultiGzDecoder, ZlibDecoder};

use super::error::{Fault, MeshProblem};
use crate::memory::{Limits, readable};

/// DEFLATE expands its input at most 1032-fold.
const LARGEST_EXPANSION: u64 = 1032;

/// How far meshes are really packed. Room for more is made only when it comes.
const USUAL_EXPANSION: u64 = 16;

/// An open file.
pub(super) struct Source {
    pub(super) reader: Box<dyn BufRead + Send>,
    /// Bytes on the disk.
    stored: u64,
    /// No more bytes than these can come out of the reader.
    largest_size: u64,
    /// As many bytes as are likely to; guards against absurd reservations.
    likely_size: u64,
    limits: Limits,
    /// Bytes of a byte order mark that were passed over.
    pub(super) skipped: u64,
}

impl Source {
    /// Opens a file and looks whether it is compressed.
    pub(super) fn open(path: &Path, limits: &Limits) -> io::Result<Self> {
        let file = File::open(path)?;
        let stored = file.metadata()?.len();
        let mut reader = BufReader::new(file);
        if reader.fill_buf()?.starts_with(&[0x1f, 0x8b]) {
            return Ok(Self::unpacking(MultiGzDecoder::new(reader), stored, limits));
        }
        let (largest_size, likely_size) = (stored, stored);
        let limits = limits.clone();
        Ok(Self { reader: Box::new(reader), stored, largest_size, likely_size, limits, skipped: 0 })
    }

    /// Opens a file that begins with text, behind the byte order mark of UTF-8 if it has one.
    ///
    /// # Errors
    /// Those of the operating system; text in UTF-16, with or without a mark.
    pub(super) fn text(path: &Path, limits: &Limits) -> Result<Self, Fault> {
        let mut source = Self::open(path, limits)?;
        let mut start = Vec::new();
        (&mut source.reader).take(4).read_to_end(&mut start)?;
        let is_utf16 = match start[..] {
            [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => true,
            [a, 0, b, 0] | [0, a, 0, b] => [a, b].iter().all(|c| (b'\t'..=b'~').contains(c)),
            _ => false,
        };
        if is_utf16 {
            return Err(MeshProblem::Utf16.into());
        }
        let rest = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&start).to_vec();
        source.skipped = (start.len() - rest.len()) as u64;
        source.reader = Box::new(Cursor::new(rest).chain(source.reader));
        Ok(source)
    }

    /// What a stream of zlib's at the start of `compressed`, of at most so many bytes, expands to.
    pub(super) fn zlib(
        compressed: impl BufRead + Send + 'static,
        size: u64,
        limits: &Limits,
    ) -> Self {
        Self::unpacking(ZlibDecoder::new(compressed), size, limits)
    }

    fn unpacking(decoder: impl Read + Send + 'static, stored: u64, limits: &Limits) -> Self {
        let limit = limits.largest_unpacked(stored);
        let bounded = Bounded { decoder, left: limit, problem: Unpacked { stored, limit } };
        Self {
            reader: Box::new(BufReader::new(bounded)),
            stored,
            largest_size: stored.saturating_mul(LARGEST_EXPANSION).min(limit),
            likely_size: stored.saturating_mul(USUAL_EXPANSION).min(limit),
            limits: limits.clone(),
            skipped: 0,
        }
    }

    /// Bytes on the disk.
    pub(super) fn stored(&self) -> u64 {
        self.stored
    }

    /// How many of `declared` things to make room for, if each takes at least so many bytes of the
    /// file. More are not likely to come, whatever a header says.
    pub(super) fn plausible(&self, declared: u64, least_bytes: u64) -> usize {
        let most = self.likely_size / least_bytes.max(1);
        usize::try_from(declared.min(most)).unwrap_or(0)
    }

    /// How many of them can come at all.
    pub(super) fn possible(&self, declared: u64, least_bytes: u64) -> u64 {
        declared.min(self.largest_size / least_bytes.max(1))
    }

    /// Asks for so many bytes of memory.
    pub(super) fn claim(&self, bytes: u64) -> Result<(), Fault> {
        self.limits.claim(bytes).map_err(|error| MeshProblem::from(error).into())
    }
}

/// A decoder that ends with an error where too much comes out of it.
struct Bounded<R> {
    decoder: R,
    left: u64,
    problem: Unpacked,
}

/// A compressed file holds more than it may.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error("a compressed file of {} unpacks to more than {}", readable(*.stored), readable(*.limit))]
pub(super) struct Unpacked {
    pub(super) stored: u64,
    pub(super) limit: u64,
}

impl<R: Read> Read for Bounded<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.decoder.read(buffer)?;
        match self.left.checked_sub(count as u64) {
            Some(left) => self.left = left,
            None => return Err(io::Error::other(self.problem)),
        }
        Ok(count)
    }
}
