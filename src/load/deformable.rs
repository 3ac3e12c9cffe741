//! `deformable`: a mesh that changes its form while the shutter is open.

use std::sync::Arc;

use super::mesh::fans;
use super::mesh_file::MeshFile;
use super::plugins::{Build, Category, Part, Plugin};
use super::problem::Issue;
use super::properties::Object;
use super::shape::{self, BuiltShape};
use super::values::numbers;
use crate::property::{Default, Kind, property};
use crate::shape::deforming::DeformingError;
use crate::shape::{DeformingMesh, TriangleMesh};

pub(super) static DEFORMABLE: Plugin = Plugin {
    name: "deformable",
    help: "A mesh that goes from one form to the next while the shutter is open; all have the same faces (not in \
           Mitsuba 3).",
    properties: &[property(
        "times",
        Kind::Text,
        Default::Absent("equally spaced from 0 to 1"),
        "when it has which form, by the clock of animations",
    )],
    parts: &[
        Part { category: Category::Shape, least: 1, most: u32::MAX as usize },
        Part::optional(Category::Bsdf),
    ],
    build: Build::Shape(build),
};

fn build(object: &Object<'_>) -> Result<BuiltShape, Issue> {
    let forms: Vec<_> = object.parts(Category::Shape).collect();
    let built = forms.iter().map(form).collect::<Result<Vec<_>, _>>()?;
    let file = built[0].1.clone();
    let meshes = with_triangles_of_first(built);
    let times = times(object, forms.len())?;
    let (open, close) = object.shutter();
    // A shutter without length sees the moment at which it opens.
    let length = if close > open { close - open } else { 1.0 };
    let keys = times.iter().map(|time| (time - open) / length).zip(meshes).collect();
    let mesh = DeformingMesh::new(keys).map_err(|error| match error {
        DeformingError::Topology { key } | DeformingError::Attribute { key, .. } => {
            Issue::new(forms[key].place(), error.to_string())
                .with_help("export all forms of one mesh, with the same vertices in the same order")
        }
        DeformingError::Keys(_) => Issue::new(object.place_of("times"), "times must ascend"),
    })?;
    if close > open {
        Ok(BuiltShape { file, ..BuiltShape::new(Arc::new(mesh)) })
    } else {
        Ok(BuiltShape { file, ..BuiltShape::from_mesh(Arc::new(mesh.at(0.0))) })
    }
}

/// The meshes; those whose polygons are the first one's, but were cut otherwise, are cut as the first one is.
fn with_triangles_of_first(
    forms: Vec<(Arc<TriangleMesh>, Option<MeshFile>)>,
) -> impl Iterator<Item = Arc<TriangleMesh>> {
    let fans_of = |mesh: &TriangleMesh, file: &Option<MeshFile>| {
        fans(mesh.triangles(), file.as_ref().map_or(&[], |f| &f.remarks.replaced))
    };
    let (first, first_fans) = (Arc::clone(&forms[0].0), fans_of(&forms[0].0, &forms[0].1));
    forms.into_iter().map(move |(mesh, file)| {
        if mesh.triangles() == first.triangles() || fans_of(&mesh, &file) != first_fans {
            return mesh;
        }
        let same = TriangleMesh::new(
            mesh.positions().to_vec(),
            first.triangles().to_vec(),
            mesh.normals().to_vec(),
            mesh.uvs().to_vec(),
        );
        // A cut that leaves a triangle without area is none for all forms.
        same.ok().filter(|(_, dropped)| dropped.is_none()).map_or(mesh, |(mesh, _)| Arc::new(mesh))
    })
}

/// One of the forms.
fn form(object: &Object<'_>) -> Result<(Arc<TriangleMesh>, Option<MeshFile>), Issue> {
    let name = object.plugin().name;
    if let Some(part) = [Category::Bsdf, Category::Emitter]
        .into_iter()
        .find_map(|category| object.parts(category).next())
    {
        let message =
            format!("a {} inside a form of a `deformable`", part.plugin().category().tag());
        let help =
            "put the material into the `deformable` itself; what changes its form cannot emit";
        return Err(Issue::new(part.place(), message).with_help(help));
    }
    if object.has("to_world") && object.motion("to_world").is_some() {
        let message = "a form of a `deformable` cannot be animated";
        let help = "add forms: one for each moment";
        return Err(Issue::new(object.place_of("to_world"), message).with_help(help));
    }
    let unsuitable = || {
        Issue::new(
            object.place(),
            format!("shape `{name}` is no mesh, as the forms of a `deformable` must be"),
        )
    };
    if !matches!(object.plugin().build, Build::Shape(_)) {
        return Err(unsuitable());
    }
    let BuiltShape { mesh, dropped, file, .. } = shape::build(object)?;
    let mesh = mesh.ok_or_else(unsuitable)?;
    if !dropped.is_none() {
        let message =
            format!("{dropped}, so this form of a `deformable` has not the faces of the others");
        return Err(Issue::new(object.place(), message));
    }
    Ok((mesh, file))
}

/// When the forms are taken.
fn times(object: &Object<'_>, forms: usize) -> Result<Vec<f64>, Issue> {
    let Some(text) = object.text("times") else {
        let last = (forms.max(2) - 1) as f64;
        return Ok((0..forms).map(|form| form as f64 / last).collect());
    };
    let place = object.place_of("times");
    let times = numbers(text, place)?;
    if times.len() != forms {
        let message = format!("{} times for {forms} forms", times.len());
        return Err(Issue::new(place, message).with_help("give one for each form, in their order"));
    }
    Ok(times)
}
