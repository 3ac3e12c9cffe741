//! Light transport: each integrator estimates the radiance that arrives along one ray.

use std::fmt::Debug;

use crate::math::Rgb;
use crate::math::real::Level;
use crate::ray::{Ray, Rays};
use crate::sampler::PathSampler;

pub mod ambient_occlusion;
pub mod aov;
pub mod branching;
pub mod direct_uniform;
pub mod directions;
pub mod knobs;
pub mod mis;
pub mod path;
pub mod plugin;
pub mod roulette;
pub mod settings;
mod shading;
mod tracer;

pub use ambient_occlusion::{AmbientOcclusion, AmbientOcclusionSettings};
pub use aov::{Aov, AovSettings};
pub use branching::{Branching, BranchingSettings};
pub use direct_uniform::DirectUniformSettings;
pub use directions::DirectionSampling;
pub use mis::MisHeuristic;
pub use path::{Path, PathSettings, Strategy};
pub use roulette::{Roulette, RoulettePolicy};
pub use settings::{IntegratorSettings, Settings, build};
pub use tracer::{RayCounts, Tracer, Vertex};

/// The beginning of a path.
#[derive(Debug)]
pub struct Sample<'s> {
    /// From the camera.
    pub ray: Ray,
    /// The numbers of the rest of the path.
    pub sampler: PathSampler<'s>,
}

/// Samples of one sampler, in their order.
pub trait Samples<'s> {
    /// The next one.
    fn next(&mut self) -> Option<Sample<'s>>;

    /// Appends rays and numbers of the next eight, or of as many as there are.
    fn next_eight(&mut self, level: Level, rays: &mut Rays, samplers: &mut Vec<PathSampler<'s>>);
}

impl<'s, I: Iterator<Item = Sample<'s>>> Samples<'s> for I {
    fn next(&mut self) -> Option<Sample<'s>> {
        Iterator::next(self)
    }

    fn next_eight(&mut self, _level: Level, rays: &mut Rays, samplers: &mut Vec<PathSampler<'s>>) {
        for Sample { ray, sampler } in self.take(8) {
            rays.push(&ray);
            samplers.push(sampler);
        }
    }
}

/// Estimates the radiance along a ray.
pub trait Integrator: Debug + Send + Sync {
    /// One unbiased estimate f(x)/p(x) of the radiance that arrives at the origin of `ray` from its
    /// direction: no loop over samples inside.
    fn estimate(
        &self,
        tracer: &mut Tracer<'_>,
        ray: &Ray,
        sampler: &mut PathSampler<'_>,
    ) -> Estimate;

    /// [`Integrator::estimate`] of each of the samples, which are all of one sampler, handed to `done` in their order, with the
    /// tracer.
    fn estimates<'a, 's>(
        &self,
        tracer: &mut Tracer<'a>,
        samples: &mut dyn Samples<'s>,
        done: &mut dyn FnMut(Estimate, &mut Tracer<'a>),
    ) {
        one_by_one(self, tracer, samples, done);
    }
}

/// [`Integrator::estimates`], one sample after the other.
fn one_by_one<'a, 's>(
    integrator: &(impl Integrator + ?Sized),
    tracer: &mut Tracer<'a>,
    samples: &mut dyn Samples<'s>,
    done: &mut dyn FnMut(Estimate, &mut Tracer<'a>),
) {
    while let Some(Sample { ray, mut sampler }) = samples.next() {
        done(integrator.estimate(tracer, &ray, &mut sampler), tracer);
    }
}

/// One estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// Radiance, linear sRGB.
    pub radiance: Rgb,
    /// 1 if the ray met something that is part of the picture, else 0.
    pub alpha: f32,
}

/// The integrator that makes the picture, and the layers beside it.
pub type Parts<'a> = (Option<Box<dyn Integrator>>, Option<Aov<'a>>);
