//! Objects to the surfaces, materials and lights of a scene.

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::assemble::Notes;
use super::emitter::Light;
use super::mtl::Surface;
use super::plugins::{Build, Category};
use super::problem::Issue;
use super::properties::Object;
use super::shape::BuiltShape;
use super::{bsdf, emitter, mesh_shape, precision, shape};
use crate::bsdf::{Bsdf, Diffuse, Needs};
use crate::emitter::{Area, Emitter};
use crate::math::Rgb;
use crate::scene::Object as SceneObject;
use crate::shape::Group;
use crate::shape::mesh::Dropped;

/// Materials inside one material; scenes have a few.
const MANY_EVALUATIONS: u64 = 1000;

/// Materials and lights, as they are found.
#[derive(Default)]
pub(super) struct Parts {
    pub(super) bsdfs: Vec<Box<dyn Bsdf>>,
    /// Indices of materials by their objects, so that shapes share what they refer to; `None` is the
    /// material of shapes that name none.
    bsdf_of: HashMap<Option<usize>, usize>,
    /// As [`bsdf::evaluations`] finds them.
    evaluations: HashMap<usize, u64>,
    /// Index of the black material of emitters that name none, once there is one.
    black: Option<usize>,
    pub(super) emitters: Vec<Box<dyn Emitter>>,
    /// Groups by their objects; `None` where something is wrong with one, which has been noted.
    groups: HashMap<Option<usize>, Option<BuiltGroup>>,
}

/// A group with the indices of its shapes' materials.
#[derive(Clone)]
struct BuiltGroup {
    group: Arc<Group>,
    bsdfs: Arc<[usize]>,
}

impl Parts {
    /// The index of a material.
    pub(super) fn bsdf(&mut self, object: &Object<'_>) -> Result<usize, Issue> {
        if let Some(&index) = self.bsdf_of.get(&object.index()) {
            return Ok(index);
        }
        self.bsdfs.push(bsdf::build(object)?);
        let index = self.bsdfs.len() - 1;
        self.bsdf_of.insert(object.index(), index);
        Ok(index)
    }

    /// The index of the black material.
    fn black(&mut self) -> usize {
        *self.black.get_or_insert_with(|| {
            self.bsdfs.push(Box::new(Diffuse::new(Rgb::ZERO)));
            self.bsdfs.len() - 1
        })
    }

    fn emitter(&mut self, emitter: Box<dyn Emitter>) -> usize {
        self.emitters.push(emitter);
        self.emitters.len() - 1
    }

    /// All shapes in the order of the file. Meshes are read in parallel.
    pub(super) fn shapes(&mut self, shapes: &[Object<'_>], notes: &mut Notes) -> Vec<SceneObject> {
        let by_itself = |object: &Object<'_>| match object.plugin().build {
            Build::Group | Build::Instance => None,
            _ => Some(mesh_shape::build_all(object)),
        };
        let built: Vec<Option<Result<Vec<BuiltShape>, Issue>>> =
            shapes.par_iter().map(by_itself).collect();
        let mut objects = Vec::with_capacity(built.len());
        for (object, built) in shapes.iter().zip(built) {
            let scene_object = match (built, object.plugin().build) {
                (Some(Ok(parts)), _) => {
                    for part in parts {
                        match self.scene_object(object, part, &mut notes.warnings) {
                            Ok(scene_object) => objects.push(scene_object),
                            Err(issue) => notes.issues.push(issue),
                        }
                    }
                    continue;
                }
                (Some(Err(issue)), _) => Err(issue),
                (None, Build::Instance) => match self.instance(object, notes) {
                    Some(instance) => instance,
                    None => continue,
                },
                // Groups are built even if nothing refers to them, like materials.
                (None, _) => {
                    self.group(object, notes);
                    continue;
                }
            };
            match scene_object {
                Ok(scene_object) => objects.push(scene_object),
                Err(issue) => notes.issues.push(issue),
            }
        }
        objects
    }

    /// A group, built once. `None` if something is wrong with it, which is noted the first time.
    fn group(&mut self, object: &Object<'_>, notes: &mut Notes) -> Option<BuiltGroup> {
        if let Some(known) = self.groups.get(&object.index()) {
            return known.clone();
        }
        let built = self.build_group(object, notes);
        self.groups.insert(object.index(), built.clone());
        built
    }

