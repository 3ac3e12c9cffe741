//! Shapes whose meshes are in files of their own.

use std::path::Path;

use super::mesh::{
    LoadedMesh, MeshFileError, MeshOptions, MeshProblem, load_obj, load_ply, load_serialized,
    load_stl,
};
use super::mesh_file::MeshFile;
use super::obj_materials;
use super::plugins::{Build, Category, Plugin};
use super::problem::Issue;
use super::properties::Object;
use super::shape::{self, BuiltShape, FLIP_NORMALS, PARTS, TO_WORLD, from_mesh};
use crate::property::{Bounds, Default, Kind, PropertyInfo, property};

const FACE_NORMALS: PropertyInfo = property(
    "face_normals",
    Kind::Boolean,
    Default::Boolean(false),
    "shade with the normals of the faces, not of the vertices",
);

const MAX_SMOOTH_ANGLE: PropertyInfo = property(
    "max_smooth_angle",
    Kind::Float(Bounds::NotNegative),
    Default::Absent("the file's normals"),
    "make new vertex normals: edges where faces turn by more than so many degrees are creases",
);

/// The properties of a mesh file: what `filename` names, and whether v = 0 is the upper edge of a texture.
const fn mesh_file(filename: &'static str, flip_tex_coords: bool) -> [PropertyInfo; 6] {
    [
        property("filename", Kind::File, Default::Required, filename),
        TO_WORLD,
        FLIP_NORMALS,
        FACE_NORMALS,
        MAX_SMOOTH_ANGLE,
        property(
            "flip_tex_coords",
            Kind::Boolean,
            Default::Boolean(flip_tex_coords),
            "count v from the upper edge of a texture",
        ),
    ]
}

pub(super) static OBJ: Plugin = Plugin {
    name: "obj",
    help: "A mesh in Wavefront's text format.",
    properties: &const { mesh_file("the mesh", true) },
    parts: PARTS,
    build: Build::Shape(|object| from_file(object, load_obj)),
};

pub(super) static PLY: Plugin = Plugin {
    name: "ply",
    help: "A mesh in Stanford's format, text or binary.",
    properties: &const { mesh_file("the mesh; may be compressed (.gz)", false) },
    parts: PARTS,
    build: Build::Shape(|object| from_file(object, load_ply)),
};

pub(super) static STL: Plugin = Plugin {
    name: "stl",
    help: "A mesh in the format of 3D printers, text or binary (not in Mitsuba).",
    properties: &[
        property("filename", Kind::File, Default::Required, "the mesh; may be compressed (.gz)"),
        TO_WORLD,
        FLIP_NORMALS,
        MAX_SMOOTH_ANGLE,
    ],
    parts: PARTS,
    build: Build::Shape(|object| from_file(object, load_stl)),
};

pub(super) static SERIALIZED: Plugin = Plugin {
    name: "serialized",
    help: "A mesh in Mitsuba's own format, version 3 or 4.",
    properties: &[
        property("filename", Kind::File, Default::Required, "one or more meshes"),
        property(
            "shape_index",
            Kind::Integer(0, i32::MAX as i64),
            Default::Integer(0),
            "which mesh of the file, from 0",
        ),
        TO_WORLD,
        FLIP_NORMALS,
        FACE_NORMALS,
    ],
    parts: PARTS,
    build: Build::Shape(serialized),
};

/// The shapes that an object describes: one, or one for each material of an OBJ file if the object has none.
///
/// # Errors
/// As [`shape::build`], and what is wrong with the materials.
pub(super) fn build_all(object: &Object<'_>) -> Result<Vec<BuiltShape>, Issue> {
    let is_obj = std::ptr::eq(object.plugin(), &raw const OBJ);
    let is_bare = [Category::Bsdf, Category::Emitter]
        .into_iter()
        .all(|category| object.parts(category).next().is_none());
    if is_obj && is_bare {
        return obj_materials::build(object);
    }
    shape::build(object).map(|built| vec![built])
}

fn from_file(
    object: &Object<'_>,
    load: impl FnOnce(&Path, &MeshOptions) -> Result<LoadedMesh, MeshFileError>,
) -> Result<BuiltShape, Issue> {
    let path = object.file("filename")?;
    let loaded = load(&path, &mesh_options(object)?).map_err(|e| file_issue(object, &e))?;
    from_loaded(object, &path, loaded)
}

/// What an object says of how its file is to be read.
pub(super) fn mesh_options(object: &Object<'_>) -> Result<MeshOptions, Issue> {
    let has = |name| object.plugin().property(name).is_some();
    let face_normals = has("face_normals") && object.boolean("face_normals");
    if face_normals {
        object.refuse(&["max_smooth_angle"], "beside `face_normals`")?;
    }
    Ok(MeshOptions {
        to_world: object.transform("to_world"),
        face_normals,
        max_smooth_angle: object.number("max_smooth_angle"),
        flip_normals: object.boolean("flip_normals"),
        flip_tex_coords: has("flip_tex_coords") && object.boolean("flip_tex_coords"),
        limits: object.limits().clone(),
    })
}

/// What is wrong with the file of an object.
pub(super) fn file_issue(object: &Object<'_>, error: &MeshFileError) -> Issue {
    let issue = Issue::new(object.place_of("filename"), error.to_string());
    if let MeshProblem::Unpacked { .. } = error.problem() {
        return issue.with_help("`--max-unpacked` raises the limit");
    }
    match (error.source_line(), error.column()) {
        (Some(line), Some(_)) => issue.with_help(format!("the line is `{line}`")),
        _ => issue,
    }
}

/// The shape of a mesh out of the file at `path`; says what was left out of it.
pub(super) fn from_loaded(
    object: &Object<'_>,
    path: &Path,
    loaded: LoadedMesh,
) -> Result<BuiltShape, Issue> {
    for (message, help) in loaded.remarks.warnings() {
        let message = format!("{}: {message}", path.display());
        let issue = Issue::new(object.place_of("filename"), message);
        object.warn(issue.with_help(help).once());
    }
    let has_uvs = !loaded.mesh.uvs().is_empty();
    let file = Some(MeshFile { path: path.to_owned(), remarks: loaded.remarks, has_uvs });
    Ok(BuiltShape { file, ..from_mesh(object, loaded.mesh, loaded.dropped)? })
}

fn serialized(object: &Object<'_>) -> Result<BuiltShape, Issue> {
    let index = object.count("shape_index");
    from_file(object, |path, options| load_serialized(path, index, options))
}
