//! `<transform>`: maps given as a sequence of steps.

use glam::{DAffine3, DMat3, DMat4, DVec3};

use super::document::{Element, Place};
use super::problem::Issue;
use super::values::{numbers, parse_number};
use crate::math::Motion;
use crate::property::named::{did_you_mean, quoted};

/// The map of a `<transform>`: its steps, the first one applied first.
///
/// # Errors
/// The first step that is wrong.
pub(super) fn read(transform: &Element) -> Result<DAffine3, Issue> {
    let mut map = DAffine3::IDENTITY;
    for step in &transform.children {
        map = read_step(step)? * map;
        if !map.is_finite() {
            return Err(Issue::new(step.place, "this step makes the transform overflow"));
        }
    }
    Ok(map)
}

/// The motion of an `<animation>`: transforms with their times, which ascend.
///
/// # Errors
/// The first thing that is wrong with it.
pub(super) fn read_animation(animation: &Element) -> Result<Motion, Issue> {
    let mut keys: Vec<(f64, DAffine3)> = Vec::new();
    for key in &animation.children {
        if key.tag != "transform" {
            let message = format!("unexpected <{}> inside <animation>", key.tag);
            return Err(Issue::new(key.place, message).with_help("expected `transform`"));
        }
        let mut issues = Vec::new();
        check(key, &["time"], &[], &mut issues)?;
        let time = parse_number(key.value("time"), key.place_of("time"))?;
        if let Some((before, _)) = keys.last().filter(|(before, _)| *before >= time) {
            let message =
                format!("time {time} does not come after {before}, that of the key before");
            return Err(Issue::new(key.place_of("time"), message));
        }
        keys.push((time, read(key)?));
    }
    Motion::new(keys).map_err(|_| {
        let help = "put <transform time=\"…\"> into it, one for each key";
        Issue::new(animation.place, "an animation needs a key").with_help(help)
    })
}

fn read_step(step: &Element) -> Result<DAffine3, Issue> {
    let mut issues = Vec::new();
    step.check_childless(&mut issues);
    let map = match step.tag.as_str() {
        "translate" => {
            check(step, &[], &["x", "y", "z", "value"], &mut issues)?;
            DAffine3::from_translation(vector(step, 0.0)?)
        }
        "scale" => {
            check(step, &[], &["x", "y", "z", "value"], &mut issues)?;
            DAffine3::from_scale(vector(step, 1.0)?)
        }
        "rotate" => {
            check(step, &["angle"], &["x", "y", "z", "value"], &mut issues)?;
            rotate(step)?
        }
        "lookat" => {
            check(step, &["origin", "target"], &["up"], &mut issues)?;
            lookat(step)?
        }
        "matrix" => {
            check(step, &["value"], &[], &mut issues)?;
            matrix(step)?
        }
        tag => {
            const STEPS: [&str; 5] = ["translate", "rotate", "scale", "lookat", "matrix"];
            let message =
                format!("unexpected <{tag}> inside <transform>{}", did_you_mean(tag, STEPS));
            let help = format!("expected one of {}", quoted(STEPS));
            return Err(Issue::new(step.place, message).with_help(help));
        }
    };
    Ok(map)
}

/// The first thing that is wrong with a step's attributes or that was found before.
fn check(
    step: &Element,
    required: &[&str],
    optional: &[&str],
    issues: &mut Vec<Issue>,
) -> Result<(), Issue> {
    step.check_attributes(required, optional, issues);
    if issues.is_empty() { Ok(()) } else { Err(issues.swap_remove(0)) }
}

/// `x`, `y`, `z`, each with a default, or all of them in `value`.
fn vector(step: &Element, default: f64) -> Result<DVec3, Issue> {
    let axes = ["x", "y", "z"].map(|axis| step.attribute(axis));
    if let Some(value) = step.attribute("value") {
        if axes.iter().any(Option::is_some) {
            let message = format!("<{}> has both `value` and single coordinates", step.tag);
            return Err(Issue::new(step.place, message));
        }
        return triple(&value.value, value.value_place);
    }
    let mut result = DVec3::splat(default);
    for (i, axis) in axes.into_iter().enumerate() {
        if let Some(axis) = axis {
            result[i] = parse_number(&axis.value, axis.value_place)?;
        }
    }
    Ok(result)
}

