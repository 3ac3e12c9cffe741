//! Elements to objects: properties with values, and which object is part of which.

use std::collections::{BTreeMap, HashSet};

use super::document::{Element, Place};
use super::plugins::Category;
use super::problem::{Issue, LoadError};
use super::values::{self, Value};
use super::work;
use crate::property::named::did_you_mean;

/// All objects of a scene.
#[derive(Debug, Default)]
pub(super) struct Graph {
    /// In the order of the files; the root is the first.
    pub(super) nodes: Vec<Node>,
}

/// An object.
#[derive(Debug)]
pub(super) struct Node {
    /// `None` for the scene itself.
    pub(super) category: Option<Category>,
    /// Its `type`.
    pub(super) plugin: String,
    /// Where its `type` stands.
    pub(super) plugin_place: Place,
    /// Empty if it has none.
    pub(super) id: String,
    /// Its element.
    pub(super) place: Place,
    /// In the order of the file.
    pub(super) properties: Vec<Property>,
    /// Objects inside it, in the order of the file.
    pub(super) children: Vec<Child>,
    /// Whether a reference in it leads nowhere, which has been reported.
    pub(super) is_incomplete: bool,
    /// How many materials have it inside them, by themselves or by reference; all other objects together
    /// count as one more, since they share what they have.
    pub(super) owners: usize,
}

/// A property of an object.
#[derive(Debug)]
pub(super) struct Property {
    /// Its name.
    pub(super) name: String,
    /// Where the name stands.
    pub(super) name_place: Place,
    /// Where the value stands, or else the element.
    pub(super) value_place: Place,
    /// `None` if it could not be read, which has been reported.
    pub(super) value: Option<Value>,
    /// The comment right before it.
    pub(super) comment: Option<Box<str>>,
}

/// An object inside another one.
#[derive(Debug)]
pub(super) struct Child {
    /// Index of the object.
    pub(super) node: usize,
    /// The element that puts it there: itself, or a `<ref>`.
    pub(super) place: Place,
    /// The name of that element: of the property that a texture gives; may be empty.
    pub(super) name: String,
}

/// The objects of a tree.
///
/// References that lead nowhere or in circles are reported and left out. In a tree that is `incomplete`
/// their targets may be what is missing: then the former are not reported.
pub(super) fn build(root: &Element, incomplete: bool, issues: &mut Vec<Issue>) -> Graph {
    let mut builder = Builder {
        graph: Graph::default(),
        ids: BTreeMap::new(),
        property_names: HashSet::new(),
        references: Vec::new(),
        incomplete,
        issues,
    };
    if root.tag == "scene" {
        root.check_attributes(&[], &["id", "type", "name"], builder.issues);
        builder.scene(root);
    } else {
        let message = format!("the outermost element is <{}> (expected <scene>)", root.tag);
        builder.issues.push(Issue::new(root.place, message));
    }
    builder.resolve();
    builder.graph
}

struct Builder<'a> {
    graph: Graph,
    ids: BTreeMap<String, usize>,
    /// Object and name of every property.
    property_names: HashSet<(usize, String)>,
    references: Vec<Reference>,
    incomplete: bool,
    issues: &'a mut Vec<Issue>,
}

struct Reference {
    from: usize,
    /// Index among the children of `from`, where the target is to be put.
    slot: usize,
    id: String,
    place: Place,
}

/// What an element inside an object is.
enum Role {
    Property,
    Object(Category),
    /// An object of Mitsuba's that this renderer does not have, and what to do about it.
    Unsupported(&'static str),
    Reference,
    Alias,
    Unknown,
}

const NO_MEDIA: &str = "light travels through vacuum here; remove it, and what refers to it";

fn role(element: &Element) -> Role {
    let tag = element.tag.as_str();
    match tag {
        "ref" => Role::Reference,
        "alias" => Role::Alias,
        "medium" | "phase" | "volume" | "field" => Role::Unsupported(NO_MEDIA),
        _ if values::TAGS.contains(&tag) => Role::Property,
        _ => Category::ALL
            .into_iter()
            .find(|category| category.tag() == tag)
            .map_or(Role::Unknown, Role::Object),
    }
}

impl Builder<'_> {
    fn scene(&mut self, element: &Element) {
        self.graph.nodes.push(Node {
            category: None,
            plugin: "scene".into(),
            plugin_place: element.place,
            id: String::new(),
            place: element.place,
            properties: Vec::new(),
            children: Vec::new(),
            is_incomplete: false,
            owners: 0,
        });
        self.contents(element, 0);
    }

