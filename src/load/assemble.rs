//! Objects to the description of a scene.

use rayon::prelude::*;

use super::context::Context;
use super::document::{Place, Sources};
use super::graph::Graph;
use super::integrator;
use super::parts::Parts;
use super::plugins::Category;
use super::problem::Issue;
use super::properties::Object;
use super::view::{View, view};
use crate::integrator::IntegratorSettings;
use crate::memory::Limits;
use crate::render::Description;
use crate::scene::Scene;

/// What is wrong, and what may not be as meant.
#[derive(Debug, Default)]
pub(super) struct Notes {
    pub(super) issues: Vec<Issue>,
    pub(super) warnings: Vec<Issue>,
}

/// The description of a graph that passed the check; `None` if issues were noted.
pub(super) fn assemble(
    graph: &Graph,
    sources: &Sources,
    limits: &Limits,
    notes: &mut Notes,
) -> Option<Description> {
    let context = Context::new(graph, sources, limits);
    let description = describe(graph, &context, notes);
    notes.warnings.append(&mut context.into_warnings());
    description
}

fn describe<'a>(graph: &Graph, context: &'a Context<'a>, notes: &mut Notes) -> Option<Description> {
    let root = graph.nodes.first()?;
    let top: Vec<Object<'_>> =
        root.children.iter().filter_map(|c| Object::new(context, c.node)).collect();
    let of = |category| -> Vec<Object<'_>> {
        top.iter().filter(|o| o.plugin().category() == category).copied().collect()
    };
    // Images take the longest; each that is named twice is decoded once.
    let textures = context.objects().filter(|o| o.plugin().category() == Category::Texture);
    let textures: Vec<_> = textures.collect();
    let broken = textures.par_iter().filter_map(|texture| texture.texture().err());
    notes.issues.extend(broken.collect::<Vec<_>>());
    if !notes.issues.is_empty() {
        return None;
    }
    let mut parts = Parts::default();
    // Materials that no shape uses are built too: what is wrong with them is worth knowing.
    for object in of(Category::Bsdf) {
        if let Err(issue) = parts.bsdf(&object) {
            notes.issues.push(issue);
        }
    }
    let objects = parts.shapes(&of(Category::Shape), notes);
    let environment = parts.lights(&of(Category::Emitter), notes);
    let view = view(&of(Category::Sensor), root.place, notes);
    let settings = integrator_settings(&of(Category::Integrator), notes);
    if !notes.issues.is_empty() {
        return None;
    }
    let View { camera, camera_motion, film, sampler, effort, error } = view?;
    let integrator = settings.unwrap_or_default();
    if let Some(place) = error.filter(|_| integrator.picture().is_none()) {
        let message = "`error` needs a picture, and the integrator makes layers alone";
        notes.issues.push(Issue::new(place, message));
        return None;
    }
    let scene = Scene::new(objects, parts.bsdfs, parts.emitters, environment)
        .expect("indices were handed out with the parts");
    notes.warnings.extend(darkness(&scene, &integrator, root.place));
    Some(Description { scene, camera, camera_motion, film, sampler, integrator, effort })
}

/// A warning if nothing in a scene emits and the integrator shows light.
fn darkness(scene: &Scene, integrator: &IntegratorSettings, place: Place) -> Option<Issue> {
    if !integrator.picture()?.about().shows_light() {
        return None;
    }
    let message = match scene.emitters() {
        [] => "the scene has no light, so its picture will be black",
        lights if lights.iter().all(|light| light.power() == Some(0.0)) => {
            "the lights of the scene are all black, and so its picture will be"
        }
        _ => return None,
    };
    let help = "light it, for instance from all sides by <emitter type=\"constant\"/>";
    Some(Issue::new(place, message).with_help(help))
}

/// The scene's integrator; `None` if it names none.
fn integrator_settings(
    integrators: &[Object<'_>],
    notes: &mut Notes,
) -> Option<IntegratorSettings> {
    for other in integrators.iter().skip(1) {
        notes.issues.push(Issue::new(other.place(), "there is more than one integrator"));
    }
    let built = integrator::build(integrators.first()?);
    built.map_err(|issue| notes.issues.push(issue)).ok()
}
