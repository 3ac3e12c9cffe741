//! Scenes of older versions, in the words of version 3.

use super::document::{Element, Sources};
use super::problem::Issue;

/// Renames what versions before 3 named otherwise, in the parts of the tree that come from such files:
/// `toWorld` to `to_world`, `intIOR` to `int_ior`, `<lookAt>` to `<lookat>` and so on. Leaves out what
/// version 3 has no counterpart for and the picture does not need.
pub(super) fn upgrade(element: &mut Element, sources: &Sources, warnings: &mut Vec<Issue>) {
    if sources.get(element.place.file).major_version < 3 {
        if element.tag == "lookAt" {
            element.tag = "lookat".into();
        }
        if let Some(name) = element.attributes.iter_mut().find(|a| a.name == "name") {
            name.value = snake_case(&name.value);
        }
        if element.tag == "texture" {
            offsets_to_map(element);
        }
        if element.tag == "bsdf" && element.value("type") == "diffuse" {
            rename_property(element, "diffuseReflectance", "reflectance");
        }
        leave_out(element);
        replace_plugin(element, warnings);
        match (element.tag.as_str(), element.value("type")) {
            ("texture", "bitmap") => bitmap(element),
            ("bsdf", "conductor" | "roughconductor") => conductor(element),
            _ => {}
        }
        for child in &mut element.children {
            black_body(child);
        }
    }
    for child in &mut element.children {
        upgrade(child, sources, warnings);
    }
}

/// Properties that say nothing about the picture: how borders are computed, whether the renderer's name is
/// stamped on it, the parameters of samplers, whose numbers are others here, and how often a light is sampled.
/// Normals are always strict.
const LEFT_OUT: [(&str, &[&str]); 4] = [
    ("film", &["banner", "highQualityEdges", "attachLog"]),
    ("sampler", &["dimension", "scramble"]),
    ("integrator", &["strictNormals"]),
    ("emitter", &["samplingWeight"]),
];

fn leave_out(element: &mut Element) {
    let rows = LEFT_OUT.iter().filter(|(tag, _)| *tag == element.tag);
    for (_, names) in rows {
        element.children.retain(|c| !names.contains(&c.value("name")));
    }
}

/// Plugins that version 3 does not have, their stand-ins, and properties that only they take.
const REPLACED: [(&str, &str, &str, &[&str]); 3] = [
    (
        "film",
        "ldrfilm",
        "hdrfilm",
        &["fileFormat", "tonemapMethod", "gamma", "exposure", "key", "burn"],
    ),
    ("sampler", "halton", "sobol", &[]),
    ("sampler", "hammersley", "sobol", &[]),
];

fn replace_plugin(element: &mut Element, warnings: &mut Vec<Issue>) {
    let place = element.place_of("type");
    let Some((tag, old, new, own)) =
        REPLACED.iter().find(|(tag, old, ..)| *tag == element.tag && *old == element.value("type"))
    else {
        return;
    };
    element.children.retain(|c| !own.contains(&c.value("name")));
    if let Some(name) = element.attributes.iter_mut().find(|a| a.name == "type") {
        name.value = (*new).into();
    }
    let issue = Issue::new(place, format!("{tag} `{new}` is used in place of `{old}`"));
    warnings.push(match *tag {
        "film" => {
            issue.with_help("PNG files are sRGB; gamma, exposure and tone mapping are left out")
        }
        _ => issue,
    });
}

