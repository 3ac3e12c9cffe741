//! Text to elements that remember where they stand.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::problem::{Issue, Position};
use crate::property::named::{did_you_mean, quoted};

/// Elements inside elements: far more than any scene needs, few enough for the stack.
const MAX_DEPTH: usize = 64;

/// Nodes of one file, so that a hostile file cannot fill the memory.
const MAX_NODES: u32 = 4_000_000;

/// Attributes of one element: the XML parser compares each with each.
const MAX_ATTRIBUTES: usize = 1000;

/// A stretch of one of the files that make up a scene, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    /// Index in [`Sources`].
    pub(super) file: u32,
    start: u32,
    end: u32,
}

impl Place {
    fn new(file: u32, range: Range<usize>) -> Self {
        let clamp = |offset| u32::try_from(offset).unwrap_or(u32::MAX);
        Self { file, start: clamp(range.start), end: clamp(range.end) }
    }

    /// Sorts places as the files are read: by file, the file as a whole first.
    pub(super) fn order(self) -> (u32, u32) {
        (self.file, self.start.wrapping_add(1))
    }

    /// The file as a whole.
    pub(super) fn whole(file: u32) -> Self {
        Self { file, start: u32::MAX, end: u32::MAX }
    }
}

/// The files that make up a scene.
#[derive(Debug, Default)]
pub(super) struct Sources {
    files: Vec<Source>,
}

/// One of the files that make up a scene.
#[derive(Debug)]
pub(super) struct Source {
    /// Its name.
    pub(super) path: PathBuf,
    /// Its text.
    pub(super) text: Arc<str>,
    /// The first number of its `version`.
    pub(super) major_version: u32,
    /// The comment before its root element.
    pub(super) opening: Option<Box<str>>,
    /// Folders in which files that it names are looked for, in this order.
    pub(super) search: Vec<PathBuf>,
}

impl Sources {
    /// Adds a file and returns its index.
    pub(super) fn add(&mut self, path: &Path, text: Arc<str>, search: Vec<PathBuf>) -> u32 {
        let index = u32::try_from(self.files.len()).expect("the number of includes is limited");
        self.files.push(Source {
            path: path.to_owned(),
            text,
            major_version: 3,
            opening: None,
            search,
        });
        index
    }

    pub(super) fn get(&self, file: u32) -> &Source {
        &self.files[file as usize]
    }

    pub(super) fn get_mut(&mut self, file: u32) -> &mut Source {
        &mut self.files[file as usize]
    }

    /// `name` as the file at `place` means it: relative names in each of the file's folders.
    ///
    /// # Errors
    /// No such file.
    pub(super) fn find_file(&self, name: &str, place: Place) -> Result<PathBuf, Issue> {
        let search = &self.get(place.file).search;
        let found = search.iter().map(|folder| folder.join(name)).find(|path| path.exists());
        found.ok_or_else(|| {
            let issue = Issue::new(place, format!("there is no file `{name}`"));
            if Path::new(name).is_absolute() {
                return issue;
            }
            let folders: Vec<_> = search
                .iter()
                .map(|p| if p.as_os_str().is_empty() { ".".into() } else { p.to_string_lossy() })
                .collect();
            issue.with_help(format!("looked in {}", quoted(folders.iter().map(AsRef::as_ref))))
        })
    }

    /// File and position of a place.
    pub(super) fn locate(&self, place: Place) -> (PathBuf, Option<Position>) {
        let source = self.get(place.file);
        let position = (place.start != u32::MAX).then(|| position(&source.text, place));
        (source.path.clone(), position)
    }
}

fn position(text: &Arc<str>, place: Place) -> Position {
    let boundary = |mut offset: usize| {
        offset = offset.min(text.len());
        while !text.is_char_boundary(offset) {
            offset -= 1;
        }
        offset
    };
    let start = boundary(place.start as usize);
    let end = boundary(place.end as usize).max(start);
    let before = &text[..start];
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    Position {
        line: before.bytes().filter(|&b| b == b'\n').count() + 1,
        column: text[line_start..start].chars().count() + 1,
        source: Arc::clone(text),
        span: start..end,
    }
}

