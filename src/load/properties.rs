//! Objects as their constructors see them: checked, with defaults filled in from the table.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DVec3};

use super::document::{Place, Sources};
use super::graph::{Graph, Node, Property};
use super::indices;
use super::plugins::{self, Category, Default, Kind, Plugin};
use super::problem::Issue;
use super::values::Value;
use crate::math::Rgb;

/// An object that passed [`super::check::check`]: its properties have the kinds that the table says.
#[derive(Clone, Copy, Debug)]
pub(super) struct Object<'a> {
    graph: &'a Graph,
    sources: &'a Sources,
    /// Its index in the graph, for an object that is there.
    index: Option<usize>,
    /// `None` for an object that the file leaves out: all properties have their defaults.
    node: Option<&'a Node>,
    plugin: &'static Plugin,
}

const IN_TABLE: &str = "constructors read what their table lists, of the kind that it lists";

impl<'a> Object<'a> {
    /// The object of that index.
    pub(super) fn new(graph: &'a Graph, sources: &'a Sources, index: usize) -> Option<Self> {
        let node = &graph.nodes[index];
        let plugin = plugins::find(node.category?, &node.plugin)?;
        Some(Self { graph, sources, index: Some(index), node: Some(node), plugin })
    }

    /// An object that the file leaves out.
    pub(super) fn left_out(self, plugin: &'static Plugin) -> Self {
        Self { index: None, node: None, plugin, ..self }
    }

    /// What tells it from all other objects; `None` if the file leaves it out.
    pub(super) fn index(&self) -> Option<usize> {
        self.index
    }