    fn build_group(&mut self, object: &Object<'_>, notes: &mut Notes) -> Option<BuiltGroup> {
        let members: Vec<_> = object.parts(Category::Shape).collect();
        let problems = members.iter().filter_map(|member| {
            let name = member.plugin().name;
            if matches!(member.plugin().build, Build::Group | Build::Instance) {
                let message = format!("shape `{name}` cannot stand inside a `shapegroup`");
                return Some(Issue::new(member.place(), message));
            }
            if member.motion("to_world").is_some() {
                let message = "a shape inside a `shapegroup` cannot be animated";
                let help = "animate the instance, or put the shape into the scene itself";
                return Some(Issue::new(member.place_of("to_world"), message).with_help(help));
            }
            let light = member.parts(Category::Emitter).next()?;
            let message = "a shape that emits cannot stand inside a `shapegroup`";
            let help = "lights cannot be instanced: place the shape in the scene itself";
            Some(Issue::new(light.place(), message).with_help(help))
        });
        let problems: Vec<_> = problems.collect();
        if !problems.is_empty() {
            notes.issues.extend(problems);
            return None;
        }
        let before = notes.issues.len();
        let objects = self.shapes(&members, notes);
        let glows = objects.iter().any(|o| o.emitter.is_some());
        if glows {
            let message = "a shape that emits cannot stand inside a `shapegroup`";
            let help = "lights cannot be instanced: give the shape a <bsdf>, so that the material of its file does not count";
            notes.issues.push(Issue::new(object.place(), message).with_help(help));
        }
        let bsdfs = objects.iter().map(|o| o.bsdf).collect();
        let complete = notes.issues.len() == before;
        let group = Group::new(objects.into_iter().map(|o| o.shape).collect());
        let group = Arc::new(group.expect("checked to have no instances"));
        complete.then_some(BuiltGroup { group, bsdfs })
    }

    /// An instance; `None` if its group is wrong, which is noted elsewhere.
    fn instance(
        &mut self,
        object: &Object<'_>,
        notes: &mut Notes,
    ) -> Option<Result<SceneObject, Issue>> {
        let part = object.parts(Category::Shape).next()?;
        if !matches!(part.plugin().build, Build::Group) {
            let message =
                format!("an instance is of a `shapegroup`, and `{}` is none", part.plugin().name);
            let help = "put the shape into a <shape type=\"shapegroup\"> with an id";
            return Some(Err(Issue::new(object.place(), message).with_help(help)));
        }
        let BuiltGroup { group, bsdfs } = self.group(&part, notes)?;
        Some(shape::instance(object, group).map(|built| {
            notes.warnings.extend(precision_warnings(object, &built));
            SceneObject {
                name: object.id().to_owned(),
                shape: built.shape,
                bsdf: bsdfs[0],
                members: bsdfs,
                emitter: None,
            }
        }))
    }

    /// A shape that moves: an instance of its own.
    fn moving(
        &mut self,
        object: &Object<'_>,
        built: BuiltShape,
        warnings: &mut Vec<Issue>,
    ) -> Result<SceneObject, Issue> {
        if let Some(light) = object.parts(Category::Emitter).next() {
            let message = "a shape that moves while the shutter is open cannot emit";
            let help = "let the shape rest, or light the scene by another one";
            return Err(Issue::new(light.place(), message).with_help(help));
        }
        let surface = built.surface;
        if surface.as_ref().is_some_and(|(_, surface)| surface.emission.is_some()) {
            let message =
                "a shape that moves while the shutter is open cannot emit, as its file says";
            let help = "let the shape rest, or give it a <bsdf>";
            return Err(Issue::new(object.place_of("filename"), message).with_help(help));
        }
        let group = Group::new(vec![built.shape]).expect("not an instance");
        let built = shape::instance(object, Arc::new(group))?;
        warnings.extend(precision_warnings(object, &built));
        let (name, bsdf) = self.material(object, surface)?;
        Ok(SceneObject::new(&name, built.shape, bsdf, None))
    }

    fn scene_object(
        &mut self,
        object: &Object<'_>,
        mut built: BuiltShape,
        warnings: &mut Vec<Issue>,
    ) -> Result<SceneObject, Issue> {
        warnings.extend(dropped_warning(object, built.dropped));
        warnings.extend(precision_warnings(object, &built));
        let file = built.file.take();
        let scene_object = if object.motion("to_world").is_some() {
            self.moving(object, built, warnings)?
        } else {
            self.resting(object, built)?
        };
        if let Some(material) = object.parts(Category::Bsdf).next() {
            let count = bsdf::evaluations(&material, &mut self.evaluations);
            warnings.extend((count > MANY_EVALUATIONS).then(|| {
                let message = format!(
                    "material `{}` asks others {count} times at each point: a render will take as long",
                    material.id()
                );
                let help = "let mixtures share fewer materials";
                Issue::new(material.place(), message).with_help(help).once()
            }));
        }
        let light = scene_object.emitter.map(|i| self.emitters[i].is_textured());
        let varies = self.bsdfs[scene_object.bsdf].flags().needs > Needs::Nothing;
        let file = file.iter().flat_map(|f| f.warnings(object, varies || light == Some(true)));
        warnings.extend(file);
        Ok(scene_object)
    }