/// An XML element.
#[derive(Clone, Debug)]
pub(super) struct Element {
    /// Its name.
    pub(super) tag: String,
    /// Its `<` and name.
    pub(super) place: Place,
    /// In the order of the file.
    pub(super) attributes: Vec<Attribute>,
    /// Elements inside it.
    pub(super) children: Vec<Element>,
    /// Text inside it that is not blank.
    pub(super) stray_text: Option<Place>,
    /// The comment right before it.
    pub(super) comment: Option<Box<str>>,
}

/// An attribute of an element.
#[derive(Clone, Debug)]
pub(super) struct Attribute {
    /// Its name.
    pub(super) name: String,
    /// Its value, with entities replaced.
    pub(super) value: String,
    /// The whole of it.
    pub(super) place: Place,
    /// What stands between the quotes.
    pub(super) value_place: Place,
    /// Whether the value is not known, which has been reported; it is empty then.
    pub(super) unknown: bool,
}

impl Element {
    /// An element that stands for what is at `place`.
    pub(super) fn new(tag: &str, place: Place) -> Self {
        Self {
            tag: tag.into(),
            place,
            attributes: Vec::new(),
            children: Vec::new(),
            stray_text: None,
            comment: None,
        }
    }

    /// The same with an attribute, which has no place of its own.
    pub(super) fn with(mut self, name: &str, value: impl Into<String>) -> Self {
        self.attributes.push(Attribute {
            name: name.into(),
            value: value.into(),
            place: self.place,
            value_place: self.place,
            unknown: false,
        });
        self
    }

    /// The same with these elements inside it.
    pub(super) fn containing(mut self, children: Vec<Element>) -> Self {
        self.children = children;
        self
    }

    /// The attribute of that name.
    pub(super) fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|a| a.name == name)
    }

    /// The value of the attribute of that name; empty if there is none.
    pub(super) fn value(&self, name: &str) -> &str {
        self.attribute(name).map_or("", |a| &a.value)
    }

    /// Where the attribute's value stands, or else the element.
    pub(super) fn place_of(&self, name: &str) -> Place {
        self.attribute(name).map_or(self.place, |a| a.value_place)
    }

    /// Whether it, or something inside it, has an attribute whose value is not known.
    pub(super) fn has_unknowns(&self) -> bool {
        self.attributes.iter().any(|a| a.unknown) || self.children.iter().any(Self::has_unknowns)
    }

    /// Whether the element has all `required` attributes and none but those and `optional` ones.
    pub(super) fn check_attributes(
        &self,
        required: &[&str],
        optional: &[&str],
        issues: &mut Vec<Issue>,
    ) -> bool {
        let before = issues.len();
        let known = || required.iter().chain(optional).copied();
        for attribute in &self.attributes {
            if !known().any(|name| name == attribute.name) {
                let hint = did_you_mean(&attribute.name, known());
                let message =
                    format!("unexpected attribute `{}` in <{}>{hint}", attribute.name, self.tag);
                let help = format!("expected {}", quoted(known()));
                issues.push(Issue::new(attribute.place, message).with_help(help));
            }
        }
        for name in required.iter().filter(|name| self.attribute(name).is_none()) {
            issues.push(Issue::new(
                self.place,
                format!("<{}> lacks the attribute `{name}`", self.tag),
            ));
        }
        issues.len() == before
    }

    /// Whether no element stands inside this one.
    pub(super) fn check_childless(&self, issues: &mut Vec<Issue>) -> bool {
        if let Some(child) = self.children.first() {
            let message = format!("unexpected <{}> inside <{}>", child.tag, self.tag);
            issues.push(Issue::new(child.place, message));
        }
        self.children.is_empty()
    }
}

