//! Files in: Mitsuba 3 scenes and Nori's, and the meshes that they name.
//!
//! A scene passes through stages, one file each: `document` reads XML and keeps positions, `expand`
//! joins included files and substitutes parameters, `upgrade` brings older versions up to date and `nori`
//! says in Mitsuba's words what scenes of Nori say, `graph` finds objects and references, `check` compares them with the table of [`plugins`], and `assemble`
//! calls the constructors that the table names. Every stage reports all that it finds wrong. Those up to the
//! check run in any case, so that one error says all that is unsupported; objects are built only if there
//! is none.

use std::path::Path;

use crate::memory::Limits;
use crate::render::Description;

mod assemble;
mod bsdf;
mod check;
mod context;
mod deformable;
mod document;
mod emitter;
mod expand;
mod film;
mod given;
mod graph;
mod image;
mod image_size;
mod indices;
mod integrator;
pub mod mesh;
mod mesh_file;
mod mesh_shape;
mod metals;
mod mtl;
mod nori;
pub(crate) mod obj_materials;
mod parts;
pub mod plugins;
mod precision;
pub mod problem;
mod properties;
mod rough;
mod sampler;
mod sensor;
mod shape;
mod spectrum;
mod substitute;
mod texture;
mod transform;
mod upgrade;
mod values;
mod view;
mod work;

#[cfg(test)]
mod tests;

pub use nori::{NoriX, UnknownSide};
pub use problem::{LoadError, Position, Problem, Warning};

use assemble::Notes;
use document::{Element, Place};
use expand::Expander;
use problem::Issue;
use substitute::Parameters;

/// What the user adds to a scene file.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// Values of parameters, by name: they replace `$name` and win over `<default>`.
    pub defines: Vec<(String, String)>,
    /// What meshes and images may take.
    pub limits: Limits,
    /// Where the x axis of the camera points in a scene of Nori; `None` assumes the default, with a warning. Of
    /// no effect on other scenes.
    pub nori_x: Option<NoriX>,
}

/// A scene that was loaded.
#[derive(Debug)]
pub struct Loaded {
    /// The scene and how it is to be rendered.
    pub description: Description,
    /// What may not be as meant, each thing once, in the order of the files.
    pub warnings: Vec<Warning>,
}

/// Loads the scene file at `path`, and the files that it names.
///
/// # Errors
/// Everything that is wrong with it, as far as one stage of loading finds it.
pub fn load_scene(path: &Path, options: &LoadOptions) -> Result<Loaded, LoadError> {
    load(options, |expander| expander.file(path))
}

/// Loads the scene in `text`, as if it stood in a file at `path`, which need not exist.
///
/// # Errors
/// As [`load_scene`].
pub fn load_text(text: &str, path: &Path, options: &LoadOptions) -> Result<Loaded, LoadError> {
    load(options, |expander| expander.text(text, path))
}

fn load(
    options: &LoadOptions,
    open: impl FnOnce(&mut Expander) -> Option<Element>,
) -> Result<Loaded, LoadError> {
    let mut expander = Expander::new(Parameters::new(&options.defines));
    let root = open(&mut expander);
    let Expander { sources, parameters, issues, mut warnings, incomplete, is_nori, .. } = expander;
    warnings.extend(parameters.unused().map(|(name, value)| {
        Issue::new(
            Place::whole(0),
            format!("nothing refers to the parameter `{name}` (given as {value})"),
        )
    }));
    let mut notes = Notes { issues, warnings };
    let fail_on_issues = |notes: &Notes| match notes.issues.as_slice() {
        [] => Ok(()),
        issues => Err(LoadError::new(issues, &sources)),
    };

    let Some(mut root) = root else {
        return Err(LoadError::new(&notes.issues, &sources));
    };
    if is_nori {
        nori::translate(&mut root, options.nori_x, &mut notes);
    }
    upgrade::upgrade(&mut root, &sources, &mut notes.warnings);
    let graph = graph::build(&root, incomplete, &mut notes.issues);
    check::check(&graph, &sources, &mut notes);
    fail_on_issues(&notes)?;
    let description = assemble::assemble(&graph, &sources, &options.limits, &mut notes);
    fail_on_issues(&notes)?;
    Ok(Loaded {
        description: description.expect("a scene without issues is complete"),
        warnings: Issue::in_order(notes.warnings).iter().map(|w| w.resolve(&sources)).collect(),
    })
}
