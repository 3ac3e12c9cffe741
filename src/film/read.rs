//! OpenEXR files in: pictures that others are to be compared with.

use std::fs;
use std::io::{self, Cursor};
use std::path::{Path, PathBuf};

use exr::meta::MetaData;
use exr::prelude::{AttributeValue, FlatSamples, ReadChannels, ReadLayers, Text, read};

use super::exr_size::{PromiseError, promised_bytes};
use super::picture::{Channel, Picture, Values};
use super::{ComponentFormat, Crop};

/// Why a picture cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// The operating system refuses.
    #[error("cannot read `{path}`: {error}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Its reason.
        error: io::Error,
    },
    /// It is no OpenEXR file, or one with parts that are not supported.
    #[error("cannot read `{path}`: {reason} (expected an OpenEXR file)")]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
}

/// Reads all channels of the first part of an OpenEXR file; of several levels of detail the finest.
///
/// `R`, `G`, `B` and `A` become colours, in the precision of `R`; 16-bit numbers of other channels are
/// widened. The data window becomes the crop, the display window the film.
///
/// # Errors
/// What the operating system refuses; what is no OpenEXR file; a data window that leaves the display window.
pub fn read_exr(path: &Path) -> Result<Picture, InputError> {
    let malformed = |reason| InputError::Malformed { path: path.to_owned(), reason };
    let io = |error| InputError::Io { path: path.to_owned(), error };
    let bytes = fs::read(path).map_err(io)?;
    let refused = |error| match error {
        exr::error::Error::Io(error) => io(error),
        exr::error::Error::Invalid(reason) => malformed(reason.into_owned()),
        other => malformed(other.to_string()),
    };
    promised_bytes(&bytes).map_err(|error| match error {
        PromiseError::Malformed(error) => refused(error),
        PromiseError::TooSmall { .. } => malformed(format!("it {error}")),
    })?;
    let reader = read().no_deep_data().largest_resolution_level().all_channels();
    // All of them, because to read one alone the crate trusts the table of offsets to lead to its blocks.
    let reader = reader.all_layers().all_attributes();
    let image = reader.from_buffered(Cursor::new(bytes)).map_err(refused)?;
    let display = image.attributes.display_window;
    let Some(layer) = image.layer_data.into_iter().next() else {
        return Err(malformed("it has no part".to_owned()));
    };
    let offset = layer.attributes.layer_position - display.position;
    let number = |n: usize| u32::try_from(n).ok();
    let crop = || {
        let (x, y) = (u32::try_from(offset.x()).ok()?, u32::try_from(offset.y()).ok()?);
        Some(Crop { x, y, width: number(layer.size.x())?, height: number(layer.size.y())? })
    };
    let film = number(display.size.x()).zip(number(display.size.y()));
    let (Some(crop), Some((width, height))) = (crop(), film) else {
        return Err(malformed("its data window leaves its display window".to_owned()));
    };
    let end = |start: u32, length: u32| u64::from(start) + u64::from(length);
    if end(crop.x, crop.width) > width.into() || end(crop.y, crop.height) > height.into() {
        return Err(malformed("its data window leaves its display window".to_owned()));
    }
    let mut component = ComponentFormat::Float;
    let mut channels = Vec::new();
    for channel in layer.channel_data.list {
        let name = String::from_utf8_lossy(channel.name.as_slice()).into_owned();
        let is_color = matches!(name.as_str(), "R" | "G" | "B" | "A");
        if name == "R" && matches!(channel.sample_data, FlatSamples::F16(_)) {
            component = ComponentFormat::Half;
        }
        let numbers = match channel.sample_data {
            FlatSamples::F16(values) => values.into_iter().map(|v| v.to_f32()).collect(),
            FlatSamples::F32(values) => values,
            FlatSamples::U32(values) => {
                channels.push(Channel::new(name, Values::Index(values)));
                continue;
            }
        };
        let values = if is_color { Values::Color(numbers) } else { Values::Float(numbers) };
        channels.push(Channel::new(name, values));
    }
    let picture = Picture { width, height, crop, channels, component };
    match picture.channels.iter().find(|c| c.values.len() != picture.pixels()) {
        Some(channel) => Err(malformed(format!(
            "channel `{}` has {} of {} pixels",
            channel.name,
            channel.values.len(),
            picture.pixels()
        ))),
        None => Ok(picture),
    }
}

/// The sampler that an OpenEXR file of this renderer says it was rendered with.
#[must_use]
pub fn sampler(path: &Path) -> Option<String> {
    let headers = MetaData::read_from_file(path, false).ok()?.headers;
    match headers.first()?.own_attributes.other.get(&Text::from("sampler")) {
        Some(AttributeValue::Text(name)) => Some(name.to_string()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::exr::{Metadata, write_exr};

    #[test]
    fn what_was_written_is_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.exr");
        let numbers = [0.25, -1.0, 0.0, 2.0, 3.0, 4.0];
        // Sorted, as files have them.
        let mut picture = Picture {
            width: 5,
            height: 4,
            crop: Crop { x: 2, y: 1, width: 3, height: 2 },
            channels: vec![
                Channel::new("B", Values::Color(numbers.to_vec())),
                Channel::new("G", Values::Color(numbers.to_vec())),
                Channel::new("R", Values::Color(numbers.to_vec())),
                Channel::new("größe.T", Values::Float(numbers.map(|n| n * 1e-30).to_vec())),
                Channel::new("samples.N", Values::Index(vec![0, 1, 2, 3, 4, u32::MAX])),
            ],
            component: ComponentFormat::Half,
        };
        for component in [ComponentFormat::Half, ComponentFormat::Float] {
            picture.component = component;
            let metadata = Metadata { sampler: "sobol".to_owned(), ..Metadata::default() };
            write_exr(&path, &picture, &metadata).expect("writable");
            // A file with layers has 32 bits throughout.
            let expected = Picture { component: ComponentFormat::Float, ..picture.clone() };
            assert_eq!(read_exr(&path).expect("readable"), expected);
            assert_eq!(sampler(&path).as_deref(), Some("sobol"));
            let mut colors = picture.clone();
            colors.channels.truncate(3);
            write_exr(&path, &colors, &metadata).expect("writable");
            assert_eq!(read_exr(&path).expect("readable"), colors);
        }
    }

    #[test]
    fn what_cannot_be_read_is_said() {
        let folder = tempfile::tempdir().expect("a folder");
        let message = |name: &str| {
            let path = folder.path().join(name);
            let text = read_exr(&path).expect_err("not readable").to_string();
            text.replace(&format!("{}/", folder.path().display()), "")
        };
        assert_eq!(
            message("none.exr"),
            "cannot read `none.exr`: No such file or directory (os error 2)"
        );
        assert_eq!(sampler(&folder.path().join("none.exr")), None);
        fs::write(folder.path().join("a.exr"), "no picture at all").expect("writable");
        assert_eq!(
            message("a.exr"),
            "cannot read `a.exr`: file identifier missing (expected an OpenEXR file)"
        );
    }
}