/// Filters over many pixels become the one between pixels: many samples do the same. A gamma of 1 is `raw`,
/// one of -1 the default.
fn bitmap(texture: &mut Element) {
    for property in &mut texture.children {
        let value = property.attributes.iter().find(|a| a.name == "value").map(|a| a.value.clone());
        let (name, new) = match (property.value("name"), value.as_deref()) {
            ("filterType", Some("trilinear" | "ewa")) => ("filterType", "bilinear"),
            ("gamma", Some(gamma)) if gamma.parse::<f64>() == Ok(1.0) => ("raw", "true"),
            ("gamma", Some(gamma)) if gamma.parse::<f64>() == Ok(-1.0) => ("raw", "false"),
            _ => continue,
        };
        property.tag = if name == "raw" { "boolean" } else { "string" }.into();
        for attribute in &mut property.attributes {
            match attribute.name.as_str() {
                "name" => attribute.value = name.into(),
                _ => attribute.value = new.into(),
            }
        }
    }
}

/// In front of a conductor there is nothing but air.
fn conductor(bsdf: &mut Element) {
    let is_one =
        |c: &Element| c.value("value").parse::<f64>() == Ok(1.0) || c.value("value") == "air";
    bsdf.children.retain(|c| c.value("name") != "extEta" || !is_one(c));
}

/// `<blackbody name="radiance" temperature="3500"/>` becomes a spectrum of that type.
fn black_body(property: &mut Element) {
    if property.tag != "blackbody" {
        return;
    }
    let Some(at) = property.attributes.iter().position(|a| a.name == "temperature") else {
        return;
    };
    property.tag = "spectrum".into();
    let mut temperature = property.attributes.remove(at);
    temperature.name = "value".into();
    temperature.value = temperature.value.trim_end_matches(['K', 'k', ' ']).into();
    let mut child = Element::new("float", property.place).with("name", "temperature");
    child.attributes.push(temperature);
    property.children.push(child);
    let kind = Element::new("", property.place).with("type", "blackbody").attributes;
    property.attributes.extend(kind);
}

fn rename_property(object: &mut Element, old: &str, new: &str) {
    let attributes = object.children.iter_mut().flat_map(|c| &mut c.attributes);
    for name in attributes.filter(|a| a.name == "name" && a.value == old) {
        name.value = new.into();
    }
}

/// Makes a transform `to_uv` of `uscale`, `vscale`, `uoffset` and `voffset`, scaling first.
fn offsets_to_map(texture: &mut Element) {
    let mut steps = Vec::new();
    for (tag, names) in [("scale", ["uscale", "vscale"]), ("translate", ["uoffset", "voffset"])] {
        let mut step: Option<Element> = None;
        for (name, axis) in names.into_iter().zip(["x", "y"]) {
            let Some(at) = texture.children.iter().position(|c| c.value("name") == name) else {
                continue;
            };
            let mut property = texture.children.remove(at);
            property.attributes.retain(|a| a.name == "value");
            for value in &mut property.attributes {
                value.name = axis.into();
            }
            match &mut step {
                Some(step) => step.attributes.append(&mut property.attributes),
                None => step = Some(Element { tag: tag.into(), ..property }),
            }
        }
        steps.extend(step);
    }
    let Some(first) = steps.first() else { return };
    let map = Element::new("transform", first.place).with("name", "to_uv");
    let map = map.containing(steps);
    texture.children.push(map);
}

/// An underscore wherever capitals follow a small letter; those capitals become small.
fn snake_case(name: &str) -> String {
    let mut result = String::with_capacity(name.len() + 4);
    let mut previous = ' ';
    let mut lowering = false;
    for c in name.chars() {
        let starts = c.is_ascii_uppercase() && previous.is_ascii_lowercase();
        lowering = c.is_ascii_uppercase() && (starts || lowering);
        if starts {
            result.push('_');
        }
        result.push(if lowering { c.to_ascii_lowercase() } else { c });
        previous = c;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_rewritten_as_mitsuba_does() {
        for (old, new) in [
            ("toWorld", "to_world"),
            ("intIOR", "int_ior"),
            ("cropOffsetX", "crop_offset_x"),
            ("principalPointOffsetY", "principal_point_offset_y"),
            ("already_new", "already_new"),
            ("XYZ", "XYZ"),
            ("", ""),
        ] {
            assert_eq!(snake_case(old), new);
        }
    }
}
