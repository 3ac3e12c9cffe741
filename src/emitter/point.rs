//! Point lights.

use std::f64::consts::PI;

use glam::Vec3A;

use super::{EmitterBounds, EmitterSamples, Light};
use crate::math::real::{Lanes, Real};
use crate::math::vector::{Vec2, Vec3};
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

impl Light for Point {
    #[inline(always)]
    fn sample<R: Real>(&self, from: Vec3<R::Double>, _u: Vec2<R::Double>) -> EmitterSamples<R> {
        let token = from.token();
        let intensity = Vec3::splat(token, self.intensity.into());
        EmitterSamples::of_intensity(self.position, intensity, from)
    }

    fn parts(&self) -> Vec<EmitterBounds> {
        let intensity = luminance(self.intensity).into();
        vec![EmitterBounds::point(self.position, Cone::ALL, 0.0, intensity)]
    }

    fn power(&self) -> Option<f64> {
        Some(4.0 * PI * f64::from(luminance(self.intensity)))
    }
}
