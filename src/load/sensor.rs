//! Cameras of scene files.

use glam::Vec2;

use super::plugins::{Build, Category, Part, Plugin};
use super::problem::Issue;
use super::properties::Object;
use crate::camera::{
    Camera, CameraError, Lens, Orthographic, OrthographicSettings, Perspective, PerspectiveSettings,
};
use crate::film::FilmSettings;
use crate::property::{Bounds, Default, Kind, PropertyInfo, property};
use crate::scene::CameraMotion;

/// Diagonal of the 36 x 24 mm film that focal lengths refer to.
const FILM_DIAGONAL_MM: f64 = 43.266_615_305_567_875;

/// Focal length of cameras without field of view.
const FOCAL_LENGTH: &str = "50mm";

const TO_WORLD: PropertyInfo = property(
    "to_world",
    Kind::Motion,
    Default::Identity,
    "places the camera; lengths of the axes do not matter",
);

const FOV: PropertyInfo = property(
    "fov",
    Kind::Float(Bounds::Positive),
    Default::Absent("as `focal_length`"),
    "in degrees",
);

const FOV_AXIS: PropertyInfo = property(
    "fov_axis",
    Kind::Choice(&["x", "y", "diagonal", "smaller", "larger"]),
    Default::Text("x"),
    "side of the film that `fov` spans",
);

const FOCAL_LENGTH_INFO: PropertyInfo = property(
    "focal_length",
    Kind::Text,
    Default::Text(FOCAL_LENGTH),
    "in mm on film of 36 x 24 mm, measured along the diagonal",
);

const NEAR_CLIP: PropertyInfo = property(
    "near_clip",
    Kind::Float(Bounds::NotNegative),
    Default::Float(0.0),
    "what is nearer along the axis is not seen (Mitsuba: 0.01)",
);

const FAR_CLIP: PropertyInfo = property(
    "far_clip",
    Kind::Float(Bounds::Positive),
    Default::Absent("infinity"),
    "what is farther along the axis is not seen (Mitsuba: 10000)",
);

/// By the clock of the keys of animations.
const SHUTTER_OPEN: PropertyInfo = property(
    "shutter_open",
    Kind::Float(Bounds::Any),
    Default::Float(0.0),
    "when the shutter opens, by the clock of animations",
);

const SHUTTER_CLOSE: PropertyInfo = property(
    "shutter_close",
    Kind::Float(Bounds::Any),
    Default::Float(0.0),
    "when the shutter closes",
);

/// Mitsuba's exporters write it for cameras of all kinds.
const UNUSED_FOCUS_DISTANCE: PropertyInfo = property(
    "focus_distance",
    Kind::Float(Bounds::Positive),
    Default::Absent("everything is sharp"),
    "read and not needed: without a lens all distances are in focus",
);

const PARTS: &[Part] = &[Part::optional(Category::Film), Part::optional(Category::Sampler)];

pub(super) static PERSPECTIVE: Plugin = Plugin {
    name: "perspective",
    help: "A pinhole camera that looks along +z, with +y up and +x to the left.",
    properties: &[
        TO_WORLD,
        FOV,
        FOV_AXIS,
        FOCAL_LENGTH_INFO,
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
        UNUSED_FOCUS_DISTANCE,
        NEAR_CLIP,
        FAR_CLIP,
        SHUTTER_OPEN,
        SHUTTER_CLOSE,
    ],
    parts: PARTS,
    build: Build::Sensor(pinhole),
};

pub(super) static THIN_LENS: Plugin = Plugin {
    name: "thinlens",
    help: "The same with a lens, and so with depth of field.",
    properties: &[
        TO_WORLD,
        FOV,
        FOV_AXIS,
        FOCAL_LENGTH_INFO,
        property(
            "aperture_radius",
            Kind::Float(Bounds::NotNegative),
            Default::Required,
            "of the lens in scene units; with 0 it is a pinhole",
        ),
        property(
            "focus_distance",
            Kind::Float(Bounds::Positive),
            Default::Absent("as `far_clip`"),
            "what is at this distance along the axis is sharp",
        ),
        NEAR_CLIP,
        FAR_CLIP,
        SHUTTER_OPEN,
        SHUTTER_CLOSE,
    ],
    parts: PARTS,
    build: Build::Sensor(thin_lens),
};

