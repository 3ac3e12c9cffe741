//! Light from one direction.

use glam::{DVec2, DVec3, Vec3A};

use super::{Emitter, EmitterBounds, EmitterSample, LightOrigin, Sight};
use crate::math::Rgb;

/// Parallel rays from infinitely far away; no ray hits where they come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directional {
    /// Unit vector towards the light.
    towards: Vec3A,
    irradiance: Rgb,
}

impl Directional {
    /// Light that travels along `direction` (unit, world), and its irradiance on a surface across, in W·m⁻².
    #[must_use]
    pub fn new(direction: Vec3A, irradiance: Rgb) -> Self {
        Self { towards: -direction, irradiance }
    }
}

impl Emitter for Directional {
    fn sample_toward(&self, _from: DVec3, _u: DVec2) -> Option<EmitterSample> {
        Some(EmitterSample {
            direction: self.towards,
            weight: self.irradiance,
            pdf: 0.0,
            origin: LightOrigin::Infinity,
        })
    }

    fn pdf_toward(&self, _sight: &Sight<'_>) -> f32 {
        0.0
    }

    fn radiance(&self, _sight: &Sight<'_>) -> Rgb {
        Rgb::ZERO
    }

    fn parts(&self) -> Vec<EmitterBounds> {
        Vec::new()
    }

    fn power(&self) -> Option<f64> {
        (self.irradiance == Rgb::ZERO).then_some(0.0)
    }
}
