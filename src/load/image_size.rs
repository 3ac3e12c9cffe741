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
    if format == ImageFormat::Png {
        check_palette(file)?;
    }
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

/// Refuses a PNG file whose palette has something else than 1 to 256 whole colours (11.2.2 of the standard):
/// the decoder takes that for granted, and panics.
fn check_palette(file: &[u8]) -> Result<(), String> {
    let mut at = 8;
    while let Some(&[a, b, c, d, ref kind @ ..]) = file.get(at..at + 8) {
        let length = u32::from_be_bytes([a, b, c, d]) as usize;
        if kind == b"PLTE" && (!length.is_multiple_of(3) || !(3..=768).contains(&length)) {
            return Err(format!(
                "cannot be decoded: its palette has {length} bytes (expected 3 for each of 1 to 256 colours)"
            ));
        }
        // Length, kind and sum.
        at = at.saturating_add(length).saturating_add(12);
    }
    Ok(())
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The start of a PNG file: its signature, a header and a palette of so many bytes.
    fn palette(length: u32) -> Vec<u8> {
        let mut file = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec();
        file.extend([0; 17]);
        file.extend(length.to_be_bytes());
        file.extend(b"PLTE");
        file.resize(file.len() + length as usize + 4, 0);
        file
    }

    #[test]
    fn palettes_hold_whole_colours() {
        for length in [3, 48, 768] {
            assert_eq!(check_palette(&palette(length)), Ok(()), "{length}");
        }
        for length in [0, 1, 49, 771, 3000] {
            let error = check_palette(&palette(length)).expect_err("no palette");
            assert_eq!(
                error,
                format!(
                    "cannot be decoded: its palette has {length} bytes (expected 3 for each of 1 to 256 colours)"
                )
            );
        }
        // Chunks that lead out of the file are the decoder's business.
        assert_eq!(check_palette(&[0xff; 20]), Ok(()));
        assert_eq!(check_palette(b""), Ok(()));
    }

    #[test]
    fn rows_are_counted_as_the_header_says() {
        let size = Size { width: 9, height: 2 };
        let mut png = palette(3);
        for (depth, color_type, bytes) in [(1, 0, 6), (4, 3, 12), (8, 2, 56), (16, 6, 146)] {
            (png[24], png[25]) = (depth, color_type);
            assert_eq!(png_bytes(&png, size), bytes, "{depth} {color_type}");
        }
        let mut bmp = vec![0; 60];
        (bmp[14], bmp[28]) = (40, 24);
        assert_eq!(bmp_bytes(&bmp, size), 56);
        bmp[30] = 1;
        assert_eq!(bmp_bytes(&bmp, size), 0);
        (bmp[14], bmp[24]) = (12, 8);
        assert_eq!(bmp_bytes(&bmp, size), 24);
    }
}