    /// The name of a shape and the index of its material: that of its file, the scene's, or the usual one.
    fn material(
        &mut self,
        object: &Object<'_>,
        surface: Option<(String, Surface)>,
    ) -> Result<(String, usize), Issue> {
        let id = object.id();
        let Some((name, Surface { bsdf, .. })) = surface else {
            let bsdf = self.bsdf(&object.part_or(Category::Bsdf, &bsdf::DIFFUSE))?;
            return Ok((id.to_owned(), bsdf));
        };
        self.bsdfs.push(bsdf);
        let name = if id.is_empty() { name } else { format!("{id} {name}") };
        Ok((name, self.bsdfs.len() - 1))
    }

    /// A shape that does not move.
    fn resting(&mut self, object: &Object<'_>, built: BuiltShape) -> Result<SceneObject, Issue> {
        let glow = built.surface.as_ref().and_then(|(_, surface)| surface.emission);
        let emitter = match object.parts(Category::Emitter).next() {
            None => match glow.map(|radiance| Area::new(built.shape.clone(), radiance)) {
                Some(None) => {
                    let message = "a material of this file emits, and its faces have no area that an f32 can hold";
                    return Err(Issue::new(object.place_of("filename"), message));
                }
                area => area.flatten().map(|area| self.emitter(Box::new(area))),
            },
            Some(light) => match emitter::build(&light)? {
                Light::Area(radiance) => {
                    let area = Area::new(built.shape.clone(), radiance).ok_or_else(|| {
                        Issue::new(
                            light.place(),
                            "the shape of this emitter has no area that an f32 can hold",
                        )
                    })?;
                    Some(self.emitter(Box::new(area)))
                }
                Light::Environment(_) | Light::Unseen(_) => {
                    let name = light.plugin().name;
                    let message =
                        format!("emitter `{name}` cannot stand inside a shape (expected `area`)");
                    return Err(Issue::new(light.place(), message));
                }
            },
        };
        // An emitter without a material reflects nothing, as in Mitsuba.
        let is_bare = built.surface.is_none() && object.parts(Category::Bsdf).next().is_none();
        let (name, bsdf) = if emitter.is_some() && is_bare {
            (object.id().to_owned(), self.black())
        } else {
            self.material(object, built.surface)?
        };
        Ok(SceneObject::new(&name, built.shape, bsdf, emitter))
    }

    /// Lights that belong to no shape; returns the index of the environment.
    pub(super) fn lights(&mut self, lights: &[Object<'_>], notes: &mut Notes) -> Option<usize> {
        let mut environment = None;
        for light in lights {
            match emitter::build(light) {
                Err(issue) => notes.issues.push(issue),
                Ok(Light::Unseen(light)) => {
                    self.emitter(light);
                }
                Ok(Light::Environment(_)) if environment.is_some() => {
                    let message = "there is more than one light from outside of the scene";
                    notes.issues.push(Issue::new(light.place(), message));
                }
                Ok(Light::Environment(sky)) => environment = Some(self.emitter(sky)),
                // With an id it is there to be referred to by shapes.
                Ok(Light::Area(_)) if light.id().is_empty() => {
                    let message = "emitter `area` belongs inside the shape that emits";
                    notes.issues.push(Issue::new(light.place(), message));
                }
                Ok(Light::Area(_)) => {}
            }
        }
        environment
    }
}

fn precision_warnings(object: &Object<'_>, built: &BuiltShape) -> Vec<Issue> {
    let doubts = precision::doubts(built.shape.as_ref()).into_iter();
    let issue = |(message, help): (String, String)| {
        Issue::new(object.place_of("to_world"), message).with_help(help)
    };
    doubts.map(issue).collect()
}

fn dropped_warning(object: &Object<'_>, dropped: Dropped) -> Option<Issue> {
    let place = object.place_of("filename");
    (!dropped.is_none()).then(|| Issue::new(place, dropped.to_string()))
}