/// Three numbers, or one for all three.
pub(super) fn triple(text: &str, place: Place) -> Result<DVec3, Issue> {
    match *numbers(text, place)?.as_slice() {
        [v] => Ok(DVec3::splat(v)),
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        ref list => {
            Err(Issue::new(place, format!("expected 1 or 3 numbers, found {}", list.len())))
        }
    }
}

fn rotate(step: &Element) -> Result<DAffine3, Issue> {
    let angle = parse_number(step.value("angle"), step.place_of("angle"))?;
    let axis = vector(step, 0.0)?;
    // Scaled first, so that the square of a long or short axis stays in range.
    let axis = (axis / axis.abs().max_element()).try_normalize();
    let axis =
        axis.ok_or_else(|| Issue::new(step.place, "the axis of a rotation cannot be zero"))?;
    Ok(DAffine3::from_axis_angle(axis, angle.to_radians()))
}

fn lookat(step: &Element) -> Result<DAffine3, Issue> {
    let point = |name: &str| triple_of_three(step.value(name), step.place_of(name));
    let (origin, target) = (point("origin")?, point("target")?);
    let up = if step.value("up").is_empty() { DVec3::ZERO } else { point("up")? };
    let forward = (target - origin).try_normalize().ok_or_else(|| {
        Issue::new(step.place, "<lookat>: `origin` and `target` are the same point")
    })?;
    let up = if up == DVec3::ZERO { any_perpendicular(forward) } else { up };
    let left =
        up.try_normalize().map(|up| up.cross(forward)).filter(|left| left.length() > SMALLEST_SINE);
    let left = left.and_then(DVec3::try_normalize).ok_or_else(|| {
        Issue::new(step.place, "<lookat>: `up` points along the line from `origin` to `target`")
    })?;
    let up = forward.cross(left);
    Ok(DAffine3 { matrix3: DMat3::from_cols(left, up, forward), translation: origin })
}

/// Below this sine of the angle between `up` and the line of sight nothing but the rounding of both, a
/// few 2⁻⁵³, decides about the direction across.
const SMALLEST_SINE: f64 = 1e-14;

/// The direction that Mitsuba takes as `up` where none is given: the first one of the basis of Duff et
/// al., "Building an Orthonormal Basis, Revisited" (JCGT 2017), listing 3.
fn any_perpendicular(n: DVec3) -> DVec3 {
    let sign = 1f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    DVec3::new(1.0 + sign * n.x * n.x * a, sign * n.x * n.y * a, -sign * n.x)
}

fn triple_of_three(text: &str, place: Place) -> Result<DVec3, Issue> {
    match *numbers(text, place)?.as_slice() {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        ref list => Err(Issue::new(place, format!("expected 3 numbers, found {}", list.len()))),
    }
}

/// 16 numbers, or 9 without translation, row by row.
fn matrix(step: &Element) -> Result<DAffine3, Issue> {
    let place = step.place_of("value");
    let list = numbers(step.value("value"), place)?;
    if let Ok(rows) = <&[f64; 9]>::try_from(list.as_slice()) {
        return Ok(DAffine3::from_mat3(DMat3::from_cols_array(rows).transpose()));
    }
    let Ok(rows) = <&[f64; 16]>::try_from(list.as_slice()) else {
        let message = format!("a matrix has 9 or 16 numbers, found {}", list.len());
        return Err(Issue::new(place, message));
    };
    if rows[12..] != [0.0, 0.0, 0.0, 1.0] {
        let message = "the last row of a matrix must be 0 0 0 1: others are no affine maps";
        return Err(Issue::new(place, message));
    }
    Ok(DAffine3::from_mat4(DMat4::from_cols_array(rows).transpose()))
}