    /// Adds the object and returns its index.
    fn object(&mut self, element: &Element, category: Category) -> usize {
        element.check_attributes(&["type"], &["id", "name"], self.issues);
        let index = self.graph.nodes.len();
        let id = element.value("id").to_owned();
        self.incomplete |= element.attribute("id").is_some_and(|a| a.unknown);
        if !id.is_empty() {
            self.register(&id, index, element.place_of("id"));
        }
        self.graph.nodes.push(Node {
            category: Some(category),
            plugin: element.value("type").to_owned(),
            plugin_place: element.place_of("type"),
            id,
            place: element.place,
            properties: Vec::new(),
            children: Vec::new(),
            is_incomplete: false,
            owners: 0,
        });
        self.contents(element, index);
        index
    }

    fn register(&mut self, id: &str, index: usize, place: Place) {
        if self.ids.contains_key(id) {
            self.issues.push(Issue::new(
                place,
                format!("there is more than one object with the id `{id}`"),
            ));
        } else {
            self.ids.insert(id.to_owned(), index);
        }
    }

    fn contents(&mut self, object: &Element, index: usize) {
        for element in &object.children {
            work::count(1 + element.attributes.len());
            match role(element) {
                Role::Property => self.property(element, index),
                Role::Object(category) => {
                    let node = self.object(element, category);
                    self.graph.nodes[index].children.push(Child {
                        node,
                        place: element.place,
                        name: element.value("name").to_owned(),
                    });
                }
                Role::Reference => self.reference(element, index),
                Role::Alias => self.alias(element),
                Role::Unsupported(help) => self.unsupported(element, help),
                Role::Unknown => self.unknown(element, object),
            }
        }
    }

    /// Reports an element that nothing is known of, and what is unsupported inside it as well.
    fn unsupported(&mut self, element: &Element, help: &str) {
        let message = format!("<{}> `{}` is not supported", element.tag, element.value("type"));
        self.issues.push(Issue::new(element.place_of("type"), message).with_help(help));
        for inner in &element.children {
            match role(inner) {
                Role::Unsupported(help) => self.unsupported(inner, help),
                Role::Object(category) => {
                    self.object(inner, category);
                }
                _ => {}
            }
        }
    }

    fn unknown(&mut self, element: &Element, object: &Element) {
        const OTHERS: [&str; 6] = ["ref", "alias", "include", "default", "path", "transform"];
        const STEPS: [&str; 5] = ["translate", "rotate", "scale", "lookat", "matrix"];
        let tag = element.tag.as_str();
        let message = if STEPS.contains(&tag) {
            format!("<{tag}> must stand inside a <transform>")
        } else {
            let categories = Category::ALL.map(Category::tag);
            let known = values::TAGS.into_iter().chain(categories).chain(OTHERS);
            format!("unexpected <{tag}> inside <{}>{}", object.tag, did_you_mean(tag, known))
        };
        self.issues.push(Issue::new(element.place, message));
    }

    fn property(&mut self, element: &Element, index: usize) {
        let value = values::read(element, self.issues);
        let name = element.value("name");
        if name.is_empty() {
            return;
        }
        if !self.property_names.insert((index, name.to_owned())) {
            let message = format!("`{name}` is given more than once");
            self.issues.push(Issue::new(element.place_of("name"), message));
            return;
        }
        self.graph.nodes[index].properties.push(Property {
            name: name.to_owned(),
            name_place: element.place_of("name"),
            value_place: element.place_of("value"),
            value,
            comment: element.comment.clone(),
        });
    }

    fn reference(&mut self, element: &Element, index: usize) {
        let complete = element.check_attributes(&["id"], &["name"], self.issues);
        if !element.check_childless(self.issues) || !complete || element.has_unknowns() {
            self.graph.nodes[index].is_incomplete = true;
            return;
        }
        let children = &mut self.graph.nodes[index].children;
        self.references.push(Reference {
            from: index,
            slot: children.len(),
            id: element.value("id").to_owned(),
            place: element.place_of("id"),
        });
        // The target may come later in the file.
        children.push(Child {
            node: UNRESOLVED,
            place: element.place,
            name: element.value("name").to_owned(),
        });
    }

