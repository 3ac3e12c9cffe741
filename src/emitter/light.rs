//! A light that is no surface, over any number of lanes, and how it becomes an [`Emitter`].

use std::fmt::Debug;

use glam::{DVec2, DVec3};

use super::rows::{BackgroundRows, EmitterSampleRows, SampleRows, SightRows};
use super::{Emitter, EmitterBounds, EmitterSample, EmitterSamples, Sight};
use crate::math::Rgb;
use crate::math::real::{Lanes, Level, Real, Simd, Task, f32x8, f64x8};
use crate::math::vector::{Vec2, Vec3};

/// An [`Emitter`] that no ray hits and that is written once for one ray and for eight.
///
/// All is as [`Emitter`] says, in each lane. What follows from it is done here: a type that implements this is an
/// [`Emitter`].
pub trait Light: Debug + Send + Sync {
    /// See [`Emitter::sample_toward`].
    fn sample<R: Real>(&self, from: Vec3<R::Double>, u: Vec2<R::Double>) -> EmitterSamples<R>;

    /// Of an environment the radiance that is seen in a direction outside of the scene, and the density with which
    /// [`Light::sample`] chooses that; 0 of others.
    #[inline(always)]
    fn background<R: Real>(&self, direction: Vec3<R>) -> (Vec3<R>, R) {
        let token = direction.token();
        (Vec3::splat(token, Vec3::default()), R::splat(token, 0.0))
    }

    /// See [`Emitter::power`].
    fn power(&self) -> Option<f64>;

    /// See [`Emitter::is_uniform`].
    fn is_uniform(&self) -> bool {
        false
    }

    /// See [`Emitter::parts`]. Unless said otherwise, those of an emitter outside of the scene: none.
    fn parts(&self) -> Vec<EmitterBounds> {
        Vec::new()
    }
}

impl<T: Light> Emitter for T {
    fn sample_toward(&self, from: DVec3, u: DVec2) -> Option<EmitterSample> {
        self.sample::<f32>(from.into(), u.into()).lane(0)
    }

    fn pdf_toward(&self, sight: &Sight<'_>) -> f32 {
        match sight.surface {
            None => self.background::<f32>(sight.direction.into()).1,
            Some(_) => 0.0,
        }
    }

    fn radiance(&self, sight: &Sight<'_>) -> Rgb {
        match sight.surface {
            None => self.background::<f32>(sight.direction.into()).0.into(),
            Some(_) => Rgb::ZERO,
        }
    }

    fn power(&self) -> Option<f64> {
        Light::power(self)
    }

    fn is_uniform(&self) -> bool {
        Light::is_uniform(self)
    }

    fn parts(&self) -> Vec<EmitterBounds> {
        Light::parts(self)
    }

    fn sample_eight(&self, level: Level, asked: &SampleRows, samples: &mut EmitterSampleRows) {
        level.run(Sample { light: self, asked, samples });
    }

    fn background_eight(&self, level: Level, sights: &SightRows, seen: &mut BackgroundRows) {
        level.run(Background { light: self, sights, seen });
    }
}

struct Sample<'a, T> {
    light: &'a T,
    asked: &'a SampleRows,
    samples: &'a mut EmitterSampleRows,
}

impl<T: Light> Task for Sample<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { light, asked, samples } = self;
        let from = asked.from.load::<f64x8<S>>(simd).into();
        let u = asked.u.load::<f64x8<S>>(simd).into();
        samples.store(&light.sample::<f32x8<S>>(from, u));
    }
}

struct Background<'a, T> {
    light: &'a T,
    sights: &'a SightRows,
    seen: &'a mut BackgroundRows,
}

impl<T: Light> Task for Background<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { light, sights, seen } = self;
        let direction = sights.direction.load::<f32x8<S>>(simd).into();
        let (radiance, pdf) = light.background::<f32x8<S>>(direction);
        seen.store([radiance.x, radiance.y, radiance.z, pdf]);
    }
}
