//! Films and reconstruction filters of scene files.

use super::plugins::{self, Build, Category, Part, Plugin};
use super::problem::Issue;
use super::properties::Object;
use crate::film::filter::{self, About};
use crate::film::{ComponentFormat, Crop, FilmSettings};
use crate::property::{Default, Kind, PropertyInfo, property};

/// Pixels along one side: what an EXR viewer can be expected to open.
const MOST_PIXELS: i64 = 1 << 20;

const fn offset(name: &'static str, help: &'static str) -> PropertyInfo {
    property(name, Kind::Integer(0, MOST_PIXELS), Default::Integer(0), help)
}

const fn crop_size(name: &'static str, help: &'static str) -> PropertyInfo {
    property(name, Kind::Integer(1, MOST_PIXELS), Default::Absent("up to the film's edge"), help)
}

pub(super) static HDRFILM: Plugin = Plugin {
    name: "hdrfilm",
    help: "The picture's size and format. Its filter is drawn from, not splatted, so borders and sums need \
           no options of their own.",
    properties: &[
        property("width", Kind::Integer(1, MOST_PIXELS), Default::Integer(768), "in pixels"),
        property("height", Kind::Integer(1, MOST_PIXELS), Default::Integer(576), "in pixels"),
        offset("crop_offset_x", "first column that is rendered"),
        offset("crop_offset_y", "first row that is rendered, from the top"),
        crop_size("crop_width", "columns that are rendered"),
        crop_size("crop_height", "rows that are rendered"),
        property(
            "pixel_format",
            Kind::Choice(&["rgb", "rgba"]),
            Default::Text("rgb"),
            "rgba adds the fraction of camera rays that hit something",
        ),
        property(
            "component_format",
            Kind::Choice(&["float16", "float32"]),
            Default::Text("float16"),
            "precision of colours in the file; one with layers has 32 bits throughout",
        ),
        property(
            "file_format",
            Kind::Choice(&["openexr"]),
            Default::Text("openexr"),
            "of the file",
        ),
        property(
            "sample_border",
            Kind::Boolean,
            Default::Boolean(false),
            "read and not needed: pixels at the border get what all others get",
        ),
        property(
            "compensate",
            Kind::Boolean,
            Default::Boolean(false),
            "read and not needed: sums are always kept precisely",
        ),
        property(
            "banner",
            Kind::Boolean,
            Default::Boolean(false),
            "read and not needed: pictures have none, as in Mitsuba 3",
        ),
    ],
    parts: &[Part::optional(Category::Filter)],
    build: Build::Film(film),
};

/// The filters.
pub(super) fn filters() -> impl Iterator<Item = Plugin> {
    filter::KINDS.iter().map(|kind| {
        let &About { name, help, properties, .. } = kind;
        Plugin { name, help, properties, parts: &[], build: Build::Filter(kind) }
    })
}

/// The one of films that have none.
fn default_filter() -> &'static Plugin {
    plugins::find(Category::Filter, filter::GAUSSIAN.name).expect("one of them")
}

fn film(object: &Object<'_>) -> Result<FilmSettings, Issue> {
    let (width, height) = (object.count("width"), object.count("height"));
    if u64::from(width) * u64::from(height) > u64::from(u32::MAX) {
        let message =
            format!("a film of {width} x {height} pixels is too large (expected less than 2^32)");
        return Err(Issue::new(object.place(), message));
    }
    let filter = object.part_or(Category::Filter, default_filter());
    let Build::Filter(kind) = filter.plugin().build else {
        unreachable!("parts are of the category asked for")
    };
    Ok(FilmSettings {
        width,
        height,
        crop: crop(object, width, height)?,
        filter: kind.read(&filter),
        alpha: object.choice("pixel_format") == "rgba",
        component: match object.choice("component_format") {
            "float32" => ComponentFormat::Float,
            _ => ComponentFormat::Half,
        },
        variance: false,
        clamp: None,
    })
}

fn crop(object: &Object<'_>, width: u32, height: u32) -> Result<Crop, Issue> {
    let (x, y) = (object.count("crop_offset_x"), object.count("crop_offset_y"));
    let size = |name, whole: u32, offset| {
        if object.has(name) { object.count(name) } else { whole.saturating_sub(offset) }
    };
    let crop =
        Crop { x, y, width: size("crop_width", width, x), height: size("crop_height", height, y) };
    // Each is at most 2^20, so the sums do not overflow.
    let inside = crop.x + crop.width <= width && crop.y + crop.height <= height;
    if inside && crop.width > 0 && crop.height > 0 {
        return Ok(crop);
    }
    let Crop { x, y, width: w, height: h } = crop;
    let message = format!(
        "a crop of {w} x {h} pixels at ({x}, {y}) does not fit a film of {width} x {height}"
    );
    Err(Issue::new(object.place(), message))
}
