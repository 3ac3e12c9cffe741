//! What a scene requires of the renderer, and what it does not, so that no time is spent on it.

use std::collections::HashSet;
use std::fmt::{self, Display, Formatter};
use std::sync::Arc;

use super::Description;
use crate::bsdf::Needs;
use crate::camera::{Camera, Lens};
use crate::film::AovKind;
use crate::integrator::settings::{Part, Reason};
use crate::integrator::{IntegratorSettings, Settings};
use crate::scene::{Object, Scene};
use crate::shape::{Geometry, Shape};

#[cfg(test)]
mod tests;

/// For each feature whether a render of a [`Description`] models it, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Requirements {
    decisions: Vec<Decision>,
    carried: Vec<Part>,
}

/// One feature.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Decision {
    /// What it is about.
    pub feature: Feature,
    /// Whether the render models it, or skips it.
    pub modelled: bool,
    /// Why: a fragment.
    pub reason: String,
}

/// Something that costs time or memory, and that not every scene needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Feature {
    /// Motion within the shutter.
    Time,
    /// A lens that is no pinhole.
    Lens,
    /// Shapes that are stored once and placed many times.
    Instances,
    /// Materials that vary over a surface.
    Textures,
    /// Shading normals that are interpolated between vertices.
    VertexNormals,
    /// Texture coordinates of hits.
    TextureCoordinates,
    /// Light from outside of the scene.
    EnvironmentLight,
    /// Shadow rays to emitters.
    NextEventEstimation,
    /// Weights between shadow rays and scattered rays.
    MultipleImportanceSampling,
    /// Paths that end by chance.
    RussianRoulette,
    /// Camera rays that pass through emitters.
    HiddenEmitters,
    /// An alpha channel.
    Alpha,
    /// Layers beside the picture.
    Layers,
    /// An estimate of each pixel's error.
    Variance,
}

impl Display for Feature {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Time => "time",
            Self::Lens => "lens",
            Self::Instances => "instances",
            Self::Textures => "textures",
            Self::VertexNormals => "vertex normals",
            Self::TextureCoordinates => "texture coordinates",
            Self::EnvironmentLight => "environment light",
            Self::NextEventEstimation => "next-event estimation",
            Self::MultipleImportanceSampling => "multiple importance sampling",
            Self::RussianRoulette => "Russian roulette",
            Self::HiddenEmitters => "hidden emitters",
            Self::Alpha => "alpha",
            Self::Layers => "layers",
            Self::Variance => "variance",
        })
    }
}

impl Requirements {
    /// What a render of `description` requires.
    #[must_use]
    pub fn of(description: &Description) -> Self {
        let Description { scene, film, integrator, .. } = description;
        let skipped = |reason: &str| Err(reason.to_owned());
        let picture = picture(integrator);
        let of_picture = |ask: &dyn Fn(&dyn Settings) -> Reason| picture.clone().and_then(ask);
        let alpha = if film.alpha {
            Ok("the film has an alpha channel".to_owned())
        } else {
            skipped("the film has no alpha channel")
        };
        let decisions = [
            (Feature::Time, time(description)),
            (Feature::Lens, lens(&description.camera)),
            (Feature::Instances, instances(scene)),
            (Feature::Textures, textures(scene)),
            (Feature::VertexNormals, vertex_normals(scene)),
            (Feature::TextureCoordinates, texture_coordinates(integrator, scene)),
            (Feature::EnvironmentLight, environment_light(scene)),
            (Feature::NextEventEstimation, of_picture(&|p| p.next_event_estimation(scene))),
            (
                Feature::MultipleImportanceSampling,
                of_picture(&|p| p.multiple_importance_sampling(scene)),
            ),
            (Feature::RussianRoulette, of_picture(&|p| p.russian_roulette())),
            (Feature::HiddenEmitters, hidden_emitters(integrator)),
            (Feature::Alpha, alpha),
            (Feature::Layers, layers(integrator)),
            (Feature::Variance, variance(description)),
        ];
        let decide = |(feature, reason): (Feature, Reason)| Decision {
            feature,
            modelled: reason.is_ok(),
            reason: reason.unwrap_or_else(|why| why),
        };
        let carried = integrator.picture().map(|picture| picture.about().carried(scene));
        Self {
            decisions: decisions.into_iter().map(decide).collect(),
            carried: carried.unwrap_or_default(),
        }
    }

    /// What paths carry from one surface to the next, and what they leave out; nothing unless many are under way at once.
    #[must_use]
    pub fn carried(&self) -> &[Part] {
        &self.carried
    }

    /// All features, modelled or not.
    #[must_use]
    pub fn decisions(&self) -> &[Decision] {
        &self.decisions
    }

    /// Whether a feature is modelled.
    #[must_use]
    pub fn models(&self, feature: Feature) -> bool {
        self.decisions.iter().any(|d| d.feature == feature && d.modelled)
    }
}

fn lens(camera: &Camera) -> Reason {
    match camera {
        Camera::Orthographic(_) => Err("the camera's rays are parallel".to_owned()),
        Camera::Perspective(camera) => match camera.lens() {
            None => Err("the camera is a pinhole".to_owned()),
            Some(Lens { aperture_radius, focus_distance }) => Ok(format!(
                "the aperture has a radius of {aperture_radius}, the focus is at {focus_distance}"
            )),
        },
    }
}

