//! A uniform environment.

use super::{EmitterSamples, Light};
use crate::math::discrete::ONE_MINUS_ULP;
use crate::math::real::{Lanes, Mask, Real};
use crate::math::vector::{Vec2, Vec3};
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

impl Light for Constant {
    #[inline(always)]
    fn sample<R: Real>(&self, _from: Vec3<R::Double>, u: Vec2<R::Double>) -> EmitterSamples<R> {
        let token = u.token();
        let u = u.narrow().map(|u| u.min(ONE_MINUS_ULP));
        let weight = Vec3::splat(token, (self.radiance / warp::UNIFORM_SPHERE_PDF).into());
        let pdf = R::splat(token, warp::UNIFORM_SPHERE_PDF);
        let everywhere = R::Mask::splat(token, true);
        let direction = warp::square_to_uniform_sphere(u);
        EmitterSamples::of_infinity(everywhere, direction, weight, pdf)
    }

    #[inline(always)]
    fn background<R: Real>(&self, direction: Vec3<R>) -> (Vec3<R>, R) {
        let token = direction.token();
        (Vec3::splat(token, self.radiance.into()), R::splat(token, warp::UNIFORM_SPHERE_PDF))
    }

    fn is_uniform(&self) -> bool {
        true
    }

    fn power(&self) -> Option<f64> {
        (self.radiance == Rgb::ZERO).then_some(0.0)
    }
}
