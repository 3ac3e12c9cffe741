//! OpenEXR files: all channels in one part, as computed.

use std::path::Path;
use std::time::Duration;

use exr::meta::attribute::{AttributeValue, Chromaticities, IntegerBounds};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LineOrder,
    SmallVec, Text, Vec2, WritableImage, f16,
};

use super::ComponentFormat;
use super::atomic_file::write_atomically;
use super::error::Estimate;
use super::output::{OutputError, Report, check_shape};
use super::picture::{Channel, Picture, Values};

/// Names that OpenEXR readers accept without a flag in the file, in bytes; and with it.
const SHORT_NAME: usize = 31;
const LONGEST_NAME: usize = 255;

/// How a picture came about. It is stored in the file's header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata {
    /// Name of the scene file.
    pub scene: String,
    /// Kind of the random numbers.
    pub sampler: String,
    /// Their seed.
    pub seed: u64,
    /// Smallest and largest number of samples that any pixel has.
    pub samples_per_pixel: (u32, u32),
    /// Time to load the scene.
    pub load: Duration,
    /// Time to build the engine.
    pub build: Duration,
    /// Time to render.
    pub render: Duration,
    /// The engine with its version.
    pub backend: String,
    /// The picture's relMSE, if it was estimated.
    pub rel_mse: Option<Estimate>,
    /// Its noise level likewise.
    pub noise_level: Option<Estimate>,
}

/// Writes all channels to an OpenEXR file, compressed without loss (ZIP). The crop becomes the data
/// window, the film the display window.
///
/// A picture with other channels than colours is written in 32 bits throughout: their range and precision is
/// not that of halves, and there are readers, such as Mitsuba's, that take all channels of a file as they take
/// the first.
///
/// Colours in half precision that are beyond its range (from 65520 on they would be rounded to
/// infinity) are clamped and counted; NaN is kept and counted.
///
/// # Errors
/// Channel names that are empty, too long or alike; what the operating system refuses.
pub fn write_exr(
    path: &Path,
    picture: &Picture,
    metadata: &Metadata,
) -> Result<Report, OutputError> {
    check_shape(path, picture)?;
    let unfit = |reason| OutputError::Unfit { path: path.to_owned(), reason };
    check_names(&picture.channels).map_err(unfit)?;
    let mut report = Report::default();
    let only_colors = picture.channels.iter().all(|c| matches!(c.values, Values::Color(_)));
    let component = if only_colors { picture.component } else { ComponentFormat::Float };
    let channels: SmallVec<_> = picture
        .channels
        .iter()
        .map(|c| AnyChannel::new(text(&c.name), samples(&c.values, component, &mut report)))
        .collect();
    let crop = picture.crop;
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new(
        (crop.width as usize, crop.height as usize),
        layer_attributes(picture, metadata),
        encoding,
        AnyChannels::sort(channels),
    );
    let image = Image::empty(image_attributes(picture)).with_layer(layer);
    write_atomically(path, |writer| {
        image.write().to_buffered(writer).map_err(|e| match e {
            exr::error::Error::Io(error) => OutputError::Io { path: path.to_owned(), error },
            other => unfit(other.to_string()),
        })
    })?;
    Ok(report)
}

/// Refuses names that readers of the file could not tell apart or take whole.
fn check_names(channels: &[Channel]) -> Result<(), String> {
    let mut names: Vec<_> = channels.iter().map(|c| c.name.as_str()).collect();
    names.sort_unstable();
    if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(format!("there are two channels `{}`", twice[0]));
    }
    match names.iter().find(|n| n.is_empty() || n.len() > LONGEST_NAME || n.contains('\0')) {
        Some(name) => Err(format!(
            "no channel can be named `{}` (expected 1 to {LONGEST_NAME} bytes, none of them zero)",
            name.escape_debug()
        )),
        None => Ok(()),
    }
}

/// UTF-8, as OpenEXR has it. (The crate's own conversion is Latin-1, and panics at the rest.)
fn text(string: &str) -> Text {
    Text::from_slice_unchecked(string.as_bytes())
}

fn samples(values: &Values, component: ComponentFormat, report: &mut Report) -> FlatSamples {
    if let Values::Color(values) | Values::Float(values) = values {
        report.not_a_number += values.iter().filter(|v| v.is_nan()).count();
    }
    match (values, component) {
        (Values::Color(values), ComponentFormat::Half) => {
            FlatSamples::F16(values.iter().map(|&v| to_half(v, &mut report.clamped)).collect())
        }
        (Values::Color(values) | Values::Float(values), _) => FlatSamples::F32(values.clone()),
        (Values::Index(values), _) => FlatSamples::U32(values.clone()),
    }
}

/// The nearest half float, never infinite.
fn to_half(value: f32, clamped: &mut usize) -> f16 {
    let half = f16::from_f32(value);
    if !half.is_infinite() {
        return half;
    }
    *clamped += 1;
    if value > 0.0 { f16::MAX } else { f16::MIN }
}

