//! Scenes of Nori, the framework of many a lecture, in the words of Mitsuba 3.
//!
//! One table says what becomes of each object. More than names differ in a few places: the x axis of the
//! camera points to one side of the picture or the other, see [`NoriX`]; size and filter of the picture
//! belong to the camera, and the sampler stands beside it; what emits and names no material is diffuse.

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

use glam::DVec3;

use super::assemble::Notes;
use super::check::unknown_property;
use super::document::{Element, Place};
use super::problem::Issue;
use super::transform::triple;
use super::values::{self, numbers};
use crate::integrator::Strategy;
use crate::integrator::path::strategy::STRATEGY;
use crate::property::named::{did_you_mean, quoted};
use crate::property::{Bounds, Kind, Named};

/// Where the x axis of the camera points in the pictures of a version of Nori. Scenes do not say for which
/// version they were made, and shown by the other one they are mirrored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NoriX {
    /// To the right, as in the versions whose scenes begin a camera's `toWorld` with a scale of -1, 1, 1.
    #[default]
    Right,
    /// To the left, as in Mitsuba.
    Left,
}

impl NoriX {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Right, Self::Left];

    /// Its name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Left => "left",
        }
    }
}

impl fmt::Display for NoriX {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A side that is neither `right` nor `left`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no side of a picture (expected right or left)")]
pub struct UnknownSide(String);

impl FromStr for NoriX {
    type Err = UnknownSide;

