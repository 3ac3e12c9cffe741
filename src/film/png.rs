//! PNG files: 8-bit sRGB, for looking at.

use std::io::Write;
use std::path::Path;

use super::atomic_file::write_atomically;
use super::output::{OutputError, Report, check_shape};
use super::picture::Picture;

/// What NaN looks like: a colour that no one takes for a part of the scene.
const MAGENTA: [u8; 3] = [255, 0, 255];

/// Writes the picture proper to a PNG file: its crop, multiplied by 2 to the power of
/// `exposure_stops`, through the transfer function of sRGB (IEC 61966-2-1). What is below 0 becomes
/// black, what is above 1 white. PNG's alpha is not associated: colours are divided by it.
///
/// # Errors
/// A picture without colours; what the operating system refuses.
pub fn write_png(
    path: &Path,
    picture: &Picture,
    exposure_stops: f32,
) -> Result<Report, OutputError> {
    check_shape(path, picture)?;
    let Some(pixels) = Pixels::of(picture, exposure_stops) else {
        return Err(OutputError::NoColors(path.to_owned()));
    };
    write_atomically(path, |writer| {
        pixels.encode(writer).map_err(|e| match e {
            png::EncodingError::IoError(error) => OutputError::Io { path: path.to_owned(), error },
            other => OutputError::Unfit { path: path.to_owned(), reason: other.to_string() },
        })
    })?;
    Ok(pixels.report)
}

/// The contents of the file that [`write_png`] would write; `None` of a picture without pixels or colours.
#[must_use]
pub fn png_bytes(picture: &Picture, exposure_stops: f32) -> Option<Vec<u8>> {
    let mut file = Vec::new();
    Pixels::of(picture, exposure_stops)?.encode(&mut file).ok()?;
    Some(file)
}

/// A picture in bytes.
struct Pixels {
    width: u32,
    height: u32,
    color: png::ColorType,
    bytes: Vec<u8>,
    report: Report,
}

impl Pixels {
    fn of(picture: &Picture, exposure_stops: f32) -> Option<Self> {
        let (red, green, blue) = (picture.color("R")?, picture.color("G")?, picture.color("B")?);
        let alpha = picture.color("A");
        let scale = exposure_stops.exp2();
        let mut report = Report::default();
        let mut bytes = Vec::with_capacity(picture.pixels() * 4);
        for pixel in 0..picture.pixels() {
            let coverage = alpha.map_or(1.0, |a| a[pixel]);
            let rgb = [red[pixel], green[pixel], blue[pixel]];
            report.not_a_number += rgb.iter().filter(|v| v.is_nan()).count();
            bytes.extend(encode_pixel(rgb, coverage, scale));
            if alpha.is_some() {
                report.not_a_number += usize::from(coverage.is_nan());
                bytes.push(to_byte(coverage));
            }
        }
        let color = if alpha.is_some() { png::ColorType::Rgba } else { png::ColorType::Rgb };
        let (width, height) = (picture.crop.width, picture.crop.height);
        Some(Self { width, height, color, bytes, report })
    }

    fn encode(&self, writer: impl Write) -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(writer, self.width, self.height);
        encoder.set_color(self.color);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut file = encoder.write_header()?;
        file.write_image_data(&self.bytes)?;
        file.finish()
    }
}

/// A pixel's colour bytes, as [`write_png`] has them: linear values that were multiplied by the `coverage` from 0 to 1
/// (alpha; 1 where there is none), brighter by the factor `scale`. NaN is magenta.
#[must_use]
pub fn encode_pixel(rgb: [f32; 3], coverage: f32, scale: f32) -> [u8; 3] {
    if rgb.iter().any(|v| v.is_nan()) {
        return MAGENTA;
    }
    // Where nothing is covered there may yet be light (a glow before an empty background), which PNG
    // cannot show; it is kept for those who drop the alpha channel.
    let factor = if coverage > 0.0 { scale / coverage } else { scale };
    // Infinity times a scale that underflowed to 0 is NaN, which a cast to u8 makes 0.
    rgb.map(|v| to_byte(srgb_from_linear(v * factor)))
}

