//! One tree out of all files: `<include>`, `<path>`, `<default>` and `$name`, in the order of the files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::document::{Element, Place, Sources, parse};
use super::nori;
use super::problem::{Issue, LoadError};
use super::substitute::{LONGEST_NAME, Parameters, SubstituteError};
use super::work;
use crate::property::named::did_you_mean;

/// Includes inside includes, as in Mitsuba.
const MAX_INCLUDE_DEPTH: usize = 15;

/// Includes in all: nested ones can multiply.
const MAX_INCLUDES: usize = 1000;

/// Elements of all files, for the same reason.
const MAX_ELEMENTS: usize = 1_000_000;

/// Bytes of one scene file; meshes have files of their own.
const MAX_FILE_BYTES: u64 = 1 << 28;

/// Bytes of all values that parameters are substituted in.
const MAX_EXPANDED_BYTES: usize = 1 << 25;

/// A walk through the files of a scene.
#[derive(Debug)]
pub(super) struct Expander {
    /// Files seen so far.
    pub(super) sources: Sources,
    /// Parameters seen so far.
    pub(super) parameters: Parameters,
    /// What is wrong.
    pub(super) issues: Vec<Issue>,
    /// What may not be as meant.
    pub(super) warnings: Vec<Issue>,
    /// Whether the first file is a scene of Nori's.
    pub(super) is_nori: bool,
    /// Whether elements are missing from the tree, because of one of the issues.
    pub(super) incomplete: bool,
    /// Canonical names of the files that are open, outermost first.
    open: Vec<PathBuf>,
    includes: usize,
    elements: usize,
    expanded_bytes: usize,
}

impl Expander {
    pub(super) fn new(parameters: Parameters) -> Self {
        Self {
            sources: Sources::default(),
            parameters,
            issues: Vec::new(),
            warnings: Vec::new(),
            is_nori: false,
            incomplete: false,
            open: Vec::new(),
            includes: 0,
            elements: 0,
            expanded_bytes: 0,
        }
    }

    /// The tree of the file at `path`. `None` if a problem was found that leaves no tree.
    pub(super) fn file(&mut self, path: &Path) -> Option<Element> {
        let text = read(path);
        let search = vec![folder_of(path)];
        let file = self.sources.add(path, text.as_deref().unwrap_or_default().into(), search);
        match text {
            Ok(_) => self.root(path, file),
            Err(message) => {
                self.issues.push(Issue::new(Place::whole(file), message));
                None
            }
        }
    }

    /// The tree of `text`; `path` is its name, and names its folder.
    pub(super) fn text(&mut self, text: &str, path: &Path) -> Option<Element> {
        let file = self.sources.add(path, text.into(), vec![folder_of(path)]);
        self.root(path, file)
    }

    fn root(&mut self, path: &Path, file: u32) -> Option<Element> {
        let text = Arc::clone(&self.sources.get(file).text);
        let mut root = match parse(&text, file) {
            Ok(root) => root,
            Err(issue) => {
                self.issues.push(issue);
                self.incomplete = true;
                return None;
            }
        };
        if matches!(root.tag.as_str(), "default" | "include" | "path") {
            let message = format!("<{}> cannot be the outermost element of a file", root.tag);
            self.issues.push(Issue::new(root.place, message));
            self.incomplete = true;
            return None;
        }
        self.open.push(path.canonicalize().unwrap_or_else(|_| path.to_owned()));
        self.read_version(&mut root, file);
        self.sources.get_mut(file).opening = root.comment.take();
        let mut expanded = Vec::with_capacity(1);
        self.element(root, true, &mut expanded);
        self.open.pop();
        expanded.pop()
    }