    fn from_str(name: &str) -> Result<Self, UnknownSide> {
        let side = Self::ALL.into_iter().find(|side| side.name() == name);
        side.ok_or_else(|| UnknownSide(name.to_owned()))
    }
}

/// What becomes of an object.
struct Object {
    tag: &'static str,
    name: &'static str,
    /// Its `type` in Mitsuba.
    becomes: &'static str,
    /// Nori's names of its properties, and Mitsuba's.
    properties: &'static [(&'static str, &'static str)],
    /// What else differs.
    finish: fn(&mut Element, &mut Vec<Issue>),
}

type Names = &'static [(&'static str, &'static str)];

const fn object(
    tag: &'static str,
    name: &'static str,
    becomes: &'static str,
    properties: Names,
    finish: fn(&mut Element, &mut Vec<Issue>),
) -> Object {
    Object { tag, name, becomes, properties, finish }
}

const INDICES: [(&str, &str); 2] = [("intIOR", "int_ior"), ("extIOR", "ext_ior")];

static OBJECTS: [Object; 22] = [
    object("mesh", "obj", "obj", &[("filename", "filename"), ("toWorld", "to_world")], mesh),
    object("mesh", "sphere", "sphere", &[("center", "center"), ("radius", "radius")], mesh),
    object(
        "camera",
        "perspective",
        "perspective",
        &[
            ("toWorld", "to_world"),
            ("fov", "fov"),
            ("width", "width"),
            ("height", "height"),
            ("nearClip", "near_clip"),
            ("farClip", "far_clip"),
        ],
        camera,
    ),
    object("bsdf", "diffuse", "diffuse", &[("albedo", "reflectance")], no_more),
    object("bsdf", "mirror", "conductor", &[], no_more),
    object("bsdf", "dielectric", "dielectric", &INDICES, no_more),
    object(
        "bsdf",
        "microfacet",
        "blendbsdf",
        &[("alpha", "alpha"), ("kd", "kd"), INDICES[0], INDICES[1]],
        microfacet,
    ),
    object("emitter", "area", "area", &[("radiance", "radiance")], no_more),
    object(
        "emitter",
        "point",
        "point",
        &[("position", "position"), ("power", "intensity")],
        point_light,
    ),
    object("sampler", "independent", "independent", &[("sampleCount", "sample_count")], no_more),
    object("rfilter", "gaussian", "gaussian", &[("stddev", "stddev")], no_more),
    object("rfilter", "tent", "tent", &[], no_more),
    object("rfilter", "box", "box", &[], no_more),
    object("integrator", "path", "path", &[], no_more),
    object("integrator", "path_mats", "path", &[], by_materials),
    object("integrator", "path_ems", "path", &[], by_emitters),
    object("integrator", "path_mis", "path", &[], no_more),
    object("integrator", "direct", "direct", &[], no_more),
    object("integrator", "direct_mats", "direct", &[], by_materials),
    object("integrator", "direct_ems", "direct", &[], by_emitters),
    object("integrator", "direct_mis", "direct", &[], no_more),
    object("integrator", "ao", "ao", &[], no_more),
];

/// Names of elements, Nori's and Mitsuba's, where they differ.
const TAGS: [(&str, &str); 3] = [("mesh", "shape"), ("camera", "sensor"), ("color", "rgb")];

/// Whether a root element without a version is that of a scene of Nori's.
pub(super) fn is_scene(root: &Element) -> bool {
    root.tag == "scene" && root.children.iter().any(|c| matches!(c.tag.as_str(), "mesh" | "camera"))
}

/// Says the same in Mitsuba's words; which side is assumed, if `x` does not say it, is a warning.
pub(super) fn translate(scene: &mut Element, x: Option<NoriX>, notes: &mut Notes) {
    let Notes { issues, warnings } = notes;
    translate_children(scene, issues);
    let samplers = take_all(scene, "sampler");
    for camera in scene.children.iter_mut().filter(|c| c.tag == "sensor") {
        if x.unwrap_or_default() == NoriX::Right {
            mirror(camera);
        }
    }
    match scene.children.iter_mut().find(|c| c.tag == "sensor") {
        Some(camera) => {
            camera.children.extend(samplers);
            if x.is_none() {
                let side = NoriX::default();
                let message = format!(
                    "a scene of Nori: the camera's x axis is taken to point to the {side} of the picture"
                );
                let help = "versions of Nori differ; if left and right are swapped, use `--nori-x left`, and \
                            `--nori-x right` if this is as it should be";
                warnings.push(Issue::new(camera.place, message).with_help(help));
            }
        }
        None => {
            let help = "add <camera type=\"perspective\"> with a `toWorld` and a `fov`";
            issues.push(Issue::new(scene.place, "the scene has no camera").with_help(help));
        }
    }
}

fn translate_children(parent: &mut Element, issues: &mut Vec<Issue>) {
    let children = std::mem::take(&mut parent.children);
    parent.children.extend(children.into_iter().filter_map(|c| translated(c, issues)));
}

/// The element in Mitsuba's words; `None` if there are none, which is reported.
fn translated(mut element: Element, issues: &mut Vec<Issue>) -> Option<Element> {
    translate_children(&mut element, issues);
    let of_this_tag = || OBJECTS.iter().filter(|o| o.tag == element.tag);
    let name = element.value("type").to_owned();
    let found = of_this_tag().find(|o| o.name == name);
    if found.is_none() && of_this_tag().next().is_some() && !name.is_empty() {
        let names = || of_this_tag().map(|o| o.name);
        let hint = did_you_mean(&name, names());
        let message = format!("{} `{name}` is not supported{hint}", element.tag);
        let help = format!("in a scene of Nori's, use one of {}", quoted(names()));
        issues.push(Issue::new(element.place_of("type"), message).with_help(help));
        return None;
    }
    if let Some(object) = found {
        rename_properties(&mut element, object, issues);
        set_attribute(&mut element, "type", object.becomes);
        (object.finish)(&mut element, issues);
    }
    if element.tag == "rotate" {
        let axis = element.attributes.iter_mut().find(|a| a.name == "axis");
        axis.into_iter().for_each(|a| a.name = "value".into());
    }
    if let Some((_, tag)) = TAGS.iter().find(|(nori, _)| *nori == element.tag) {
        element.tag = (*tag).into();
    }
    Some(element)
}

/// Gives properties Mitsuba's names and reports those that the object does not have.
fn rename_properties(element: &mut Element, object: &Object, issues: &mut Vec<Issue>) {
    element.children.retain_mut(|child| {
        let name = child.value("name");
        // The graph reports what has no name.
        if !values::TAGS.contains(&child.tag.as_str()) || name.is_empty() {
            return true;
        }
        let Some((_, mitsuba)) = object.properties.iter().find(|(nori, _)| *nori == name) else {
            let what = format!("{} `{}`", object.tag, object.name);
            let names = object.properties.iter().map(|(nori, _)| *nori);
            issues.push(unknown_property(name, child.place_of("name"), &what, names));
            return false;
        };
        set_attribute(child, "name", mitsuba);
        true
    });
}

fn set_attribute(element: &mut Element, name: &str, value: &str) {
    let attribute = element.attributes.iter_mut().find(|a| a.name == name);
    attribute.into_iter().for_each(|a| a.value = value.into());
}

fn property(tag: &str, place: Place, name: &str, value: impl Into<String>) -> Element {
    Element::new(tag, place).with("name", name).with("value", value)
}

/// The property of that name, or else one with this value; it is taken out of the object.
fn take_or(element: &mut Element, tag: &str, name: &str, value: &str) -> Element {
    match element.children.iter().position(|c| c.value("name") == name) {
        Some(at) => element.children.remove(at),
        None => property(tag, element.place, name, value),
    }
}

/// The elements of that name, which are taken out of the object.
fn take_all(element: &mut Element, tag: &str) -> Vec<Element> {
    let children = std::mem::take(&mut element.children);
    let (taken, rest) = children.into_iter().partition(|c| c.tag == tag);
    element.children = rest;
    taken
}

fn no_more(_: &mut Element, _: &mut Vec<Issue>) {}

/// Nori gives a material to emitters as well.
fn mesh(mesh: &mut Element, _: &mut Vec<Issue>) {
    let has = |tag| mesh.children.iter().any(|c: &Element| c.tag == tag);
    if has("emitter") && !has("bsdf") {
        mesh.children.push(Element::new("bsdf", mesh.place).with("type", "diffuse"));
    }
}

fn camera(camera: &mut Element, _: &mut Vec<Issue>) {
    let place = camera.place;
    let fov = take_or(camera, "float", "fov", "30");
    let width = take_or(camera, "integer", "width", "1280");
    let height = take_or(camera, "integer", "height", "720");
    let mut film =
        Element::new("film", place).with("type", "hdrfilm").containing(vec![width, height]);
    film.children.extend(take_all(camera, "rfilter"));
    camera.children.extend([fov, film]);
}

/// Lets a camera, whose x axis points to the left in Mitsuba, have it on the right.
fn mirror(camera: &mut Element) {
    let place = camera.place;
    let mirror = Element::new("scale", place).with("value", "-1, 1, 1");
    match camera.children.iter_mut().find(|c| c.value("name") == "to_world") {
        Some(transform) => transform.children.insert(0, mirror),
        None => {
            let map = Element::new("transform", place).with("name", "to_world");
            camera.children.push(map.containing(vec![mirror]));
        }
    }
}

/// `kd / π` and, for the rest of the light, reflection by Beckmann's microfacets under Fresnel's law: a
/// mixture of a diffuse material and of plastic with a black base. With `k = max(kd)` it is
/// `k (kd / k) / π + (1 - k) F D G / (4 cosθi cosθo)`.
fn microfacet(bsdf: &mut Element, issues: &mut Vec<Issue>) {
    let place = bsdf.place;
    let kd = take_or(bsdf, "rgb", "kd", "0.5");
    let (value, value_place) = (kd.value("value"), kd.place_of("value"));
    let color = if kd.has_unknowns() { Ok(DVec3::ZERO) } else { triple(value, value_place) };
    let color = color.and_then(|color| {
        match color.to_array().into_iter().find(|v| !Bounds::Unit.contain(*v)) {
            None => Ok(color),
            Some(v) => {
                let kind = Kind::Rgb(Bounds::Unit);
                let message = format!("`kd` has a channel of {v} (expected: {kind})");
                Err(Issue::new(value_place, message))
            }
        }
    });
    let color = color.map_err(|issue| issues.push(issue)).unwrap_or_default();
    let largest = color.max_element();
    let base = if largest > 0.0 { color / largest } else { color };
    let base = format!("{} {} {}", base.x, base.y, base.z);
    let diffuse = Element::new("bsdf", place).with("type", "diffuse");
    let diffuse = diffuse.containing(vec![property("rgb", place, "reflectance", base)]);
    let coat = vec![
        property("string", place, "distribution", "beckmann"),
        property("rgb", place, "diffuse_reflectance", "0"),
        take_or(bsdf, "float", "alpha", "0.1"),
        take_or(bsdf, "float", "int_ior", "1.5046"),
        take_or(bsdf, "float", "ext_ior", "1.000277"),
    ];
    let coat = Element::new("bsdf", place).with("type", "roughplastic").containing(coat);
    let weight = property("float", place, "weight", (1.0 - largest).to_string());
    bsdf.children.extend([weight, diffuse, coat]);
}

/// Nori gives the power that the light emits in all directions together.
fn point_light(light: &mut Element, _: &mut Vec<Issue>) {
    let power = light.children.iter_mut().find(|c| c.value("name") == "intensity");
    for value in power.into_iter().flat_map(|p| &mut p.attributes).filter(|a| a.name == "value") {
        // What is no list of numbers is reported where it is read.
        if let Ok(list) = numbers(&value.value, value.value_place) {
            let list: Vec<_> = list.iter().map(|v| (v / (4.0 * PI)).to_string()).collect();
            value.value = list.join(" ");
        }
    }
}

fn strategy(place: Place, strategy: Strategy) -> Element {
    property("string", place, STRATEGY.name, strategy.name())
}

fn by_materials(integrator: &mut Element, _: &mut Vec<Issue>) {
    integrator.children.push(strategy(integrator.place, Strategy::Bsdf));
}

fn by_emitters(integrator: &mut Element, _: &mut Vec<Issue>) {
    integrator.children.push(strategy(integrator.place, Strategy::Emitter));
}
