//! What the header of an image promises, against the bytes that are there: a decoder makes room for all
//! pixels before it sees the first one, and a header is quickly damaged.

use std::io::Cursor;

use image::{ImageFormat, ImageReader};

/// DEFLATE expands its input at most 1032-fold. What else is packed stays below, if anybody means it: in
/// JPEG a block takes a bit at least, so 1024 pixels a byte, even where one channel has every fourth column
/// and another one every fourth row; runs of BMP and HDR hold 255 pixels in two bytes and in four.
const EXPANSION: u64 = 1032;

/// Columns and rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Size {
    width: u32,
    height: u32,
}

impl Size {
    pub(super) fn pixels(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

/// The size that the header of `file` promises.
///
/// # Errors
/// A header that cannot be read, or a file that is too small for it: a fragment.
pub(super) fn checked(file: &[u8], format: ImageFormat) -> Result<Size, String> {
    let reader = ImageReader::with_format(Cursor::new(file), format);
    let (width, height) =
        reader.into_dimensions().map_err(|error| format!("cannot be decoded: {error}"))?;
    let size = Size { width, height };
    let least = match format {
        ImageFormat::Png => png_bytes(file, size) / EXPANSION,
        ImageFormat::Bmp => bmp_bytes(file, size),
        _ => size.pixels() / EXPANSION,
    };
    if least > file.len() as u64 {
        return Err(format!(
            "is too small for the {width}x{height} pixels that its header promises (it has {} bytes; expected \
             at least {least})",
            file.len()
        ));
    }
    Ok(size)
}

/// Bytes of the rows before they are packed. The header is the first chunk: see 11.2.1 of the standard.
fn png_bytes(file: &[u8], size: Size) -> u64 {
    let field = |at: usize| file.get(at).copied().unwrap_or(0);
    let (depth, color_type) = (field(24), field(25));
    let channels: u64 = match color_type {
        2 => 3,
        4 => 2,
        6 => 4,
        _ => 1,
    };
    let row = (u64::from(size.width) * channels * u64::from(depth)).div_ceil(8) + 1;
    row.saturating_mul(size.height.into())
}

/// Bytes of the rows; fewer if they are runs.
fn bmp_bytes(file: &[u8], size: Size) -> u64 {
    let number = |at: usize| file.get(at..at + 2).map_or(0, |b| u16::from_le_bytes([b[0], b[1]]));
    // The oldest header has 12 bytes, 16-bit sizes, and no field for runs.
    let is_oldest = number(14) == 12;
    let (bits, packing) = if is_oldest { (number(24), 0) } else { (number(28), number(30)) };
    match packing {
        1 | 2 => size.pixels() / EXPANSION,
        _ => (u64::from(size.width) * u64::from(bits)).div_ceil(32) * 4 * u64::from(size.height),
    }
}
