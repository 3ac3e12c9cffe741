//! Objects to the description of a scene.

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::context::Context;
use super::document::{Place, Sources};
use super::emitter::Light;
use super::graph::Graph;
use super::plugins::{Build, Category};
use super::problem::Issue;
use super::properties::Object;
use super::shape::BuiltShape;
use super::{bsdf, emitter, film, integrator, precision, sampler, sensor, shape};
use crate::bsdf::{Bsdf, Diffuse, Needs};
use crate::camera::Camera;
use crate::emitter::{Area, Emitter};
use crate::film::FilmSettings;
use crate::integrator::IntegratorSettings;
use crate::math::Rgb;
use crate::memory::Limits;
use crate::render::{Description, Effort};
use crate::sampler::SamplerSettings;
use crate::scene::{CameraMotion, Object as SceneObject, Scene};
use crate::shape::Group;
use crate::shape::mesh::Dropped;

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
    let View { camera, camera_motion, film, sampler } = view?;
    let integrator = settings.unwrap_or_default();
    let scene = Scene::new(objects, parts.bsdfs, parts.emitters, environment)
        .expect("indices were handed out with the parts");
    notes.warnings.extend(darkness(&scene, &integrator, root.place));
    Some(Description {
        scene,
        camera,
        camera_motion,
        film,
        sampler,
        integrator,
        effort: Effort::default(),
    })
}

/// Materials inside one material; scenes have a few.
const MANY_EVALUATIONS: u64 = 1000;

/// Materials and lights, as they are found.
#[derive(Default)]
struct Parts {
    bsdfs: Vec<Box<dyn Bsdf>>,
    /// Indices of materials by their objects, so that shapes share what they refer to; `None` is the
    /// material of shapes that name none.
    bsdf_of: HashMap<Option<usize>, usize>,
    /// As [`bsdf::evaluations`] finds them.
    evaluations: HashMap<usize, u64>,
    /// Index of the black material of emitters that name none, once there is one.
    black: Option<usize>,
    emitters: Vec<Box<dyn Emitter>>,
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
    fn bsdf(&mut self, object: &Object<'_>) -> Result<usize, Issue> {
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
    fn shapes(&mut self, shapes: &[Object<'_>], notes: &mut Notes) -> Vec<SceneObject> {
        let by_itself = |object: &Object<'_>| match object.plugin().build {
            Build::Group | Build::Instance => None,
            _ => Some(shape::build(object)),
        };
        let built: Vec<Option<Result<BuiltShape, Issue>>> =
            shapes.par_iter().map(by_itself).collect();
        let mut objects = Vec::with_capacity(built.len());
        for (object, built) in shapes.iter().zip(built) {
            let scene_object = match (built, object.plugin().build) {
                (Some(built), _) => {
                    built.and_then(|built| self.scene_object(object, built, &mut notes.warnings))
                }
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
        let objects = self.shapes(&members, notes);
        let bsdfs = objects.iter().map(|o| o.bsdf).collect();
        let complete = objects.len() == members.len();
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
        let group = Group::new(vec![built.shape]).expect("not an instance");
        let built = shape::instance(object, Arc::new(group))?;
        warnings.extend(precision_warnings(object, &built));
        let bsdf = self.bsdf(&object.part_or(Category::Bsdf, &bsdf::DIFFUSE))?;
        Ok(SceneObject::new(object.id(), built.shape, bsdf, None))
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

    /// A shape that does not move.
    fn resting(&mut self, object: &Object<'_>, built: BuiltShape) -> Result<SceneObject, Issue> {
        let emitter = match object.parts(Category::Emitter).next() {
            None => None,
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
        let bsdf = if emitter.is_some() && object.parts(Category::Bsdf).next().is_none() {
            self.black()
        } else {
            self.bsdf(&object.part_or(Category::Bsdf, &bsdf::DIFFUSE))?
        };
        Ok(SceneObject::new(object.id(), built.shape, bsdf, emitter))
    }

    /// Lights that belong to no shape; returns the index of the environment.
    fn lights(&mut self, lights: &[Object<'_>], notes: &mut Notes) -> Option<usize> {
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

/// What the first sensor says.
struct View {
    camera: Camera,
    camera_motion: Option<CameraMotion>,
    film: FilmSettings,
    sampler: SamplerSettings,
}

/// The first sensor with its film and sampler.
fn view(sensors: &[Object<'_>], scene: Place, notes: &mut Notes) -> Option<View> {
    let [sensor, others @ ..] = sensors else {
        let help = "add <sensor type=\"perspective\"> with a `to_world` and a `fov`";
        notes.issues.push(Issue::new(scene, "the scene has no sensor").with_help(help));
        return None;
    };
    for other in others {
        let message = "this sensor is not used: the first one of the scene is";
        notes.warnings.push(Issue::new(other.place(), message));
    }
    let view =
        build_view(sensor, &mut notes.warnings).map_err(|issue| notes.issues.push(issue)).ok()?;
    let View { camera, film, .. } = &view;
    if !camera.tells_pixels_apart(film.width, film.height) {
        let (place, message, help) = match camera {
            Camera::Perspective(_) => (
                sensor.place_of("fov"),
                "the field of view is so narrow that neighbouring pixels have the same direction as 32-bit \
                 floats",
                "make fewer pixels of it, or look along an axis, where directions are finer",
            ),
            Camera::Orthographic(_) => (
                sensor.place_of("to_world"),
                "the view is so small for its place that neighbouring pixels have the same origin as 32-bit \
                 floats",
                "make fewer pixels of it, or move the scene, with its camera, to the origin",
            ),
        };
        notes.warnings.push(Issue::new(place, message).with_help(help));
    }
    Some(view)
}

fn build_view(sensor: &Object<'_>, warnings: &mut Vec<Issue>) -> Result<View, Issue> {
    let film = sensor.part_or(Category::Film, &film::HDRFILM);
    let sampler = sensor.part_or(Category::Sampler, sampler::default());
    let (sampler_settings, warning) = sampler::build(&sampler);
    warnings.extend(warning);
    match (sensor.plugin().build, film.plugin().build) {
        (Build::Sensor(build_camera), Build::Film(build_film)) => {
            let film_settings = build_film(&film)?;
            let camera_motion = sensor::motion(sensor)?;
            let camera = build_camera(sensor, &film_settings)?;
            Ok(View { camera, camera_motion, film: film_settings, sampler: sampler_settings })
        }
        _ => unreachable!("parts are of the categories asked for"),
    }
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
