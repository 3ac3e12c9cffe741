//! What a render is told: a scene, and how it is to be rendered.

use super::Effort;
use crate::camera::Camera;
use crate::film::FilmSettings;
use crate::integrator::IntegratorSettings;
use crate::sampler::SamplerSettings;
use crate::scene::{CameraMotion, Scene};

/// All that a render needs to know.
#[derive(Debug)]
pub struct Description {
    /// Surfaces, materials and lights.
    pub scene: Scene,
    /// Where it is seen from.
    pub camera: Camera,
    /// How the camera moves, if it does: `camera` is then at the origin.
    pub camera_motion: Option<CameraMotion>,
    /// The picture's size, filter and format.
    pub film: FilmSettings,
    /// Samples per pixel, seed and kind of the random numbers.
    pub sampler: SamplerSettings,
    /// How light is carried.
    pub integrator: IntegratorSettings,
    /// What ends a render early.
    pub effort: Effort,
}

impl Description {
    /// Whether anything is elsewhere at another moment within the shutter: only then samples have a time.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.camera_motion.is_some() || self.scene.objects().iter().any(|o| o.shape.moves())
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use glam::{DAffine3, Vec2};

    use super::*;
    use crate::camera::{Perspective, PerspectiveSettings};
    use crate::film::{ComponentFormat, Crop, Filter};
    use crate::integrator::PathSettings;
    use crate::sampler::SamplerKind;

    /// An empty scene with default settings.
    pub(crate) fn description() -> Description {
        let camera = Perspective::new(&PerspectiveSettings {
            to_world: DAffine3::IDENTITY,
            fov_x_deg: 45.0,
            aspect: 1.0,
            principal_point_offset: Vec2::ZERO,
            lens: None,
            near_clip: 0.0,
            far_clip: f32::INFINITY,
        });
        Description {
            scene: Scene::default(),
            camera: Camera::Perspective(camera.expect("valid")),
            camera_motion: None,
            film: FilmSettings {
                width: 8,
                height: 8,
                crop: Crop { x: 0, y: 0, width: 8, height: 8 },
                filter: Filter::Box,
                alpha: false,
                component: ComponentFormat::Half,
                variance: false,
                clamp: None,
            },
            sampler: SamplerSettings {
                kind: SamplerKind::Independent,
                samples_per_pixel: 1,
                seed: 0,
            },
            integrator: IntegratorSettings::Path(PathSettings::default()),
            effort: Effort::default(),
        }
    }
}
