//! Scenes of older versions, in the words of version 3.

use super::document::{Element, Sources};

/// Renames what versions before 3 named otherwise, in the parts of the tree that come from such files:
/// `toWorld` to `to_world`, `intIOR` to `int_ior`, `<lookAt>` to `<lookat>` and so on.
pub(super) fn upgrade(element: &mut Element, sources: &Sources) {
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
    }
    for child in &mut element.children {
        upgrade(child, sources);
    }
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
