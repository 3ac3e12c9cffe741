//! Objects against the table of plugins: what is unknown, missing, misplaced or out of range; and whether the
//! files that they name exist.

use std::collections::HashSet;

use super::assemble::Notes;
use super::context::Context;
use super::document::{Place, Sources};
use super::graph::{Child, Graph, Node, Property};
use super::plugins::{self, Category, Plugin};
use super::problem::Issue;
use super::properties::Object;
use super::spectrum::{Role, Spectrum};
use super::values::Value;
use super::{indices, metals, work};
use crate::memory::Limits;
use crate::property::named::{did_you_mean, quoted};
use crate::property::{Bounds, Default, Kind, PropertyInfo};

/// Reports everything in which the objects deviate from the table.
pub(super) fn check(graph: &Graph, sources: &Sources, notes: &mut Notes) {
    let Notes { issues, warnings } = notes;
    // Files are looked for here, and not loaded.
    let limits = Limits::default();
    let context = Context::new(graph, sources, &limits);
    for (index, node) in graph.nodes.iter().enumerate() {
        work::count(1 + node.properties.len() + node.children.len());
        if let Some(object) = Object::new(&context, index) {
            check_files(&object, node, issues);
        }
        match node.category {
            None => check_scene(graph, node, issues),
            Some(category) => match plugins::find(category, &node.plugin) {
                Some(plugin) => check_object(graph, node, plugin, issues, warnings),
                // An object without a type has been reported.
                None if node.plugin.is_empty() => {}
                None => issues.push(unknown_plugin(node, category)),
            },
        }
    }
}

fn check_files(object: &Object<'_>, node: &Node, issues: &mut Vec<Issue>) {
    let files = object.plugin().properties.iter().filter(|p| p.kind == Kind::File);
    let given = files.filter(|info| {
        let property = node.properties.iter().find(|p| p.name == info.name);
        property.is_some_and(|p| matches!(p.value, Some(Value::Text(_))))
    });
    issues.extend(given.filter_map(|info| object.file(info.name).err()));
}

fn unknown_plugin(node: &Node, category: Category) -> Issue {
    let known = || plugins::supported().filter(|p| p.category() == category).map(|p| p.name);
    let name = &node.plugin;
    let message =
        format!("{} `{name}` is not supported{}", category.tag(), did_you_mean(name, known()));
    Issue::new(node.plugin_place, message).with_help(format!("use one of {}", quoted(known())))
}

fn check_scene(graph: &Graph, scene: &Node, issues: &mut Vec<Issue>) {
    for property in &scene.properties {
        let message = format!("`{}` is no property of a scene", property.name);
        issues.push(Issue::new(property.name_place, message));
    }
    for child in &scene.children {
        let node = &graph.nodes[child.node];
        let Some(category @ (Category::Film | Category::Filter | Category::Sampler)) =
            node.category
        else {
            continue;
        };
        // With an id it is there to be referred to.
        if node.id.is_empty() {
            let owner = if category == Category::Filter { "film" } else { "sensor" };
            let message = format!("<{}> must stand inside a <{owner}>", category.tag());
            issues.push(Issue::new(child.place, message));
        }
    }
}

fn check_object(
    graph: &Graph,
    node: &Node,
    plugin: &'static Plugin,
    issues: &mut Vec<Issue>,
    warnings: &mut Vec<Issue>,
) {
    let object = format!("{} `{}`", plugin.category().tag(), plugin.name);
    let given: HashSet<&str> = node.properties.iter().map(|p| p.name.as_str()).collect();
    for child in textures(graph, node) {
        check_texture(&given, child, plugin, &object, issues);
    }
    for property in &node.properties {
        match (plugin.property(&property.name), &property.value) {
            (None, _) => {
                let Property { name, name_place, .. } = property;
                issues.push(unknown_property(name, *name_place, &object, names_of(plugin)));
            }
            (Some(info), Some(Value::Spectrum(s))) if info.kind.color_bounds().is_some() => {
                match check_spectrum(property, s, info, plugin.light()) {
                    Ok(warning) => warnings.extend(warning),
                    Err(issue) => issues.push(issue),
                }
            }
            (Some(info), Some(value)) => issues.extend(check_value(property, value, info)),
            (Some(_), None) => {}
        }
    }
    for info in plugin.properties.iter().filter(|p| p.default == Default::Required) {
        let by_texture = || textures(graph, node).any(|c| c.name == info.name);
        if !node.is_incomplete
            && !node.properties.iter().any(|p| p.name == info.name)
            && !by_texture()
        {
            let message = format!("{object} needs the property `{}` ({})", info.name, info.help);
            issues.push(Issue::new(node.place, message));
        }
    }
    check_parts(graph, node, plugin, &object, issues);
}

