//! Cameras of scene files.

use glam::Vec2;

use super::plugins::{Bounds, Build, Category, Default, Kind, Part, Plugin, property};
use super::problem::Issue;
use super::properties::Object;
use crate::camera::{CameraError, Perspective, PerspectiveSettings};
use crate::scene::settings::FilmSettings;

/// Diagonal of the 36 x 24 mm film that focal lengths refer to.
const FILM_DIAGONAL_MM: f64 = 43.266_615_305_567_875;

/// Focal length of cameras without field of view.
const FOCAL_LENGTH: &str = "50mm";

pub(super) static PERSPECTIVE: Plugin = Plugin {
    name: "perspective",
    help: "A pinhole camera that looks along +z, with +y up and +x to the left.",
    properties: &[
        property(
            "to_world",
            Kind::Transform,
            Default::Identity,
            "places the camera; lengths of the axes do not matter",
        ),
        property(
            "fov",
            Kind::Float(Bounds::Positive),
            Default::Absent("as `focal_length`"),
            "in degrees",
        ),
        property(
            "fov_axis",
            Kind::Choice(&["x", "y", "diagonal", "smaller", "larger"]),
            Default::Text("x"),
            "side of the film that `fov` spans",
        ),
        property(
            "focal_length",
            Kind::Text,
            Default::Text(FOCAL_LENGTH),
            "in mm on film of 36 x 24 mm, measured along the diagonal",
        ),
        property(
            "principal_point_offset_x",
            Kind::Float(Bounds::Any),
            Default::Float(0.0),
            "shift of the optical axis, as a fraction of the width",
        ),
        property(
            "principal_point_offset_y",
            Kind::Float(Bounds::Any),
            Default::Float(0.0),
            "shift of the optical axis, as a fraction of the height",
        ),
        property(
            "near_clip",
            Kind::Float(Bounds::NotNegative),
            Default::Float(0.0),
            "what is nearer along the axis is not seen (Mitsuba: 0.01)",
        ),
        property(
            "far_clip",
            Kind::Float(Bounds::Positive),
            Default::Absent("infinity"),
            "what is farther along the axis is not seen (Mitsuba: 10000)",
        ),
    ],
    parts: &[Part::optional(Category::Film), Part::optional(Category::Sampler)],
    build: Build::Sensor(perspective),
};

fn perspective(object: &Object<'_>, film: &FilmSettings) -> Result<Perspective, Issue> {
    let aspect = f64::from(film.width) / f64::from(film.height);
    let settings = PerspectiveSettings {
        to_world: object.transform("to_world"),
        fov_x_deg: fov_x_deg(object, aspect)?,
        aspect,
        principal_point_offset: Vec2::new(
            object.float("principal_point_offset_x") as f32,
            object.float("principal_point_offset_y") as f32,
        ),
        near_clip: object.float("near_clip") as f32,
        far_clip: object.number("far_clip").map_or(f32::INFINITY, |v| v as f32),
    };
    Perspective::new(&settings).map_err(|error| {
        let place = match error {
            CameraError::FieldOfView(_) => object.place_of("fov"),
            CameraError::Singular | CameraError::TooFar(_) => object.place_of("to_world"),
            CameraError::Clip { .. } => object.place_of("near_clip"),
        };
        Issue::new(place, error.to_string())
    })
}

/// The angle across the film's width.
fn fov_x_deg(object: &Object<'_>, aspect: f64) -> Result<f64, Issue> {
    let (fov_deg, axis) = match object.number("fov") {
        Some(fov) => {
            object.refuse(&["focal_length"], "beside `fov`")?;
            (fov, object.choice("fov_axis"))
        }
        None => {
            object.refuse(&["fov_axis"], "without `fov`")?;
            (
                2.0 * (0.5 * FILM_DIAGONAL_MM / focal_length_mm(object)?).atan().to_degrees(),
                "diagonal",
            )
        }
    };
    let wide = aspect > 1.0;
    // Width over the side that the angle spans.
    let ratio = match axis {
        "y" => aspect,
        "smaller" if wide => aspect,
        "larger" if !wide => aspect,
        "diagonal" => 1.0 / (1.0 + 1.0 / (aspect * aspect)).sqrt(),
        _ => 1.0,
    };
    // An angle that needs no conversion, or allows none, is passed on as it is.
    if ratio == 1.0 || fov_deg >= 180.0 {
        return Ok(fov_deg);
    }
    Ok(2.0 * (ratio * (0.5 * fov_deg).to_radians().tan()).atan().to_degrees())
}

fn focal_length_mm(object: &Object<'_>) -> Result<f64, Issue> {
    let text = object.text("focal_length").unwrap_or(FOCAL_LENGTH);
    let number = text.trim().trim_end_matches("mm").trim_end().parse::<f64>().ok();
    number.filter(|&mm| Bounds::Positive.contain(mm)).ok_or_else(|| {
        let message = format!("`{text}` is not a focal length (expected one like {FOCAL_LENGTH})");
        Issue::new(object.place_of("focal_length"), message)
    })
}