fn image_attributes(picture: &Picture) -> ImageAttributes {
    let size = Vec2(picture.width as usize, picture.height as usize);
    let mut attributes = ImageAttributes::new(IntegerBounds::from_dimensions(size));
    // Rec. 709 primaries and D65: linear sRGB.
    attributes.chromaticities = Some(Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.30, 0.60),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.3290),
    });
    attributes
}

/// The position of the crop, and the metadata under pbrt's names where it has some.
fn layer_attributes(picture: &Picture, metadata: &Metadata) -> LayerAttributes {
    let Metadata { scene, sampler, seed, samples_per_pixel: (least, most), backend, .. } = metadata;
    let string = |s: &str| AttributeValue::Text(text(s));
    let seconds = |d: Duration| AttributeValue::F32(d.as_secs_f32());
    let count = |n: u32| AttributeValue::I32(i32::try_from(n).unwrap_or(i32::MAX));
    let mut attributes = LayerAttributes {
        software_name: Some(text(concat!("telamon ", env!("CARGO_PKG_VERSION")))),
        // A crop that leaves the range of i32 is part of a film that no computer holds.
        layer_position: Vec2(picture.crop.x as i32, picture.crop.y as i32),
        ..LayerAttributes::default()
    };
    attributes.other.extend([
        (text("scene"), string(scene)),
        (text("sampler"), string(sampler)),
        // A string, since OpenEXR has no integers of 64 bits.
        (text("seed"), string(&seed.to_string())),
        (text("samplesPerPixel"), count(*least)),
        (text("largestSamplesPerPixel"), count(*most)),
        (text("loadTimeSeconds"), seconds(metadata.load)),
        (text("buildTimeSeconds"), seconds(metadata.build)),
        (text("renderTimeSeconds"), seconds(metadata.render)),
        (text("backend"), string(backend)),
    ]);
    for (name, estimate) in [("relMSE", metadata.rel_mse), ("noiseLevel", metadata.noise_level)] {
        let number = |value: f64| AttributeValue::F32(value as f32);
        attributes.other.extend(estimate.into_iter().flat_map(|e| {
            [(text(name), number(e.value)), (text(&format!("{name}Bound")), number(e.bound))]
        }));
    }
    if picture.channels.iter().any(|c| c.name.len() > SHORT_NAME) {
        // The crate sets the file's flag for long names by the names of attributes alone.
        attributes.other.insert(text("hasChannelNamesOfMoreThan31Bytes"), count(1));
    }
    attributes
}

#[cfg(test)]
mod tests {
    use exr::prelude::read_first_flat_layer_from_file;

    use super::*;
    use crate::film::Crop;

    fn picture(component: ComponentFormat, channels: Vec<Channel>) -> Picture {
        let crop = Crop { x: 2, y: 1, width: 2, height: 2 };
        Picture { width: 5, height: 4, crop, channels, component }
    }

    fn color(name: &str, values: [f32; 4]) -> Channel {
        Channel::new(name, Values::Color(values.to_vec()))
    }

    type FlatImage = Image<Layer<AnyChannels<FlatSamples>>>;

