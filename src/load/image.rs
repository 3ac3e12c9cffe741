//! Image files.

use std::borrow::Cow;
use std::fs;
use std::io::Cursor;
use std::path::Path;

use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read};
use image::{ColorType, DynamicImage, ImageFormat, ImageReader};

use super::image_size::{self, Size};
use crate::film::exr_size::promised_bytes;
use crate::memory::Limits;
use crate::texture::Image;
use crate::texture::image::Texels;

/// The image in the file at `path`, in the file's own precision; an alpha channel is left out.
///
/// # Errors
/// What is wrong with the file: a fragment.
pub(super) fn load(path: &Path, limits: &Limits) -> Result<Image, String> {
    let bytes = fs::read(path).map_err(|e| format!("cannot be read: {e}"))?;
    let claim = |bytes| limits.claim(bytes).map_err(|error| format!("is too large: {error}"));
    let sized = |bytes: &[u8], format| {
        let size = image_size::checked(bytes, format)?;
        claim(size.pixels())?;
        other(bytes, format, size)
    };
    let image = if bytes.starts_with(&EXR_MAGIC) {
        claim(promised_bytes(&bytes).map_err(|error| error.to_string())?)?;
        openexr(&bytes)?
    } else if bytes.starts_with(b"#?") {
        sized(&plain_radiance(&bytes), ImageFormat::Hdr)?
    } else {
        match image::guess_format(&bytes) {
            Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::Bmp)) => {
                sized(&bytes, format)?
            }
            _ => {
                return Err(
                    "is no image in a known format (expected PNG, JPEG, BMP, OpenEXR or HDR)"
                        .into(),
                );
            }
        }
    };
    if !all_finite(image.texels()) {
        return Err("has pixels that are not finite".into());
    }
    Ok(image)
}

/// The first bytes of OpenEXR files.
const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Bytes that decoding takes for a pixel at most: four floats, and what they are decoded from.
const LARGEST_PIXEL: u64 = 32;

/// Bytes that it takes besides.
const SPARE: u64 = 1 << 22;

fn all_finite(texels: &Texels) -> bool {
    match texels {
        Texels::Unorm8(_) | Texels::Unorm16(_) => true,
        Texels::Half(values) => values.iter().all(|v| v.is_finite()),
        Texels::Float(values) => values.iter().all(|v| v.is_finite()),
    }
}

fn other(bytes: &[u8], format: ImageFormat, size: Size) -> Result<Image, String> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    // What else is in a file, such as a colour profile, may be compressed as well.
    let mut limits = image::Limits::no_limits();
    limits.max_alloc = Some(size.pixels() * LARGEST_PIXEL + SPARE);
    reader.limits(limits);
    let picture = reader.decode().map_err(|error| format!("cannot be decoded: {error}"))?;
    let (width, height) = (picture.width(), picture.height());
    let grey = !picture.color().has_color();
    let (channels, texels) = match picture.color() {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 if grey => {
            (1, Texels::Unorm8(picture.into_luma8().into_raw()))
        }
        ColorType::Rgb8 | ColorType::Rgba8 => (3, Texels::Unorm8(picture.into_rgb8().into_raw())),
        ColorType::L16 | ColorType::La16 => (1, Texels::Unorm16(picture.into_luma16().into_raw())),
        ColorType::Rgb16 | ColorType::Rgba16 => {
            (3, Texels::Unorm16(picture.into_rgb16().into_raw()))
        }
        _ => (3, Texels::Float(DynamicImage::into_rgb32f(picture).into_raw())),
    };
    Image::new(width, height, channels, texels).ok_or_else(|| "has no pixels".to_owned())
}

/// A file of Radiance with the header that the decoder asks for. Its first line may name any program, such as
/// `#?RGBE`, and its lines may end as on Windows.
fn plain_radiance(bytes: &[u8]) -> Cow<'_, [u8]> {
    let mut header = b"#?RADIANCE\n".to_vec();
    let mut rest = bytes;
    let (mut lines, mut after_blank) = (0, false);
    while let Some(end) = rest.iter().position(|&b| b == b'\n') {
        let line = rest[..end].strip_suffix(b"\r").unwrap_or(&rest[..end]);
        rest = &rest[end + 1..];
        if lines > 0 {
            header.extend_from_slice(line);
            header.push(b'\n');
        }
        lines += 1;
        // The size stands below an empty line, and pixels below that.
        if after_blank {
            header.extend_from_slice(rest);
            return Cow::Owned(header);
        }
        after_blank = line.is_empty();
    }
    Cow::Borrowed(bytes)
}

/// The channels `R`, `G` and `B`, or else `Y`, of the first layer that has them.
fn openexr(bytes: &[u8]) -> Result<Image, String> {
    let decoded = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| format!("cannot be decoded: {error}"))?;
    for layer in &decoded.layer_data {
        let find = |name: &str| {
            layer.channel_data.list.iter().find(|c| c.name.eq(name)).map(|c| &c.sample_data)
        };
        let channels: Option<Vec<_>> = ["R", "G", "B"].into_iter().map(find).collect();
        let channels = channels.or_else(|| find("Y").map(|y| vec![y]));
        let (Some(channels), Ok(width), Ok(height)) =
            (channels, u32::try_from(layer.size.x()), u32::try_from(layer.size.y()))
        else {
            continue;
        };
        let count = layer.size.area();
        if channels.iter().any(|c| c.len() != count) {
            return Err("has subsampled channels, which are not supported".into());
        }
        let texels = interleave(&channels, count);
        return Image::new(width, height, channels.len(), texels)
            .ok_or_else(|| "has no pixels".to_owned());
    }
    Err("has no channels R, G and B, and no channel Y".into())
}

/// Side by side; as halves if all are.
fn interleave(channels: &[&FlatSamples], count: usize) -> Texels {
    let halves: Option<Vec<_>> = channels
        .iter()
        .map(|c| match c {
            FlatSamples::F16(values) => Some(values.as_slice()),
            _ => None,
        })
        .collect();
    let indices = (0..count).flat_map(|i| (0..channels.len()).map(move |c| (i, c)));
    match halves {
        Some(halves) => Texels::Half(indices.map(|(i, c)| halves[c][i]).collect()),
        None => Texels::Float(
            indices.map(|(i, c)| channels[c].value_by_flat_index(i).to_f32()).collect(),
        ),
    }
}