/// The textures inside an object, unless they are its parts like others.
fn textures<'a>(graph: &'a Graph, node: &'a Node) -> impl Iterator<Item = &'a Child> {
    let is_texture = |c: &&Child| graph.nodes[c.node].category == Some(Category::Texture);
    node.children.iter().filter(is_texture)
}

fn takes_textures(plugin: &Plugin) -> bool {
    plugin.parts.iter().any(|p| p.category == Category::Texture)
}

/// A texture is the value of a property, unless the plugin takes one as its part.
fn check_texture(
    given: &HashSet<&str>,
    child: &Child,
    plugin: &'static Plugin,
    object: &str,
    issues: &mut Vec<Issue>,
) {
    let Child { name, place, .. } = child;
    let texturable =
        |p: &PropertyInfo| matches!(p.kind, Kind::RgbTexture(_) | Kind::FloatTexture(_));
    match plugin.property(name) {
        _ if takes_textures(plugin) => {}
        Some(info) if !texturable(info) => {
            let message = format!("`{name}` is a texture (expected: {})", info.kind);
            issues.push(Issue::new(*place, message));
        }
        Some(_) if given.contains(name.as_str()) => {
            issues.push(Issue::new(*place, format!("`{name}` is given more than once")));
        }
        Some(_) => {}
        None => {
            let names = || plugin.properties.iter().filter(|p| texturable(p)).map(|p| p.name);
            let issue = if name.is_empty() {
                let message = format!("{object}: a texture inside it needs a `name`");
                Issue::new(*place, message)
            } else {
                unknown_property(name, *place, object, names_of(plugin))
            };
            let help = if names().next().is_none() {
                format!("{object} takes no textures")
            } else {
                format!("textures can be {}", quoted(names()))
            };
            issues.push(issue.with_help(help));
        }
    }
}

