//! What paths carry from one surface to the next: always, and only where the scene requires it.

use super::PathSettings;
use super::state::State;
use crate::integrator::Settings;
use crate::integrator::settings::{Part, Reason};
use crate::ray::Rays;
use crate::scene::Scene;

/// Numbers that paths carry only where something reads them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extras {
    /// When within the shutter's time the path is followed.
    pub time: bool,
    /// Product of the relative indices that the path was refracted by, for Russian roulette.
    pub eta: bool,
    /// Density of the last edge, for multiple importance sampling.
    pub pdf: bool,
}

/// Bytes of one number.
const NUMBER: usize = size_of::<f32>();

impl Extras {
    /// Everything, as if the scene required it.
    pub const ALL: Self = Self { time: true, eta: true, pdf: true };

    /// What paths have to carry in `scene`.
    #[must_use]
    pub fn of(settings: &PathSettings, scene: &Scene) -> Self {
        Self {
            time: time(scene).is_ok(),
            eta: eta(scene).is_ok(),
            pdf: settings.multiple_importance_sampling(scene).is_ok(),
        }
    }
}

/// All that a path may carry, and why it does or does not.
pub(super) fn parts(settings: &PathSettings, scene: &Scene) -> Vec<Part> {
    let part = |name, bytes, reason| Part { name, bytes, reason };
    let always = |name, bytes, why: &str| part(name, bytes, Ok(why.to_owned()));
    vec![
        always("ray", Rays::BYTES, "origin, direction and segment"),
        always("surface that it leaves", Rays::END_BYTES, "so that it is not met again"),
        always("state", State::BYTES, "throughput, edges, sample, place in its random numbers"),
        part("time", NUMBER, time(scene)),
        part("relative index", NUMBER, eta(scene)),
        part("density of the last edge", NUMBER, settings.multiple_importance_sampling(scene)),
    ]
}

fn time(scene: &Scene) -> Reason {
    // A camera that moves is told the time before the path begins.
    match scene.objects().iter().filter(|object| object.shape.moves()).count() {
        0 => Err("no shape moves".to_owned()),
        count => Ok(format!("{count} of {} shapes move", scene.objects().len())),
    }
}

fn eta(scene: &Scene) -> Reason {
    if scene.bsdfs().iter().any(|bsdf| bsdf.flags().transmits) {
        Ok("light passes through surfaces".to_owned())
    } else {
        Err("no light passes through any surface".to_owned())
    }
}