    fn round_trip(picture: &Picture) -> (FlatImage, Report) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.exr");
        let metadata = Metadata {
            scene: "scènes/a.xml".to_owned(),
            sampler: "sobol".to_owned(),
            seed: u64::MAX,
            samples_per_pixel: (3, 4),
            render: Duration::from_millis(1500),
            backend: "Rust BVH".to_owned(),
            rel_mse: Some(Estimate { value: 0.25, bound: f64::INFINITY }),
            ..Metadata::default()
        };
        let report = write_exr(&path, picture, &metadata).expect("writable");
        (read_first_flat_layer_from_file(&path).expect("readable"), report)
    }

    fn channel<'a>(image: &'a FlatImage, name: &str) -> &'a FlatSamples {
        let mut channels = image.layer_data.channel_data.list.iter();
        &channels.find(|c| c.name.as_slice() == name.as_bytes()).expect("there").sample_data
    }

    #[test]
    fn what_is_written_is_read_back() {
        let indices = vec![0, 1, 16_777_217, u32::MAX];
        let depths = vec![1.0, 1e-30, 1e30, f32::MAX];
        let long = "a".repeat(200) + ".T";
        let channels = vec![
            color("R", [0.25, -1.0, 0.0, 2.0]),
            color("G", [0.5; 4]),
            color("B", [0.75; 4]),
            Channel::new("zählung.I", Values::Index(indices.clone())),
            Channel::new(long.as_str(), Values::Float(depths.clone())),
        ];
        for component in [ComponentFormat::Half, ComponentFormat::Float] {
            let (image, report) = round_trip(&picture(component, channels.clone()));
            assert!(report.is_clean());
            let red = [0.25, -1.0, 0.0, 2.0];
            // Of a picture with layers everything is.
            assert_eq!(channel(&image, "R"), &FlatSamples::F32(red.to_vec()));
            let (colors, _) = round_trip(&picture(component, channels[..3].to_vec()));
            let expected = match component {
                ComponentFormat::Half => FlatSamples::F16(red.map(f16::from_f32).to_vec()),
                ComponentFormat::Float => FlatSamples::F32(red.to_vec()),
            };
            assert_eq!(channel(&colors, "R"), &expected);
            assert_eq!(channel(&image, &long), &FlatSamples::F32(depths.clone()));
            assert_eq!(channel(&image, "zählung.I"), &FlatSamples::U32(indices.clone()));
        }
    }

    #[test]
    fn the_header_says_where_and_how() {
        let (image, _) = round_trip(&picture(ComponentFormat::Half, vec![color("R", [0.0; 4])]));
        assert_eq!(image.attributes.display_window.size, Vec2(5, 4));
        let layer = &image.layer_data;
        assert_eq!((layer.attributes.layer_position, layer.size), (Vec2(2, 1), Vec2(2, 2)));
        assert_eq!(layer.encoding.compression, Compression::ZIP16);
        let software = layer.attributes.software_name.as_ref().expect("there").to_string();
        assert_eq!(software, format!("telamon {}", env!("CARGO_PKG_VERSION")));
        let other = |name: &str| layer.attributes.other.get(&text(name)).cloned();
        assert_eq!(other("scene"), Some(AttributeValue::Text(text("scènes/a.xml"))));
        assert_eq!(other("sampler"), Some(AttributeValue::Text(text("sobol"))));
        assert_eq!(other("seed"), Some(AttributeValue::Text(text("18446744073709551615"))));
        assert_eq!(other("samplesPerPixel"), Some(AttributeValue::I32(3)));
        assert_eq!(other("largestSamplesPerPixel"), Some(AttributeValue::I32(4)));
        assert_eq!(other("loadTimeSeconds"), Some(AttributeValue::F32(0.0)));
        assert_eq!(other("buildTimeSeconds"), Some(AttributeValue::F32(0.0)));
        assert_eq!(other("renderTimeSeconds"), Some(AttributeValue::F32(1.5)));
        assert_eq!(other("relMSE"), Some(AttributeValue::F32(0.25)));
        assert_eq!(other("relMSEBound"), Some(AttributeValue::F32(f32::INFINITY)));
        assert_eq!(other("noiseLevel"), None);
        assert_eq!(other("backend"), Some(AttributeValue::Text(text("Rust BVH"))));
    }

    /// 65504 is the largest half float, and everything below 65520 is rounded to it.
    #[test]
    fn halves_are_clamped_and_counted() {
        for (value, stored, counted) in [
            (65504.0, 65504.0, 0),
            (65519.996, 65504.0, 0),
            (65520.0, 65504.0, 1),
            (f32::MAX, 65504.0, 1),
            (f32::INFINITY, 65504.0, 1),
            (-1e5, -65504.0, 1),
        ] {
            let mut clamped = 0;
            assert_eq!(to_half(value, &mut clamped).to_f32(), stored, "{value}");
            assert_eq!(clamped, counted, "{value}");
        }
        let channels = vec![color("R", [1e5, -1e5, f32::NAN, 1.0]), color("G", [f32::NAN; 4])];
        let (image, report) = round_trip(&picture(ComponentFormat::Half, channels.clone()));
        assert_eq!(report, Report { clamped: 2, not_a_number: 5 });
        let FlatSamples::F16(green) = channel(&image, "G") else { panic!("half was asked for") };
        assert!(green.iter().all(|v| v.is_nan()), "NaN is never painted over");
        // Nothing has to be clamped in 32 bits.
        let (_, report) = round_trip(&picture(ComponentFormat::Float, channels));
        assert_eq!(report, Report { clamped: 0, not_a_number: 5 });
    }

    #[test]
    fn names_that_do_not_fit_are_refused() {
        let refused = |names: &[&str]| {
            let channels = names.iter().map(|n| color(n, [0.0; 4])).collect();
            let path = Path::new("a.exr");
            let picture = picture(ComponentFormat::Half, channels);
            write_exr(path, &picture, &Metadata::default()).expect_err("refused").to_string()
        };
        assert_eq!(refused(&["R", "x", "R"]), "cannot write `a.exr`: there are two channels `R`");
        assert_eq!(
            refused(&["a\0b"]),
            "cannot write `a.exr`: no channel can be named `a\\0b` (expected 1 to 255 bytes, none of \
             them zero)"
        );
        assert!(refused(&["R", ""]).contains("no channel can be named ``"));
        assert!(refused(&[&"x".repeat(256)]).contains("expected 1 to 255 bytes"));
        assert_eq!(refused(&[]), "cannot write `a.exr`: the picture is empty");
    }

    #[test]
    fn channels_must_cover_the_crop() {
        let channels = vec![Channel::new("depth.T", Values::Float(vec![0.0; 3]))];
        let picture = picture(ComponentFormat::Half, channels);
        let error = write_exr(Path::new("a.exr"), &picture, &Metadata::default());
        assert_eq!(
            error.expect_err("refused").to_string(),
            "cannot write `a.exr`: channel `depth.T` has 3 of 4 pixels"
        );
    }
}