/// The root element of a file.
///
/// # Errors
/// Text that is not well-formed, elements nested too deeply, a document type declaration.
pub(super) fn parse(text: &str, file: u32) -> Result<Element, Issue> {
    if let Some(start) = crowded_element(text) {
        let message = format!("an element has more than {MAX_ATTRIBUTES} attributes");
        return Err(Issue::new(Place::new(file, start..start + 1), message));
    }
    let options = roxmltree::ParsingOptions { nodes_limit: MAX_NODES, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(text, options).map_err(|error| {
        let start = offset_of(text, error.pos());
        let message = error.to_string();
        let message = message.trim_end_matches(&format!(" at {}", error.pos()));
        let issue = Issue::new(
            Place::new(file, start..start),
            format!("this is not well-formed XML: {message}"),
        );
        if text.trim_start_matches('\u{feff}').trim_start().starts_with('<') {
            return issue;
        }
        issue.with_help(
            "a scene file begins with `<`; a mesh is told by its name, which ends in .obj, .ply, .stl or .serialized",
        )
    })?;
    let mut root = convert(document.root_element(), file, 0)?;
    let opening = document.root().children().take_while(|n| !n.is_element());
    root.comment = opening.filter(roxmltree::Node::is_comment).last().and_then(comment_text);
    Ok(root)
}

/// Where an element starts that has more attributes than is sane. What is not well-formed is left to the
/// parser.
fn crowded_element(text: &str) -> Option<usize> {
    let mut at = 0;
    while let Some(start) = text[at..].find('<').map(|i| at + i) {
        let tag = &text[start..];
        let unstructured = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")]
            .into_iter()
            .find_map(|(open, close)| Some((open.len(), tag.strip_prefix(open)?.find(close)?)));
        if let Some((opening, length)) = unstructured {
            at = start + opening + length;
            continue;
        }
        let (mut quote, mut attributes) = (None, 0);
        let end = tag.bytes().position(|byte| {
            match (quote, byte) {
                (None, b'"' | b'\'') => {
                    quote = Some(byte);
                    attributes += 1;
                }
                (Some(open), _) if open == byte => quote = None,
                (None, b'>') => return true,
                _ => {}
            }
            attributes > MAX_ATTRIBUTES
        });
        if attributes > MAX_ATTRIBUTES {
            return Some(start);
        }
        at = start + end?;
    }
    None
}

/// The text of a comment, its lines without indentation.
fn comment_text(comment: roxmltree::Node<'_, '_>) -> Option<Box<str>> {
    let lines: Vec<_> = comment.text()?.trim().lines().map(str::trim).collect();
    Some(lines.join("\n").into())
}

/// The byte offset of a position that the XML parser reports in characters.
fn offset_of(text: &str, at: roxmltree::TextPos) -> usize {
    let line_start = match at.row {
        0 | 1 => 0,
        row => text.match_indices('\n').nth(row as usize - 2).map_or(text.len(), |(i, _)| i + 1),
    };
    let line = &text[line_start..];
    let column = (at.col as usize).saturating_sub(1);
    line_start + line.char_indices().nth(column).map_or(line.len(), |(i, _)| i)
}

fn convert(node: roxmltree::Node<'_, '_>, file: u32, depth: usize) -> Result<Element, Issue> {
    let tag = node.tag_name().name().to_owned();
    let start = node.range().start;
    let place = Place::new(file, start..start + 1 + tag.len());
    if depth >= MAX_DEPTH {
        return Err(Issue::new(place, format!("elements are nested more than {MAX_DEPTH} deep")));
    }
    let attributes = node
        .attributes()
        .map(|a| Attribute {
            name: a.name().to_owned(),
            value: a.value().to_owned(),
            place: Place::new(file, a.range()),
            value_place: Place::new(file, a.range_value()),
            unknown: false,
        })
        .collect();
    let mut element =
        Element { tag, place, attributes, children: Vec::new(), stray_text: None, comment: None };
    let mut comment = None;
    for child in node.children() {
        match child.text() {
            _ if child.is_comment() => comment = comment_text(child),
            Some(text) if child.is_text() && !text.trim().is_empty() => {
                element.stray_text.get_or_insert(Place::new(file, child.range()));
            }
            _ if child.is_element() => {
                let mut inner = convert(child, file, depth + 1)?;
                inner.comment = comment.take();
                element.children.push(inner);
            }
            _ => {}
        }
    }
    Ok(element)
}
