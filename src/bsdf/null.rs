//! Surfaces that are not there.

use glam::{Vec2, Vec3A};

use super::{Bsdf, BsdfSample, Flags, Lobe, Place};
use crate::math::Rgb;

/// Light passes as if there were no surface. A shadow ray is stopped all the same, so light behind it is
/// found by paths that go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Null;

/// The sample that goes straight on, with this probability.
pub(super) fn pass(wi: Vec3A, probability: f32) -> BsdfSample {
    BsdfSample { wo: -wi, weight: Rgb::ONE, pdf: probability, lobe: Lobe::Null, eta: 1.0 }
}

impl Bsdf for Null {
    fn eval(&self, _place: &Place, _wi: Vec3A, _wo: Vec3A) -> Rgb {
        Rgb::ZERO
    }

    fn pdf(&self, _place: &Place, _wi: Vec3A, _wo: Vec3A) -> f32 {
        0.0
    }

    fn sample(&self, _place: &Place, wi: Vec3A, _u: Vec2) -> Option<BsdfSample> {
        Some(pass(wi, 1.0))
    }

    fn flags(&self) -> Flags {
        Flags::DELTA.transmitting()
    }

    fn albedo(&self, _place: &Place, _wi: Vec3A) -> Rgb {
        Rgb::ONE
    }
}
