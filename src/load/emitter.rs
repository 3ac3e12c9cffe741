//! Lights of scene files.

use glam::{Affine2, DMat3, DVec3, Mat3A, Vec3A};

use super::plugins::{Build, Plugin};
use super::problem::Issue;
use super::properties::Object;
use crate::emitter::spot::SpotSettings;
use crate::emitter::{Constant, Directional, Emitter, EnvironmentMap, Point, Spot};
use crate::math::Rgb;
use crate::property::{Bounds, Default, Kind, PropertyInfo, property};
use crate::texture::bitmap::{BitmapFilter, BitmapSettings, Encoding, Wrap};
use crate::texture::{Bitmap, Textured};

/// A light, as far as its object alone describes it.
#[derive(Debug)]
pub(super) enum Light {
    /// Emission of the shape that it stands in.
    Area(Textured<Rgb>),
    /// Light from all directions outside of the scene.
    Environment(Box<dyn Emitter>),
    /// A light that no ray hits.
    Unseen(Box<dyn Emitter>),
}

const RADIANCE: PropertyInfo =
    property("radiance", Kind::Rgb(Bounds::NotNegative), Default::Grey(1.0), "in W/(m² sr)");

pub(super) static AREA: Plugin = Plugin {
    name: "area",
    help: "Light from the front of the shape that it stands in.",
    properties: &[property(
        "radiance",
        Kind::RgbTexture(Bounds::NotNegative),
        Default::Grey(1.0),
        "in W/(m² sr)",
    )],
    parts: &[],
    build: Build::Emitter(|object| Ok(Light::Area(object.rgb_texture("radiance")?))),
};

pub(super) static CONSTANT: Plugin = Plugin {
    name: "constant",
    help: "The same light from all directions outside the scene.",
    properties: &[RADIANCE],
    parts: &[],
    build: Build::Emitter(|object| {
        Ok(Light::Environment(Box::new(Constant::new(object.rgb("radiance")))))
    }),
};

pub(super) static ENVIRONMENT_MAP: Plugin = Plugin {
    name: "envmap",
    help: "Light from all directions outside the scene, by a picture in longitude and latitude.",
    properties: &[
        property("filename", Kind::File, Default::Required, "the image file; its top is +y"),
        property("scale", Kind::Float(Bounds::NotNegative), Default::Float(1.0), "a factor"),
        property(
            "to_world",
            Kind::Transform,
            Default::Identity,
            "turns or mirrors it; where it is moved to is of no matter",
        ),
        property(
            "mis_compensation",
            Kind::Boolean,
            Default::Boolean(false),
            "read and not needed: it is about noise",
        ),
    ],
    parts: &[],
    build: Build::Emitter(environment_map),
};

pub(super) static DIRECTIONAL: Plugin = Plugin {
    name: "directional",
    help: "Parallel light from outside the scene.",
    properties: &[
        property(
            "irradiance",
            Kind::Rgb(Bounds::NotNegative),
            Default::Grey(1.0),
            "on a surface across, in W/m²",
        ),
        property(
            "direction",
            Kind::Point,
            Default::Absent("0, 0, 1 by `to_world`"),
            "where the light travels to",
        ),
        property(
            "to_world",
            Kind::Transform,
            Default::Identity,
            "maps +z to where the light travels to",
        ),
    ],
    parts: &[],
    build: Build::Emitter(directional),
};

pub(super) static POINT: Plugin = Plugin {
    name: "point",
    help: "The same light in all directions from a point.",
    properties: &[
        property("intensity", Kind::Rgb(Bounds::NotNegative), Default::Grey(1.0), "in W/sr"),
        property("position", Kind::Point, Default::Origin, "where it is"),
        property("to_world", Kind::Transform, Default::Identity, "maps the origin to where it is"),
    ],
    parts: &[],
    build: Build::Emitter(point),
};

pub(super) static SPOT: Plugin = Plugin {
    name: "spot",
    help: "Light from a point into a cone along +z.",
    properties: &[
        property(
            "intensity",
            Kind::Rgb(Bounds::NotNegative),
            Default::Grey(1.0),
            "inside the beam, in W/sr",
        ),
        property(
            "cutoff_angle",
            Kind::Float(Bounds::Positive),
            Default::Float(20.0),
            "half angle of the cone, in degrees",
        ),
        property(
            "beam_width",
            Kind::Float(Bounds::NotNegative),
            Default::Absent("3/4 of `cutoff_angle`"),
            "half angle up to which the intensity is full, in degrees",
        ),
        property(
            "texture",
            Kind::RgbTexture(Bounds::NotNegative),
            Default::Grey(1.0),
            "a factor, over the square around the cone",
        ),
        property(
            "to_world",
            Kind::Transform,
            Default::Identity,
            "moves and turns it, or mirrors it",
        ),
    ],
    parts: &[],
    build: Build::Emitter(spot),
};

