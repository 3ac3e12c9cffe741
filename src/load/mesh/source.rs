//! Bytes of a file, decompressed if need be.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::path::Path;

use flate2::bufread::{MultiGzDecoder, ZlibDecoder};

use super::error::{Fault, MeshProblem};

/// DEFLATE expands its input at most 1032-fold.
const LARGEST_EXPANSION: u64 = 1032;

/// An open file.
pub(super) struct Source {
    pub(super) reader: Box<dyn BufRead + Send>,
    /// No more bytes than these can come out of the reader; guards against absurd reservations.
    pub(super) largest_size: u64,
    /// Bytes of a byte order mark that were passed over.
    pub(super) skipped: u64,
}

impl Source {
    /// Opens a file and looks whether it is compressed.
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        let size = file.metadata()?.len();
        let mut reader = BufReader::new(file);
        if reader.fill_buf()?.starts_with(&[0x1f, 0x8b]) {
            let reader = Box::new(BufReader::new(MultiGzDecoder::new(reader)));
            let largest_size = size.saturating_mul(LARGEST_EXPANSION);
            Ok(Self { reader, largest_size, skipped: 0 })
        } else {
            Ok(Self { reader: Box::new(reader), largest_size: size, skipped: 0 })
        }
    }

    /// Opens a file that begins with text, behind the byte order mark of UTF-8 if it has one.
    ///
    /// # Errors
    /// Those of the operating system; text in UTF-16, with or without a mark.
    pub(super) fn text(path: &Path) -> Result<Self, Fault> {
        let mut source = Self::open(path)?;
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
    pub(super) fn zlib(compressed: impl BufRead + Send + 'static, size: u64) -> Self {
        let reader = Box::new(BufReader::new(ZlibDecoder::new(compressed)));
        Self { reader, largest_size: size.saturating_mul(LARGEST_EXPANSION), skipped: 0 }
    }

    /// How many of `declared` things to make room for, if each takes at least so many bytes of the
    /// file. More cannot come, whatever a header says.
    pub(super) fn plausible(&self, declared: u64, least_bytes: u64) -> usize {
        let most = self.largest_size / least_bytes.max(1);
        usize::try_from(declared.min(most)).unwrap_or(0)
    }
}