    fn alias(&mut self, element: &Element) {
        let complete = element.check_attributes(&["id", "as"], &[], self.issues);
        if !element.check_childless(self.issues) || !complete || element.has_unknowns() {
            self.incomplete = true;
            return;
        }
        match self.ids.get(element.value("id")) {
            Some(&index) => self.register(element.value("as"), index, element.place_of("as")),
            None if self.incomplete => {}
            None => {
                let id = element.value("id");
                let hint = self.closest_id(id);
                let message =
                    format!("there is no object with the id `{id}` before this alias{hint}");
                self.issues.push(Issue::new(element.place_of("id"), message));
            }
        }
    }

    fn closest_id(&self, id: &str) -> String {
        // Comparing all with all would take minutes for a large file full of wrong references.
        if self.issues.len() >= LoadError::MOST {
            return String::new();
        }
        work::count(self.ids.len());
        did_you_mean(id, self.ids.keys().map(String::as_str))
    }

    fn resolve(&mut self) {
        for reference in std::mem::take(&mut self.references) {
            let target = self.ids.get(&reference.id).copied();
            self.graph.nodes[reference.from].is_incomplete |= target.is_none();
            if target.is_none() && !self.incomplete {
                let hint = self.closest_id(&reference.id);
                let message = format!("there is no object with the id `{}`{hint}", reference.id);
                self.issues.push(Issue::new(reference.place, message));
            }
            let node = target.unwrap_or(UNRESOLVED);
            self.graph.nodes[reference.from].children[reference.slot].node = node;
        }
        for node in &mut self.graph.nodes {
            node.children.retain(|child| child.node != UNRESOLVED);
        }
        self.count_owners();
        self.issues.extend(find_endless(&self.graph));
    }

    fn count_owners(&mut self) {
        let nodes = &self.graph.nodes;
        let mut owners = vec![(0, false); nodes.len()];
        for node in nodes {
            for child in &node.children {
                match node.category {
                    Some(Category::Bsdf) => owners[child.node].0 += 1,
                    _ => owners[child.node].1 = true,
                }
            }
        }
        for (node, (materials, others)) in self.graph.nodes.iter_mut().zip(owners) {
            node.owners = materials + usize::from(others);
        }
    }
}

/// Stands for the target of a reference until it is known.
const UNRESOLVED: usize = usize::MAX;

/// Objects inside objects, by themselves or by reference: far more than any scene needs, few enough for the
/// stack of whoever builds or asks them.
const MAX_DEPTH: usize = 100;

/// An object that contains itself, or others too deeply, if there is one. Walks with its own stack, because
/// a chain of references may be as long as the file.
fn find_endless(graph: &Graph) -> Option<Issue> {
    let mut done = vec![false; graph.nodes.len()];
    // How deep the objects inside an object that is done are nested.
    let mut depths = vec![0; graph.nodes.len()];
    let mut open = vec![false; graph.nodes.len()];
    for start in 0..graph.nodes.len() {
        // (object, index of its next child)
        let mut path: Vec<(usize, usize)> = vec![(start, 0)];
        while let Some((node, next)) = path.last_mut() {
            let node = *node;
            work::count(1);
            open[node] = true;
            if let Some(child) = graph.nodes[node].children.get(*next).filter(|_| !done[node]) {
                *next += 1;
                if open[child.node] {
                    let members = path.iter().map(|&(n, _)| n).skip_while(|&n| n != child.node);
                    let names: Vec<_> = members
                        .chain([child.node])
                        .map(|n| format!("`{}`", graph.nodes[n].id))
                        .collect();
                    let message = format!("an object contains itself: {}", names.join(" -> "));
                    return Some(Issue::new(child.place, message));
                }
                if !done[child.node] {
                    path.push((child.node, 0));
                }
            } else {
                let inner = graph.nodes[node].children.iter().map(|child| depths[child.node] + 1);
                depths[node] = inner.max().unwrap_or(0);
                if depths[node] > MAX_DEPTH {
                    let place = graph.nodes[node].place;
                    let message =
                        format!("objects are inside each other more than {MAX_DEPTH} deep");
                    return Some(Issue::new(place, message));
                }
                done[node] = true;
                open[node] = false;
                path.pop();
            }
        }
    }
    None
}
