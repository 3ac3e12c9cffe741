//! Lights of scene files.

use super::plugins::{Bounds, Build, Default, Kind, Plugin, PropertyInfo, property};
use super::problem::Issue;
use super::properties::Object;
use crate::emitter::{Constant, Point};
use crate::math::Rgb;

/// A light, as far as its object alone describes it.
#[derive(Debug)]
pub(super) enum Light {
    /// Emission of the shape that it stands in.
    Area(Rgb),
    /// Light from outside of the scene.
    Environment(Constant),
    /// A light at a point.
    Point(Point),
}

const RADIANCE: PropertyInfo =
    property("radiance", Kind::Rgb(Bounds::NotNegative), Default::Grey(1.0), "in W/(m² sr)");

pub(super) static AREA: Plugin = Plugin {
    name: "area",
    help: "Light from the front of the shape that it stands in.",
    properties: &[RADIANCE],
    parts: &[],
    build: Build::Emitter(|object| Ok(Light::Area(object.rgb("radiance")))),
};

pub(super) static CONSTANT: Plugin = Plugin {
    name: "constant",
    help: "The same light from all directions outside the scene.",
    properties: &[RADIANCE],
    parts: &[],
    build: Build::Emitter(|object| Ok(Light::Environment(Constant::new(object.rgb("radiance"))))),
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
    let position = position.as_vec3a();
    if !position.is_finite() {
        return Err(Issue::new(object.place(), "the light is farther away than an f32 can hold"));
    }
    Ok(Light::Point(Point::new(position, object.rgb("intensity"))))
}