/// The light that an object describes.
///
/// # Errors
/// A combination that makes no sense.
pub(super) fn build(object: &Object<'_>) -> Result<Light, Issue> {
    match object.plugin().build {
        Build::Emitter(build) => build(object),
        _ => unreachable!("callers pass emitters"),
    }
}

fn point(object: &Object<'_>) -> Result<Light, Issue> {
    if object.has("position") {
        object.refuse(&["to_world"], "beside `position`")?;
    }
    let position = if object.has("to_world") {
        object.transform("to_world").translation
    } else {
        object.point("position")
    };
    let position = narrow_position(object, position)?;
    Ok(Light::Unseen(Box::new(Point::new(position, object.rgb("intensity")))))
}

fn narrow_position(object: &Object<'_>, position: DVec3) -> Result<Vec3A, Issue> {
    let position = position.as_vec3a();
    if position.is_finite() {
        return Ok(position);
    }
    Err(Issue::new(object.place(), "the light is farther away than an f32 can hold"))
}

fn environment_map(object: &Object<'_>) -> Result<Light, Issue> {
    let settings = BitmapSettings {
        encoding: Encoding::Srgb,
        filter: BitmapFilter::Bilinear,
        wrap: Wrap::Clamp,
        to_uv: Affine2::IDENTITY,
    };
    let picture = Bitmap::new(object.image("filename")?, settings);
    let map = EnvironmentMap::new(picture, object.float("scale") as f32, axes(object)?);
    let map = map.ok_or_else(|| {
        Issue::new(object.place_of("scale"), "`scale` makes more of a pixel than an f32 can hold")
    })?;
    if map.has_negative() {
        let message = "there are pixels below 0, which count as 0";
        object.warn(Issue::new(object.place_of("filename"), message));
    }
    Ok(Light::Environment(Box::new(map)))
}

fn directional(object: &Object<'_>) -> Result<Light, Issue> {
    let (name, direction) = if object.has("direction") {
        object.refuse(&["to_world"], "beside `direction`")?;
        ("direction", object.point("direction"))
    } else {
        ("to_world", object.transform("to_world").matrix3.z_axis)
    };
    // Divided first: the square of a length may be no f64.
    let direction = (direction / direction.abs().max_element()).normalize().as_vec3a();
    if !direction.is_finite() {
        return Err(Issue::new(object.place_of(name), format!("`{name}` gives no direction")));
    }
    Ok(Light::Unseen(Box::new(Directional::new(direction, object.rgb("irradiance")))))
}

fn spot(object: &Object<'_>) -> Result<Light, Issue> {
    let cutoff_angle = object.float("cutoff_angle");
    let beam_width = object.number("beam_width").unwrap_or(0.75 * cutoff_angle);
    let texture = object.rgb_texture("texture")?;
    let (fits, expected) = if texture.varies() {
        (cutoff_angle < 90.0, "less than 90 with a texture")
    } else {
        (cutoff_angle <= 180.0, "at most 180")
    };
    if !fits {
        let message = format!("`cutoff_angle` is {cutoff_angle} degrees (expected {expected})");
        return Err(Issue::new(object.place_of("cutoff_angle"), message));
    }
    if beam_width > cutoff_angle {
        let message = format!(
            "`beam_width` is {beam_width} degrees (expected at most the cutoff angle, {cutoff_angle})"
        );
        return Err(Issue::new(object.place_of("beam_width"), message));
    }
    Ok(Light::Unseen(Box::new(Spot::new(SpotSettings {
        position: narrow_position(object, object.transform("to_world").translation)?,
        axes: axes(object)?,
        intensity: object.rgb("intensity"),
        cutoff_angle: cutoff_angle.to_radians(),
        beam_width: beam_width.to_radians(),
        texture,
    }))))
}

/// How far the axes of a map that only turns may be from orthonormal: files have them with four digits.
const ROUNDED_AXES: f64 = 1e-3;

/// The axes of `to_world`, made orthonormal.
fn axes(object: &Object<'_>) -> Result<Mat3A, Issue> {
    let axes = object.transform("to_world").matrix3;
    let off = (axes.transpose() * axes - DMat3::IDENTITY).to_cols_array();
    if !off.into_iter().all(|v| v.abs() <= ROUNDED_AXES) {
        let message = "`to_world` stretches directions (expected that it turns or mirrors them)";
        return Err(Issue::new(object.place_of("to_world"), message));
    }
    let z = axes.z_axis.normalize();
    let x = axes.x_axis.reject_from_normalized(z).normalize();
    let y = z.cross(x) * axes.determinant().signum();
    Ok(Mat3A::from_cols(x.as_vec3a(), y.as_vec3a(), z.as_vec3a()))
}
