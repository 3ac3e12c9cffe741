//! Text to values: the elements that give an object's property.

use std::num::{IntErrorKind, ParseIntError};

use glam::{DAffine3, DVec3};

use super::document::{Element, Place};
use super::problem::Issue;
use super::spectrum::{self, Spectrum};
use super::transform;
use crate::math::Motion;

/// The value of a property.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// `<boolean>`
    Boolean(bool),
    /// `<integer>`
    Integer(i64),
    /// `<float>`
    Float(f64),
    /// `<string>`
    Text(String),
    /// `<point>` or `<vector>`
    Point(DVec3),
    /// `<rgb>` or `<srgb>`: linear sRGB.
    Rgb(DVec3),
    /// `<spectrum>`
    Spectrum(Spectrum),
    /// `<transform>`
    Transform(DAffine3),
    /// `<animation>`, by the scene's clock.
    Animation(Motion),
}

impl Value {
    /// What it is called in messages.
    pub(super) fn describe(&self) -> &'static str {
        match self {
            Self::Boolean(_) => "a boolean",
            Self::Integer(_) => "an integer",
            Self::Float(_) => "a float",
            Self::Text(_) => "a string",
            Self::Point(_) => "a point",
            Self::Rgb(_) => "a colour",
            Self::Spectrum(_) => "a spectrum",
            Self::Transform(_) => "a transform",
            Self::Animation(_) => "an animation",
        }
    }
}

/// Elements that give a property.
pub(super) const TAGS: [&str; 11] = [
    "boolean",
    "integer",
    "float",
    "string",
    "point",
    "vector",
    "rgb",
    "srgb",
    "spectrum",
    "transform",
    "animation",
];

/// The value that an element of [`TAGS`] gives; `None` if something is wrong with it, which is then noted.
pub(super) fn read(element: &Element, issues: &mut Vec<Issue>) -> Option<Value> {
    if !check_form(element, issues) || element.has_unknowns() {
        return None;
    }
    parse(element).map_err(|issue| issues.push(issue)).ok()
}

/// Whether an element has the attributes and the contents that it should.
fn check_form(element: &Element, issues: &mut Vec<Issue>) -> bool {
    let before = issues.len();
    match element.tag.as_str() {
        "transform" | "animation" => {
            element.check_attributes(&["name"], &[], issues);
        }
        "point" | "vector" => {
            let coordinates: &[&str] = if element.attribute("value").is_some() {
                &["name", "value"]
            } else {
                &["name", "x", "y", "z"]
            };
            element.check_attributes(coordinates, &[], issues);
            element.check_childless(issues);
        }
        "spectrum" if element.attribute("type").is_some() => {
            element.check_attributes(&["type", "name"], &[], issues);
        }
        "spectrum" if element.attribute("filename").is_some() => {
            let message = "spectra from files are not supported";
            let help =
                "write the file's pairs of wavelength and value as value=\"400:0.1, 700:0.8\"";
            issues.push(Issue::new(element.place_of("filename"), message).with_help(help));
        }
        _ => {
            element.check_attributes(&["name", "value"], &[], issues);
            element.check_childless(issues);
        }
    }
    issues.len() == before
}

fn parse(element: &Element) -> Result<Value, Issue> {
    let (text, place) = (element.value("value"), element.place_of("value"));
    Ok(match element.tag.as_str() {
        "boolean" => Value::Boolean(parse_boolean(text, place)?),
        "integer" => Value::Integer(parse_integer(text, place)?),
        "float" => Value::Float(parse_number(text, place)?),
        "point" | "vector" => Value::Point(parse_point(element)?),
        "rgb" => Value::Rgb(parse_rgb(text, place)?),
        "srgb" => Value::Rgb(parse_srgb(text, place)?),
        "spectrum" if element.attribute("type").is_some() => spectrum::read_typed(element)?,
        "spectrum" => spectrum::parse(text, place)?,
        "transform" => Value::Transform(transform::read(element)?),
        "animation" => Value::Animation(transform::read_animation(element)?),
        _ => Value::Text(text.to_owned()),
    })
}

fn parse_boolean(text: &str, place: Place) -> Result<bool, Issue> {
    if text.eq_ignore_ascii_case("true") {
        Ok(true)
    } else if text.eq_ignore_ascii_case("false") {
        Ok(false)
    } else {
        Err(Issue::new(place, format!("`{text}` is neither true nor false")))
    }
}

fn parse_integer(text: &str, place: Place) -> Result<i64, Issue> {
    text.trim().parse().map_err(|error: ParseIntError| match error.kind() {
        IntErrorKind::PosOverflow | IntErrorKind::NegOverflow => {
            let (min, max) = (i64::MIN, i64::MAX);
            let message =
                format!("`{text}` is out of range (expected: integer from {min} to {max})");
            Issue::new(place, message)
        }
        _ => Issue::new(place, format!("`{text}` is not a whole number")),
    })
}

/// A finite number.
pub(super) fn parse_number(text: &str, place: Place) -> Result<f64, Issue> {
    let number: f64 =
        text.trim().parse().map_err(|_| Issue::new(place, format!("`{text}` is not a number")))?;
    if number.is_finite() {
        Ok(number)
    } else {
        Err(Issue::new(place, format!("`{text}` is not a finite number")))
    }
}

/// Numbers separated by spaces, commas or both.
pub(super) fn numbers(text: &str, place: Place) -> Result<Vec<f64>, Issue> {
    text.split(|c: char| c.is_whitespace() || c == ',')
        .filter(|word| !word.is_empty())
        .map(|word| parse_number(word, place))
        .collect()
}

fn parse_point(element: &Element) -> Result<DVec3, Issue> {
    if let Some(value) = element.attribute("value") {
        return transform::triple(&value.value, value.value_place);
    }
    let coordinate = |name| parse_number(element.value(name), element.place_of(name));
    Ok(DVec3::new(coordinate("x")?, coordinate("y")?, coordinate("z")?))
}

fn parse_rgb(text: &str, place: Place) -> Result<DVec3, Issue> {
    if text.trim_start().starts_with('#') {
        let message = format!("`{text}` is hexadecimal, which is not supported");
        return Err(
            Issue::new(place, message).with_help(
                "write linear sRGB as in value=\"0.8, 0.2, 0.1\", or <srgb name=\"…\" value=\"#e67c59\"/>",
            )
        );
    }
    transform::triple(text, place)
}

/// A colour as screens take it: three numbers from 0 to 1, or `#rrggbb`.
fn parse_srgb(text: &str, place: Place) -> Result<DVec3, Issue> {
    let encoded = match text.trim().strip_prefix('#') {
        None => transform::triple(text, place)?,
        Some(digits) => {
            let number = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 6);
            let number = number.ok_or_else(|| {
                Issue::new(place, format!("`{text}` is not a colour (expected one like #e67c59)"))
            })?;
            let [_, r, g, b] = number.to_be_bytes();
            DVec3::new(r.into(), g.into(), b.into()) / 255.0
        }
    };
    // IEC 61966-2-1.
    let linear = |v: f64| if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
    Ok(DVec3::from_array(encoded.to_array().map(linear)))
}
