//! The materials of an OBJ file, where a scene gives its shape none.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use super::mesh::{LoadedMesh, Materials, ObjMaterials, load_obj, load_obj_by_material};
use super::mesh_shape;
use super::mtl::{self, Library, Mtl};
use super::problem::Issue;
use super::properties::Object;
use super::shape::BuiltShape;
use crate::math::Aabb;
use crate::memory::Limits;
use crate::property::named::quoted;
use crate::shape::Shape;

/// Names that a message shows.
const MOST_SHOWN: usize = 5;

/// The libraries that a file names and that are there; names may have spaces, and several may stand in a line.
pub(crate) fn library_files(mesh: &Path, names: &[String]) -> Vec<PathBuf> {
    let folder = mesh.parent().unwrap_or(Path::new(""));
    let existing = |name: &str| {
        let found = [folder.join(name), folder.join(name.replace('\\', "/"))];
        found.into_iter().find(|path| path.is_file())
    };
    let of_line = |line: &String| match existing(line) {
        Some(path) => vec![path],
        None => line.split_whitespace().filter_map(existing).collect(),
    };
    let mut files: Vec<PathBuf> = Vec::new();
    for path in names.iter().flat_map(of_line) {
        if !files.contains(&path) {
            files.push(path);
        }
    }
    files
}

/// What a mesh file has of materials, as far as what shows it has to know.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Overview {
    /// Whether a face has one that is defined.
    pub(crate) any: bool,
    /// Whether one of those emits.
    pub(crate) emits: bool,
}

impl Overview {
    /// That of an OBJ file with these names. What is wrong with its libraries is said by whoever loads the scene.
    pub(crate) fn of(
        path: &Path,
        libraries: &[String],
        used: &HashSet<&str>,
        limits: &Limits,
    ) -> Self {
        let libraries = library_files(path, libraries);
        let mut overview = Self::default();
        for library in libraries.iter().map(|path| Library::read(path, limits)) {
            let Ok(library) = library else {
                overview.any = true;
                continue;
            };
            for mtl in library.materials.iter().filter(|m| used.contains(m.name.as_str())) {
                overview.any = true;
                overview.emits |= mtl.emission.is_some_and(|e| e.max_element() > 0.0);
            }
        }
        overview
    }
}

/// A shape for each material of an OBJ file.
pub(super) fn build(object: &Object<'_>) -> Result<Vec<BuiltShape>, Issue> {
    let path = object.file("filename")?;
    let options = mesh_shape::mesh_options(object)?;
    let issue = |message: String| Issue::new(object.place_of("filename"), message);
    let whole = || {
        let loaded = load_obj(&path, &options).map_err(|e| mesh_shape::file_issue(object, &e))?;
        Ok(vec![mesh_shape::from_loaded(object, &path, loaded)?])
    };
    let ObjMaterials { libraries, meshes } = load_obj_by_material(&path, &options)
        .map_err(|error| mesh_shape::file_issue(object, &error))?;
    let files = library_files(&path, &libraries);
    let libraries = files.iter().map(|file| Library::read(file, object.limits()));
    let libraries = libraries.collect::<Result<Vec<_>, _>>().map_err(issue)?;
    let mut defined: HashMap<&str, (&Library, &Mtl)> = HashMap::new();
    for library in &libraries {
        for mtl in &library.materials {
            // Of two with one name the first counts.
            defined.entry(&mtl.name).or_insert((library, mtl));
        }
    }
    let found: Vec<_> = meshes
        .iter()
        .map(|(name, _)| name.as_deref().and_then(|name| defined.get(name)).copied())
        .collect();
    if found.iter().all(Option::is_none) {
        return whole();
    }
    say_what_is_left_out(object, &path, &libraries, &meshes, &found);
    let size = meshes.iter().fold(Aabb::EMPTY, |all, (_, m)| all.union(m.mesh.bounds()));
    let size = f64::from((size.max - size.min).length());
    let mut built = Vec::with_capacity(meshes.len());
    let mut plastics = mtl::Plastics::default();
    let mut lost: Option<Issue> = None;
    for ((name, loaded), mtl) in meshes.into_iter().zip(found) {
        // A material all of whose faces have no area is no reason to refuse the others.
        let mut part = match mesh_shape::from_loaded(object, &path, loaded) {
            Ok(part) => part,
            Err(issue) => {
                lost.get_or_insert(issue);
                continue;
            }
        };
        // They are used, and what is not has been said.
        if let Some(file) = &mut part.file {
            file.remarks.materials = Materials::default();
        }
        if let Some((library, mtl)) = mtl {
            let folder = library.path.parent().unwrap_or(Path::new(""));
            let surface =
                mtl::surface(mtl, object, folder, options.flip_tex_coords, size, &mut plastics);
            let in_material = |problem: String| {
                issue(format!("{}: material `{}`: {problem}", library.path.display(), mtl.name))
            };
            part.surface = Some((name.unwrap_or_default(), surface.map_err(in_material)?));
        }
        built.push(part);
    }
    match lost {
        Some(issue) if built.is_empty() => Err(issue),
        _ => Ok(built),
    }
}

/// Warns of statements without effect, and of materials that are not defined.
fn say_what_is_left_out(
    object: &Object<'_>,
    path: &Path,
    libraries: &[Library],
    meshes: &[(Option<String>, LoadedMesh)],
    found: &[Option<(&Library, &Mtl)>],
) {
    let warn = |message: String, help: &str| {
        object.warn(Issue::new(object.place_of("filename"), message).with_help(help).once());
    };
    for library in libraries.iter().filter(|library| !library.unused.is_empty()) {
        let names = quoted(library.unused.iter().map(String::as_str));
        let help = "what counts is Kd, Ks, Ns, Ni, d or Tr, Tf, illum, Ke, map_Kd, map_d, map_Bump and norm";
        warn(format!("{}: without effect: {names}", library.path.display()), help);
    }
    let undefined = meshes.iter().zip(found).filter(|(_, found)| found.is_none());
    let names: Vec<_> = undefined.filter_map(|((name, _), _)| name.as_deref()).collect();
    if !names.is_empty() {
        let more = if names.len() > MOST_SHOWN { ", …" } else { "" };
        let shown = quoted(names.into_iter().take(MOST_SHOWN));
        let message = format!("{}: no material is defined for {shown}{more}", path.display());
        warn(message, "those faces are grey; define it in the .mtl file");
    }
}
