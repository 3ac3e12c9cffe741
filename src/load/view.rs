//! The first sensor of a scene, with its film and sampler.

use super::assemble::Notes;
use super::document::Place;
use super::plugins::{Build, Category};
use super::problem::Issue;
use super::properties::Object;
use super::{film, sampler, sensor};
use crate::camera::Camera;
use crate::film::FilmSettings;
use crate::render::Effort;
use crate::sampler::SamplerSettings;
use crate::scene::CameraMotion;

/// What the first sensor says.
pub(super) struct View {
    pub(super) camera: Camera,
    pub(super) camera_motion: Option<CameraMotion>,
    pub(super) film: FilmSettings,
    pub(super) sampler: SamplerSettings,
    pub(super) effort: Effort,
    /// Where an error is asked for.
    pub(super) error: Option<Place>,
}

/// The first sensor with its film and sampler.
pub(super) fn view(sensors: &[Object<'_>], scene: Place, notes: &mut Notes) -> Option<View> {
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
    let (sampler_settings, effort, warning) = sampler::build(&sampler);
    warnings.extend(warning);
    match (sensor.plugin().build, film.plugin().build) {
        (Build::Sensor(build_camera), Build::Film(build_film)) => {
            let film_settings = build_film(&film)?;
            let camera_motion = sensor::motion(sensor)?;
            let camera = build_camera(sensor, &film_settings)?;
            Ok(View {
                camera,
                camera_motion,
                film: film_settings,
                sampler: sampler_settings,
                effort,
                error: sampler::place_of_error(&sampler),
            })
        }
        _ => unreachable!("parts are of the categories asked for"),
    }
}