/// 0 to 1 as 0 to 255, rounded to nearest. Casts saturate, and turn NaN into 0.
fn to_byte(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// The transfer function of sRGB for a linear value; linear, and so negative, below 0.
fn srgb_from_linear(value: f32) -> f32 {
    if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::picture::{Channel, Values};
    use crate::film::{ComponentFormat, Crop};

    /// A picture of one row, grey unless said otherwise.
    fn row(channels: &[(&str, &[f32])]) -> Picture {
        let width = channels[0].1.len() as u32;
        Picture {
            width,
            height: 1,
            crop: Crop { x: 0, y: 0, width, height: 1 },
            channels: channels
                .iter()
                .map(|(name, values)| Channel::new(*name, Values::Color(values.to_vec())))
                .collect(),
            component: ComponentFormat::Half,
        }
    }

    fn grey(values: &[f32]) -> Picture {
        row(&[("B", values), ("G", values), ("R", values)])
    }

    /// Writes and reads back: bytes and whether the file says that it is sRGB.
    fn round_trip(picture: &Picture, stops: f32) -> (Vec<u8>, Report) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.png");
        let report = write_png(&path, picture, stops).expect("writable");
        let file = std::io::BufReader::new(std::fs::File::open(&path).expect("written"));
        let mut reader = png::Decoder::new(file).read_info().expect("a PNG file");
        assert_eq!(reader.info().srgb, Some(png::SrgbRenderingIntent::Perceptual));
        let mut bytes = vec![0; reader.output_buffer_size().expect("small")];
        reader.next_frame(&mut bytes).expect("a picture");
        (bytes, report)
    }

    /// The figures follow from IEC 61966-2-1 by hand: 1.055·0.5^(1/2.4) − 0.055 = 0.7354, times 255 is
    /// 187.5; 0.18 gives 117.6; 1e-3 lies on the straight part, 12.92e-3·255 = 3.29.
    #[test]
    fn srgb_has_its_known_values() {
        let (bytes, report) = round_trip(&grey(&[0.0, 1e-3, 0.18, 0.5, 1.0]), 0.0);
        let greys: Vec<u8> = bytes.chunks(3).map(|p| p[0]).collect();
        assert_eq!(greys, [0, 3, 118, 188, 255]);
        assert!(report.is_clean());
    }

    #[test]
    fn numbers_outside_of_the_range_have_a_place() {
        let values = [-0.0, -1.0, 2.0, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 1e-45];
        let (bytes, report) = round_trip(&grey(&values), 0.0);
        let greys: Vec<u8> = bytes.chunks(3).map(|p| p[0]).collect();
        assert_eq!(greys, [0, 0, 255, 255, 0, 255, 0]);
        assert!(report.is_clean());
    }

    #[test]
    fn nan_is_magenta_and_counted() {
        let picture = row(&[("R", &[0.5, 0.5]), ("G", &[f32::NAN, 0.5]), ("B", &[0.5, 0.5])]);
        let (bytes, report) = round_trip(&picture, 0.0);
        assert_eq!(bytes, [255, 0, 255, 188, 188, 188]);
        assert_eq!(report, Report { clamped: 0, not_a_number: 1 });
    }

    #[test]
    fn a_stop_doubles() {
        let (bright, _) = round_trip(&grey(&[0.125, 0.0625]), 2.0);
        let (plain, _) = round_trip(&grey(&[0.5, 0.25]), 0.0);
        assert_eq!(bright, plain);
        let (dark, _) = round_trip(&grey(&[1.0, 0.5]), -1.0);
        assert_eq!(dark, plain);
    }

    #[test]
    fn alpha_is_divided_out() {
        let values: &[f32] = &[0.25, 0.5, 0.25];
        let alpha: &[f32] = &[0.5, 1.0, 0.0];
        let picture = row(&[("R", values), ("G", values), ("B", values), ("A", alpha)]);
        let (bytes, _) = round_trip(&picture, 0.0);
        assert_eq!(bytes, [188, 188, 188, 128, 188, 188, 188, 255, 137, 137, 137, 0]);
    }

    #[test]
    fn layers_alone_are_no_png() {
        let mut picture = grey(&[1.0]);
        picture.channels.truncate(2);
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.png");
        let error = write_png(&path, &picture, 0.0).expect_err("no red").to_string();
        let expected = format!(
            "cannot write `{}`: the picture has layers but no colours (expected a name that ends in \
             `.exr`)",
            path.display()
        );
        assert_eq!(error, expected);
        assert!(!path.exists());
    }
}