fn time(description: &Description) -> Reason {
    let objects = description.scene.objects();
    let shapes = objects.iter().filter(|o| o.shape.moves()).count();
    let shapes = format!("{shapes} of {} shapes", objects.len());
    match (description.moves(), &description.camera_motion) {
        (false, _) => Err("nothing moves while the shutter is open".to_owned()),
        (true, None) => Ok(format!("while the shutter is open move {shapes}")),
        (true, Some(_)) => Ok(format!("while the shutter is open move the camera and {shapes}")),
    }
}

fn instances(scene: &Scene) -> Reason {
    let groups = scene.objects().iter().filter_map(|o| match o.shape.geometry() {
        Geometry::Instance(instance) => Some(Arc::as_ptr(instance.group())),
        Geometry::Triangles { .. } | Geometry::Deforming(_) | Geometry::Analytic(_) => None,
    });
    let groups: Vec<_> = groups.collect();
    match (groups.len(), groups.iter().collect::<HashSet<_>>().len()) {
        (0, _) => Err("every shape is placed once".to_owned()),
        (count, 1) => Ok(format!("{count} of one group of shapes")),
        (count, different) => Ok(format!("{count} of {different} groups of shapes")),
    }
}

fn vertex_normals(scene: &Scene) -> Reason {
    let triangles = |shape: &dyn Shape| {
        matches!(shape.geometry(), Geometry::Triangles { .. } | Geometry::Deforming(_))
    };
    let is_mesh = |o: &&Object| match o.shape.geometry() {
        Geometry::Instance(i) => i.group().shapes().iter().any(|s| triangles(s.as_ref())),
        _ => triangles(o.shape.as_ref()),
    };
    let meshes = scene.objects().iter().filter(is_mesh).count();
    let smooth = scene.objects().iter().filter(|o| o.shape.has_vertex_normals()).count();
    match (smooth, meshes) {
        (0, 0) => Err("there is no mesh".to_owned()),
        (0, _) => Err("no mesh has them".to_owned()),
        _ => Ok(format!("{smooth} of {meshes} meshes have them")),
    }
}

/// How many surfaces have a material that has to be told so much of the place.
fn surfaces_that_need(scene: &Scene, needs: Needs) -> usize {
    let needed = |&bsdf: &usize| scene.bsdfs()[bsdf].flags().needs >= needs;
    scene.objects().iter().filter(|o| o.bsdfs().iter().any(needed)).count()
}

fn textured_lights(scene: &Scene) -> usize {
    scene.emitters().iter().filter(|e| e.is_textured()).count()
}

fn textures(scene: &Scene) -> Reason {
    let materials =
        || format!("of {} surfaces have materials that depend on the place", scene.objects().len());
    match (surfaces_that_need(scene, Needs::TextureCoordinates), textured_lights(scene)) {
        (0, 0) => Err("every material and light is the same all over its surface".to_owned()),
        (count, 0) => Ok(format!("{count} {}", materials())),
        (count, lights) => Ok(format!("{count} {}, and {lights} lights do", materials())),
    }
}

fn texture_coordinates(integrator: &IntegratorSettings, scene: &Scene) -> Reason {
    let shown = integrator.layers().iter().any(|l| l.kind == AovKind::Uv);
    let read = surfaces_that_need(scene, Needs::TextureCoordinates);
    match (shown, read, surfaces_that_need(scene, Needs::Tangents)) {
        (true, ..) => Ok("a layer shows them".to_owned()),
        (false, 0, _) if textured_lights(scene) > 0 => Ok("lights read them".to_owned()),
        (false, 0, _) => Err("no texture and no layer reads them".to_owned()),
        (false, _, 0) => Ok(format!("{read} surfaces have materials that read them")),
        (false, _, tangents) => {
            Ok(format!("{tangents} surfaces of {read} need their tangents too"))
        }
    }
}

fn environment_light(scene: &Scene) -> Reason {
    match scene.environment() {
        Some((_, emitter)) => Ok(format!("rays that leave the scene see `{}`", emitter.kind())),
        None => Err("rays that leave the scene see black".to_owned()),
    }
}

/// The integrator that makes the picture, or why there is none.
fn picture(integrator: &IntegratorSettings) -> Result<&dyn Settings, String> {
    let picture = integrator.picture().map(IntegratorSettings::about);
    picture.ok_or_else(|| "layers alone are asked for".to_owned())
}

fn hidden_emitters(integrator: &IntegratorSettings) -> Reason {
    if integrator.picture().is_some_and(|picture| picture.about().common().hide_emitters) {
        Ok("camera rays pass through emitters".to_owned())
    } else {
        Err("the camera sees emitters as other surfaces".to_owned())
    }
}

fn layers(integrator: &IntegratorSettings) -> Reason {
    match integrator.layers() {
        [] => Err("none is asked for".to_owned()),
        layers => {
            let names: Vec<_> = layers.iter().map(|l| l.name.as_str()).collect();
            Ok(names.join(", "))
        }
    }
}

fn variance(description: &Description) -> Reason {
    let Description { film, effort, .. } = description;
    let reasons = [
        (film.variance, "the film has layers for it"),
        (effort.needs_error(), "an error is to be reached"),
        (effort.adaptive, "noisy parts get more samples"),
    ];
    let asked: Vec<_> = reasons.iter().filter(|(asked, _)| *asked).map(|(_, why)| *why).collect();
    if asked.is_empty() {
        return Err("nothing asks for an estimate of the error".to_owned());
    }
    picture(&description.integrator).map(|_| asked.join(", "))
}