    /// Takes `version` off the root element and notes it.
    fn read_version(&mut self, root: &mut Element, file: u32) {
        let Some(at) = root.attributes.iter().position(|a| a.name == "version") else {
            if file == 0 && nori::is_scene(root) {
                self.is_nori = true;
                return;
            }
            let message = format!("<{}> lacks the attribute `version`", root.tag);
            self.issues.push(Issue::new(root.place, message).with_help("add version=\"3.0.0\""));
            return;
        };
        let version = root.attributes.remove(at);
        let parts: Vec<_> = version.value.split('.').map(str::parse::<u32>).collect();
        match parts[0] {
            Ok(major) if (2..=3).contains(&parts.len()) && parts.iter().all(Result::is_ok) => {
                self.sources.get_mut(file).major_version = major;
                if major > 3 {
                    let message =
                        format!("version {} is newer than what is known here", version.value);
                    let help =
                        "scenes of Mitsuba 3 and, upgraded, of older versions are understood";
                    self.issues.push(Issue::new(version.value_place, message).with_help(help));
                }
            }
            _ => {
                let message = format!("`{}` is not a version", version.value);
                let help = "write it like 3.0.0";
                self.issues.push(Issue::new(version.value_place, message).with_help(help));
            }
        }
    }

    /// Appends what `element` stands for to `out`.
    fn element(&mut self, mut element: Element, root: bool, out: &mut Vec<Element>) {
        self.elements += 1;
        work::count(1 + element.attributes.len());
        if self.elements > MAX_ELEMENTS {
            if self.elements == MAX_ELEMENTS + 1 {
                let message = format!("the scene has more than {MAX_ELEMENTS} elements");
                self.issues.push(Issue::new(element.place, message));
                self.incomplete = true;
            }
            return;
        }
        self.substitute(&mut element);
        if let Some(place) = element.stray_text {
            let message = format!("text inside <{}> means nothing", element.tag);
            self.warnings.push(Issue::new(place, message));
        }
        match element.tag.as_str() {
            "default" => self.default(&element),
            "include" => self.include(&element, out),
            "path" => self.path(&element),
            _ => {
                for child in std::mem::take(&mut element.children) {
                    if child.tag == "path" && !root {
                        let message = "<path> must stand directly inside the root element";
                        self.issues.push(Issue::new(child.place, message));
                    } else {
                        self.element(child, false, &mut element.children);
                    }
                }
                out.push(element);
            }
        }
    }

    fn substitute(&mut self, element: &mut Element) {
        for attribute in element.attributes.iter_mut().filter(|a| a.value.contains('$')) {
            let issue = match self.parameters.substitute(&attribute.value) {
                Ok(value) => {
                    self.expanded_bytes = self.expanded_bytes.saturating_add(value.len());
                    if self.expanded_bytes <= MAX_EXPANDED_BYTES {
                        attribute.value = value;
                        continue;
                    }
                    let message =
                        format!("parameters add more than {MAX_EXPANDED_BYTES} bytes to the scene");
                    Issue::new(attribute.value_place, message)
                }
                Err(SubstituteError::Undefined(name)) => {
                    let hint = self.closest_parameter(&name);
                    Issue::new(attribute.value_place, format!("undefined parameter `${name}`{hint}"))
                        .with_help(format!(
                            "give it a value by -D {name}=… or by <default name=\"{name}\" value=\"…\"/> \
                             before its use; write \\$ for a dollar sign"
                        ))
                }
                Err(SubstituteError::TooLong) => Issue::new(
                    attribute.value_place,
                    "this value becomes too long once its parameters are substituted",
                ),
            };
            self.issues.push(issue);
            attribute.value.clear();
            attribute.unknown = true;
        }
    }

    fn closest_parameter(&self, name: &str) -> String {
        // Comparing all with all would take minutes for a large file full of wrong names.
        if self.issues.len() >= LoadError::MOST {
            return String::new();
        }
        work::count(self.parameters.names().count());
        did_you_mean(name, self.parameters.names())
    }

    fn default(&mut self, element: &Element) {
        let complete = element.check_attributes(&["name", "value"], &[], &mut self.issues);
        if !element.check_childless(&mut self.issues) || !complete || element.has_unknowns() {
            return;
        }
        if element.value("name").is_empty() {
            self.issues
                .push(Issue::new(element.place, "<default> needs a `name` that is not empty"));
            return;
        }
        if element.value("name").len() > LONGEST_NAME {
            let message = format!("the name of a parameter is longer than {LONGEST_NAME} bytes");
            self.issues.push(Issue::new(element.place_of("name"), message));
            return;
        }
        self.parameters.set_default(element.value("name"), element.value("value"));
    }