fn names_of(plugin: &'static Plugin) -> impl Iterator<Item = &'static str> + Clone {
    plugin.properties.iter().map(|p| p.name)
}

/// A property that is not one of `names`, those that the object takes.
pub(super) fn unknown_property(
    name: &str,
    place: Place,
    object: &str,
    names: impl Iterator<Item = &'static str> + Clone,
) -> Issue {
    let hint = did_you_mean(name, names.clone());
    let message = format!("{object}: unexpected property `{name}`{hint}");
    let help = match names.clone().next() {
        None => format!("{object} takes no properties"),
        Some(_) => format!("expected one of {}", quoted(names)),
    };
    Issue::new(place, message).with_help(help)
}

fn check_parts(graph: &Graph, node: &Node, plugin: &Plugin, object: &str, issues: &mut Vec<Issue>) {
    let mut counts = [0; Category::ALL.len()];
    for child in &node.children {
        let category = graph.nodes[child.node].category;
        let tag = category.map_or("scene", Category::tag);
        if category == Some(Category::Texture) && !takes_textures(plugin) {
            continue;
        }
        let Some(part) = plugin.parts.iter().find(|p| Some(p.category) == category) else {
            let tags = plugin.parts.iter().map(|p| p.category.tag());
            let expected = if plugin.parts.is_empty() { "no objects".into() } else { quoted(tags) };
            let message = format!("{object}: unexpected {tag} inside it (expected {expected})");
            issues.push(Issue::new(child.place, message));
            continue;
        };
        let count = &mut counts[part.category as usize];
        *count += 1;
        if *count == part.most + 1 {
            let message = format!("{object} takes at most {} {tag}", part.most);
            issues.push(Issue::new(child.place, message));
        }
    }
    for part in plugin.parts.iter().filter(|_| !node.is_incomplete) {
        if counts[part.category as usize] < part.least {
            let tag = part.category.tag();
            let message = match (part.least, counts[part.category as usize]) {
                (1, _) => format!("{object} needs a {tag} inside it"),
                (least, found) => format!("{object} needs {least} {tag} inside it, found {found}"),
            };
            issues.push(Issue::new(node.place, message));
        }
    }
}

fn check_value(property: &Property, value: &Value, info: &PropertyInfo) -> Option<Issue> {
    let complain = |wrong: String| {
        let message = format!("`{}` {wrong} (expected: {})", property.name, info.kind);
        Some(Issue::new(property.value_place, message))
    };
    let wrong_kind = || complain(format!("is {}", value.describe()));
    // Says where the range ends that the number leaves, even where nobody is likely to come so far.
    let out_of_range = |wrong: String, number: f64| {
        let range = match info.kind {
            Kind::Integer(min, max) if number > min as f64 => {
                format!("integer from {min} to {max}")
            }
            Kind::Integer(..) => info.kind.to_string(),
            kind if number.abs() > f64::from(f32::MAX) => {
                format!("{kind}, and not beyond {:e}", f32::MAX)
            }
            kind if number > 0.0 && number as f32 == 0.0 => {
                format!("{kind}, and at least {:e}", f32::from_bits(1))
            }
            kind => kind.to_string(),
        };
        let message = format!("`{}` {wrong} (expected: {range})", property.name);
        Some(Issue::new(property.value_place, message))
    };
    match (info.kind, value) {
        (Kind::Boolean, Value::Boolean(_))
        | (Kind::Text | Kind::File, Value::Text(_))
        | (Kind::Point, Value::Point(_))
        | (Kind::Transform, Value::Transform(_))
        | (Kind::Motion, Value::Transform(_) | Value::Animation(_)) => None,
        (Kind::Integer(min, max), Value::Integer(v)) => {
            if (min..=max).contains(v) {
                None
            } else {
                out_of_range(format!("is {v}"), *v as f64)
            }
        }
        (Kind::RefractiveIndex, Value::Text(name)) => indices::find(name)
            .is_none()
            .then(|| unknown_name(property, "refractive index for", name, &indices::names())),
        (Kind::Metal, Value::Text(name)) => (!metals::is_known(name))
            .then(|| unknown_name(property, "metal", name, &metals::names())),
        (Kind::Choice(names), Value::Text(name)) => {
            let known = names.iter().any(|n| n.eq_ignore_ascii_case(name));
            if known { None } else { complain(format!("is `{name}`")) }
        }
        (Kind::Float(bounds), _) => match number(value) {
            Some(v) if bounds.contain(v) => None,
            Some(v) => out_of_range(format!("is {v}"), v),
            None => wrong_kind(),
        },
        (Kind::RefractiveIndex, _) => match number(value) {
            Some(v) if Bounds::Positive.contain(v) => None,
            Some(v) => out_of_range(format!("is {v}"), v),
            None => wrong_kind(),
        },
        (Kind::Rgb(bounds) | Kind::RgbTexture(bounds) | Kind::FloatTexture(bounds), _) => {
            let channels = match (value, number(value)) {
                (Value::Rgb(rgb), _) => rgb.to_array(),
                (_, Some(v)) => [v; 3],
                _ => return wrong_kind(),
            };
            let outside = channels.into_iter().find(|&v| !bounds.contain(v));
            outside.and_then(|v| match value {
                Value::Rgb(_) => out_of_range(format!("has a channel of {v}"), v),
                _ => out_of_range(format!("is {v}"), v),
            })
        }
        _ => wrong_kind(),
    }
}

/// A warning if the spectrum has no colour within bounds, so that the closest is taken (as in Mitsuba).
fn check_spectrum(
    property: &Property,
    spectrum: &Spectrum,
    info: &PropertyInfo,
    role: Role,
) -> Result<Option<Issue>, Issue> {
    let name = &property.name;
    let Some(bounds) = info.kind.color_bounds() else {
        return Ok(None);
    };
    if let Some(v) = spectrum.values().into_iter().find(|&v| !bounds.contain(v)) {
        let message = format!("`{name}` has a value of {v} (expected: {})", info.kind);
        return Err(Issue::new(property.value_place, message));
    }
    if matches!(spectrum, Spectrum::BlackBody(_)) && role != Role::Emission {
        let message = format!("`{name}` is a black body, which is a light (expected: a colour)");
        return Err(Issue::new(property.value_place, message));
    }
    let rgb = spectrum.linear_srgb(role);
    if rgb.max_element() > f64::from(f32::MAX) {
        let message = format!("`{name}` is brighter than an f32 can hold");
        return Err(Issue::new(property.value_place, message));
    }
    let clamped = bounds.clamp(rgb);
    Ok((clamped != rgb).then(|| {
        let list = |c: glam::DVec3| format!("({:.4}, {:.4}, {:.4})", c.x, c.y, c.z);
        let message = format!(
            "`{name}` is a spectrum whose colour {} is out of gamut; {} is taken",
            list(rgb),
            list(clamped)
        );
        Issue::new(property.value_place, message)
    }))
}

fn unknown_name(property: &Property, what: &str, name: &str, known: &[&str]) -> Issue {
    let hint = did_you_mean(name, known.iter().copied());
    Issue::new(property.value_place, format!("there is no {what} `{name}`{hint}"))
        .with_help(format!("known are {}", quoted(known.iter().copied())))
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Float(v) => Some(*v),
        Value::Integer(v) => Some(*v as f64),
        _ => None,
    }
}
