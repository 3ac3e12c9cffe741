//! A uniform environment.

use glam::{DVec2, DVec3};

use super::{Emitter, EmitterBounds, EmitterSample, LightOrigin, Sight};
use crate::math::discrete::round_below_one;
use crate::math::{Rgb, warp};

/// The same radiance from every direction outside the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constant {
    radiance: Rgb,
}

impl Constant {
    /// An environment of this radiance.
    #[must_use]
    pub fn new(radiance: Rgb) -> Self {
        Self { radiance }
    }
}

impl Emitter for Constant {
    fn sample_toward(&self, _from: DVec3, u: DVec2) -> Option<EmitterSample> {
        Some(EmitterSample {
            direction: warp::square_to_uniform_sphere(round_below_one(u).into()).into(),
            weight: self.radiance / warp::UNIFORM_SPHERE_PDF,
            pdf: warp::UNIFORM_SPHERE_PDF,
            origin: LightOrigin::Infinity,
        })
    }

    fn pdf_toward(&self, sight: &Sight<'_>) -> f32 {
        if sight.surface.is_none() { warp::UNIFORM_SPHERE_PDF } else { 0.0 }
    }

    fn radiance(&self, sight: &Sight<'_>) -> Rgb {
        if sight.surface.is_none() { self.radiance } else { Rgb::ZERO }
    }

    fn parts(&self) -> Vec<EmitterBounds> {
        Vec::new()
    }

    fn power(&self) -> Option<f64> {
        (self.radiance == Rgb::ZERO).then_some(0.0)
    }
}
