//! Tests of the loader as a whole. Text is loaded from memory; only `format.rs` and `meshes.rs` write
//! files, where several of them are what is tested.

use std::path::Path;

use super::{LoadError, LoadOptions, Loaded, load_text};
use crate::render::Description;

mod effects;
mod format;
mod hostile;
mod meanings;
mod meshes;
mod messages;
mod nori;
mod ranges;
mod sharing;
mod textures;

const SENSOR: &str = "<sensor type=\"perspective\"/>";

fn load(text: &str) -> Result<Loaded, LoadError> {
    load_text(text, Path::new("scene.xml"), &LoadOptions::default())
}

/// The description of a scene with this content and a sensor.
fn description(content: &str) -> Description {
    let text = format!("<scene version=\"3.0.0\">{content}{SENSOR}</scene>");
    load(&text).unwrap_or_else(|e| panic!("{text}\n{e}")).description
}