    fn path(&mut self, element: &Element) {
        let complete = element.check_attributes(&["value"], &[], &mut self.issues);
        if !element.check_childless(&mut self.issues) || !complete || element.has_unknowns() {
            return;
        }
        let place = element.place_of("value");
        match self.sources.find_file(element.value("value"), place) {
            Ok(folder) if folder.is_dir() => {
                self.sources.get_mut(place.file).search.insert(0, folder);
            }
            _ => {
                let message = format!("there is no folder `{}`", element.value("value"));
                self.issues.push(Issue::new(place, message));
            }
        }
    }

    fn include(&mut self, element: &Element, out: &mut Vec<Element>) {
        let complete = element.check_attributes(&["filename"], &["name"], &mut self.issues);
        if !element.check_childless(&mut self.issues) || !complete || element.has_unknowns() {
            self.incomplete = true;
            return;
        }
        match self.open_include(element) {
            Err(issue) => {
                self.issues.push(issue);
                self.incomplete = true;
            }
            Ok((path, file)) => {
                let Some(mut root) = self.root(&path, file) else {
                    return;
                };
                if root.tag == "scene" {
                    out.append(&mut root.children);
                    return;
                }
                if let Some(name) = element.attribute("name") {
                    root.attributes.retain(|a| a.name != "name");
                    root.attributes.push(name.clone());
                }
                out.push(root);
            }
        }
    }

    /// Reads the file that an `<include>` names.
    fn open_include(&mut self, element: &Element) -> Result<(PathBuf, u32), Issue> {
        let place = element.place_of("filename");
        let path = self.sources.find_file(element.value("filename"), place)?;
        let canonical = path.canonicalize().unwrap_or_else(|_| path.clone());
        if let Some(first) = self.open.iter().position(|p| *p == canonical) {
            let names = self.open[first..].iter().chain([&canonical]);
            let names: Vec<_> =
                names.map(|p| p.file_name().unwrap_or_default().to_string_lossy()).collect();
            let message = format!("a file includes itself: {}", names.join(" -> "));
            return Err(Issue::new(place, message));
        }
        if self.open.len() > MAX_INCLUDE_DEPTH {
            let message = format!("files include each other more than {MAX_INCLUDE_DEPTH} deep");
            return Err(Issue::new(place, message));
        }
        self.includes += 1;
        if self.includes > MAX_INCLUDES {
            return Err(Issue::new(place, format!("more than {MAX_INCLUDES} files are included")));
        }
        let text =
            read(&path).map_err(|m| Issue::new(place, format!("{}: {m}", path.display())))?;
        let mut search = vec![folder_of(&path)];
        search.extend_from_slice(&self.sources.get(place.file).search);
        let file = self.sources.add(&path, text.into(), search);
        Ok((path, file))
    }
}

fn folder_of(path: &Path) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).to_owned()
}

/// The text of a file, or what is wrong with it.
fn read(path: &Path) -> Result<String, String> {
    let metadata = std::fs::metadata(path).map_err(|e| format!("cannot be read: {e}"))?;
    if !metadata.is_file() {
        return Err("is not a file".into());
    }
    if metadata.len() > MAX_FILE_BYTES {
        return Err(format!("has more than {MAX_FILE_BYTES} bytes (is this a scene file?)"));
    }
    let bytes = std::fs::read(path).map_err(|e| format!("cannot be read: {e}"))?;
    if matches!(bytes[..], [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [b'<', 0, ..] | [0, b'<', ..]) {
        return Err("is text in UTF-16 (expected UTF-8: save it in that encoding)".into());
    }
    String::from_utf8(bytes).map_err(|e| {
        let line =
            e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count()
                + 1;
        format!("line {line} is not UTF-8 text")
    })
}
