//! Point lights.

use std::f64::consts::PI;

use glam::{DVec2, DVec3, Vec3A};

use super::{Emitter, EmitterBounds, EmitterSample, LightOrigin, Sight};
use crate::math::{Cone, Rgb, luminance};

/// The same radiant intensity in all directions from a point; no ray hits it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    position: Vec3A,
    intensity: Rgb,
}

impl Point {
    /// `intensity` in W·sr⁻¹.
    #[must_use]
    pub fn new(position: Vec3A, intensity: Rgb) -> Self {
        Self { position, intensity }
    }
}

impl Emitter for Point {
    fn sample_toward(&self, from: DVec3, _u: DVec2) -> Option<EmitterSample> {
        let to = self.position.as_dvec3() - from;
        let distance_squared = to.length_squared();
        let weight = (self.intensity.as_dvec3() / distance_squared).as_vec3a();
        // At the light itself the direction is undefined.
        (distance_squared > 0.0 && weight.is_finite()).then(|| EmitterSample {
            direction: (to / distance_squared.sqrt()).as_vec3a(),
            weight,
            pdf: 0.0,
            origin: LightOrigin::Point(self.position),
        })
    }

    fn pdf_toward(&self, _sight: &Sight<'_>) -> f32 {
        0.0
    }

    fn radiance(&self, _sight: &Sight<'_>) -> Rgb {
        Rgb::ZERO
    }

    fn parts(&self) -> Vec<EmitterBounds> {
        let intensity = luminance(self.intensity).into();
        vec![EmitterBounds::point(self.position, Cone::ALL, 0.0, intensity)]
    }

    fn power(&self) -> Option<f64> {
        Some(4.0 * PI * f64::from(luminance(self.intensity)))
    }
}
