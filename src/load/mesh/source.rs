//! Bytes of a file, decompressed if need be.

use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;

use flate2::bufread::{MultiGzDecoder, ZlibDecoder};

/// DEFLATE expands its input at most 1032-fold.
const LARGEST_EXPANSION: u64 = 1032;

/// An open file.
pub(super) struct Source {
    pub(super) reader: Box<dyn BufRead + Send>,
    /// No more bytes than these can come out of the reader; guards against absurd reservations.
    pub(super) largest_size: u64,
}

impl Source {
    /// Opens a file and looks whether it is compressed.
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        let size = file.metadata()?.len();
        let mut reader = BufReader::new(file);
        if reader.fill_buf()?.starts_with(&[0x1f, 0x8b]) {
            let reader = Box::new(BufReader::new(MultiGzDecoder::new(reader)));
            Ok(Self { reader, largest_size: size.saturating_mul(LARGEST_EXPANSION) })
        } else {
            Ok(Self { reader: Box::new(reader), largest_size: size })
        }
    }

    /// What a stream of zlib's at the start of `compressed`, of at most so many bytes, expands to.
    pub(super) fn zlib(compressed: impl BufRead + Send + 'static, size: u64) -> Self {
        let reader = Box::new(BufReader::new(ZlibDecoder::new(compressed)));
        Self { reader, largest_size: size.saturating_mul(LARGEST_EXPANSION) }
    }

    /// How many of `declared` things to make room for, if each takes at least so many bytes of the
    /// file. More cannot come, whatever a header says.
    pub(super) fn plausible(&self, declared: u64, least_bytes: u64) -> usize {
        let most = self.largest_size / least_bytes.max(1);
        usize::try_from(declared.min(most)).unwrap_or(0)
    }
}