pub(super) static ORTHOGRAPHIC: Plugin = Plugin {
    name: "orthographic",
    help: "A camera of parallel rays along +z, with +y up and +x to the left.",
    properties: &[
        property(
            "to_world",
            Kind::Transform,
            Default::Identity,
            "places the camera; the film spans from -1 to 1 along the x axis, so scale by half its width",
        ),
        property(
            "near_clip",
            Kind::Float(Bounds::NotNegative),
            Default::Float(0.0),
            "what is nearer along the axis is not seen, in units of its length (Mitsuba: 0.01)",
        ),
        property(
            "far_clip",
            Kind::Float(Bounds::Positive),
            Default::Absent("infinity"),
            "what is farther by `far_clip - near_clip` from there is not seen (Mitsuba: 10000)",
        ),
        UNUSED_FOCUS_DISTANCE,
        SHUTTER_OPEN,
        SHUTTER_CLOSE,
    ],
    parts: PARTS,
    build: Build::Sensor(orthographic),
};

fn pinhole(object: &Object<'_>, film: &FilmSettings) -> Result<Camera, Issue> {
    let offset = Vec2::new(
        object.float("principal_point_offset_x") as f32,
        object.float("principal_point_offset_y") as f32,
    );
    perspective(object, film, offset, None)
}

fn thin_lens(object: &Object<'_>, film: &FilmSettings) -> Result<Camera, Issue> {
    let lens = Lens {
        aperture_radius: object.float("aperture_radius"),
        focus_distance: object
            .number("focus_distance")
            .or(object.number("far_clip"))
            .unwrap_or(f64::INFINITY),
    };
    perspective(object, film, Vec2::ZERO, Some(lens))
}

fn perspective(
    object: &Object<'_>,
    film: &FilmSettings,
    principal_point_offset: Vec2,
    lens: Option<Lens>,
) -> Result<Camera, Issue> {
    let aspect = aspect(film);
    let (near_clip, far_clip) = clip(object);
    let settings = PerspectiveSettings {
        to_world: object.transform("to_world"),
        fov_x_deg: fov_x_deg(object, aspect)?,
        aspect,
        principal_point_offset,
        lens,
        near_clip,
        far_clip,
    };
    let camera = Perspective::new(&settings).map_err(|error| refused(object, &error))?;
    Ok(Camera::Perspective(camera))
}

fn orthographic(object: &Object<'_>, film: &FilmSettings) -> Result<Camera, Issue> {
    let (near_clip, far_clip) = clip(object);
    let to_world = object.transform("to_world");
    let settings = OrthographicSettings { to_world, aspect: aspect(film), near_clip, far_clip };
    let camera = Orthographic::new(&settings).map_err(|error| refused(object, &error))?;
    Ok(Camera::Orthographic(camera))
}

/// How the camera moves while the shutter is open; `None` if it does not.
///
/// # Errors
/// A shutter that closes before it opens, a map that is singular at some moment, a position too far away.
pub(super) fn motion(object: &Object<'_>) -> Result<Option<CameraMotion>, Issue> {
    let (open, close) = (object.float("shutter_open"), object.float("shutter_close"));
    if close < open {
        let message = format!("the shutter closes at {close}, before it opens at {open}");
        return Err(Issue::new(object.place_of("shutter_close"), message));
    }
    let motion = object.motion("to_world").map(CameraMotion::new).transpose();
    motion.map_err(|error| refused(object, &error))
}

/// Width over height.
fn aspect(film: &FilmSettings) -> f64 {
    f64::from(film.width) / f64::from(film.height)
}

fn clip(object: &Object<'_>) -> (f32, f32) {
    let far = object.number("far_clip").map_or(f32::INFINITY, |v| v as f32);
    (object.float("near_clip") as f32, far)
}

fn refused(object: &Object<'_>, error: &CameraError) -> Issue {
    let place = match (error, object.plugin().name) {
        (CameraError::FieldOfView(_), _) => object.place_of("fov"),
        (CameraError::Lens { .. }, _) | (CameraError::TooWide(_), "thinlens") => {
            object.place_of("aperture_radius")
        }
        (CameraError::Singular | CameraError::TooFar(_) | CameraError::TooWide(_), _) => {
            object.place_of("to_world")
        }
        (CameraError::Clip { .. }, _) => object.place_of("near_clip"),
    };
    Issue::new(place, error.to_string())
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
