//! Light from one direction.

use glam::Vec3A;

use super::{EmitterSamples, Light};
use crate::math::Rgb;
use crate::math::real::{Lanes, Mask, Real};
use crate::math::vector::{Vec2, Vec3};

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

impl Light for Directional {
    #[inline(always)]
    fn sample<R: Real>(&self, _from: Vec3<R::Double>, u: Vec2<R::Double>) -> EmitterSamples<R> {
        let token = u.token();
        let vector = |v: Vec3A| Vec3::splat(token, v.into());
        let (everywhere, pdf) = (R::Mask::splat(token, true), R::splat(token, 0.0));
        let (direction, weight) = (vector(self.towards), vector(self.irradiance));
        EmitterSamples::of_infinity(everywhere, direction, weight, pdf)
    }

    fn power(&self) -> Option<f64> {
        (self.irradiance == Rgb::ZERO).then_some(0.0)
    }
}