    /// Its row of the table.
    pub(super) fn plugin(&self) -> &'static Plugin {
        self.plugin
    }

    /// Its id; may be empty.
    pub(super) fn id(&self) -> &'a str {
        self.node.map_or("", |n| &n.id)
    }

    /// Where it stands.
    pub(super) fn place(&self) -> Place {
        self.node.map_or(Place::whole(0), |n| n.place)
    }

    /// Where the value of a property stands, or else the object.
    pub(super) fn place_of(&self, name: &str) -> Place {
        self.given(name).map_or(self.place(), |p| p.value_place)
    }

    /// The objects of a category inside it.
    pub(super) fn parts(&self, category: Category) -> impl Iterator<Item = Self> {
        let (graph, sources) = (self.graph, self.sources);
        let children = self.node.map_or(&[][..], |n| &n.children);
        children
            .iter()
            .filter_map(move |c| Self::new(graph, sources, c.node))
            .filter(move |part| part.plugin.category() == category)
    }

    /// The first object of a category inside it, or else one with the defaults of `plugin`.
    pub(super) fn part_or(&self, category: Category, plugin: &'static Plugin) -> Self {
        self.parts(category).next().unwrap_or(self.left_out(plugin))
    }

    /// Whether the file gives a value.
    pub(super) fn has(&self, name: &str) -> bool {
        self.given(name).is_some()
    }

    /// An error if the file gives a value that `why` would have no effect.
    pub(super) fn refuse(&self, names: &[&str], why: &str) -> Result<(), Issue> {
        match names.iter().find_map(|name| self.given(name)) {
            Some(p) => Err(Issue::new(p.name_place, format!("`{}` has no effect {why}", p.name))),
            None => Ok(()),
        }
    }

    pub(super) fn boolean(&self, name: &str) -> bool {
        match (self.value(name), self.default(name)) {
            (Some(Value::Boolean(v)), _) => *v,
            (_, Default::Boolean(v)) => v,
            _ => unreachable!("{IN_TABLE}"),
        }
    }

    pub(super) fn integer(&self, name: &str) -> i64 {
        match (self.value(name), self.default(name)) {
            (Some(Value::Integer(v)), _) => *v,
            (_, Default::Integer(v)) => v,
            _ => unreachable!("{IN_TABLE}"),
        }
    }

    /// An integer that the table limits to what a u32 can hold.
    pub(super) fn count(&self, name: &str) -> u32 {
        u32::try_from(self.integer(name)).expect(IN_TABLE)
    }

    pub(super) fn float(&self, name: &str) -> f64 {
        match (self.number(name), self.default(name)) {
            (Some(v), _) | (_, Default::Float(v)) => v,
            _ => unreachable!("{IN_TABLE}"),
        }
    }

    /// A number, or `None` if the file gives none.
    pub(super) fn number(&self, name: &str) -> Option<f64> {
        match self.value(name) {
            Some(Value::Float(v)) => Some(*v),
            Some(Value::Integer(v)) => Some(*v as f64),
            _ => None,
        }
    }

    /// A text, or `None` if the file gives none and there is no default.
    pub(super) fn text(&self, name: &str) -> Option<&'a str> {
        match (self.value(name), self.default(name)) {
            (Some(Value::Text(v)), _) => Some(v),
            (_, Default::Text(v)) => Some(v),
            _ => None,
        }
    }

    /// One of the table's choices, as the table spells it.
    pub(super) fn choice(&self, name: &str) -> &'static str {
        let Some(Kind::Choice(names)) = self.plugin.property(name).map(|p| p.kind) else {
            unreachable!("{IN_TABLE}")
        };
        let text = self.text(name).expect(IN_TABLE);
        names.iter().find(|n| n.eq_ignore_ascii_case(text)).expect(IN_TABLE)
    }

    pub(super) fn point(&self, name: &str) -> DVec3 {
        match (self.value(name), self.default(name)) {
            (Some(Value::Point(v)), _) => *v,
            (_, Default::Origin) => DVec3::ZERO,
            _ => unreachable!("{IN_TABLE}"),
        }
    }

    pub(super) fn transform(&self, name: &str) -> DAffine3 {
        match (self.value(name), self.default(name)) {
            (Some(Value::Transform(v)), _) => *v,
            (_, Default::Identity) => DAffine3::IDENTITY,
            _ => unreachable!("{IN_TABLE}"),
        }
    }

    pub(super) fn rgb(&self, name: &str) -> Rgb {
        match (self.value(name), self.number(name), self.default(name)) {
            (Some(Value::Rgb(v)), _, _) => v.as_vec3a(),
            (_, Some(v), _) | (_, _, Default::Grey(v)) => Rgb::splat(v as f32),
            _ => unreachable!("{IN_TABLE}"),
        }
    }

    pub(super) fn refractive_index(&self, name: &str) -> f32 {
        let named = || self.text(name).and_then(indices::find);
        self.number(name).or_else(named).expect(IN_TABLE) as f32
    }

    /// The file that a property names.
    ///
    /// # Errors
    /// No such file. A comment right before the property is shown, or else the comment at the head of
    /// the scene if it mentions the file: either may say where the file comes from.
    pub(super) fn file(&self, name: &str) -> Result<PathBuf, Issue> {
        let text = self.text(name).expect(IN_TABLE);
        let place = self.place_of(name);
        self.sources.find_file(text, place).map_err(|issue| {
            let file_name = Path::new(text).file_name().and_then(|n| n.to_str()).unwrap_or(text);
            let opening = self.sources.get(place.file).opening.as_deref();
            let opening = opening.filter(|comment| comment.contains(file_name));
            match self.given(name).and_then(|p| p.comment.as_deref()).or(opening) {
                Some(comment) => issue.with_help(format!("the scene says: {comment}")),
                None => issue,
            }
        })
    }

    fn given(&self, name: &str) -> Option<&'a Property> {
        self.node?.properties.iter().find(|p| p.name == name)
    }

    fn value(&self, name: &str) -> Option<&'a Value> {
        self.given(name)?.value.as_ref()
    }

    fn default(&self, name: &str) -> Default {
        self.plugin.property(name).expect(IN_TABLE).default
    }
}
