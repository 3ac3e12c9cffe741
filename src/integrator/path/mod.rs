//! The path tracer: the single-sum path integral, one path a sample.

use super::shading::Shading;
use super::{Estimate, Integrator, Samples, Tracer, Vertex, one_by_one};
use crate::bsdf::Flags;
use crate::emitter::LightSampler;
use crate::math::Rgb;
use crate::math::real::{Lanes, Mask, Real};
use crate::math::vector::Vec3;
use crate::ray::Ray;
use crate::sampler::{PathSampler, PathSamplers};
use crate::scene::Scene;
use crate::shape::Interaction;

mod direct;
mod emission;
pub mod extras;
mod groups;
mod next_event;
mod pool;
pub mod settings;
mod shadows;
mod state;
pub mod strategy;

pub use extras::Extras;
use pool::Pool;
pub use settings::PathSettings;
pub use strategy::Strategy;

/// Next-event estimation and directions chosen by the material, weighted by multiple importance
/// sampling, with Russian roulette (Veach 1997, chapters 8 to 10).
#[derive(Debug)]
pub struct Path {
    settings: PathSettings,
    lights: LightSampler,
    extras: Extras,
}

/// How the last edge of a path was chosen.
#[derive(Clone, Copy, Debug)]
enum LastEdge {
    /// By the camera or by a delta lobe: no shadow ray could have gone the same way.
    Forced,
    /// From a surface of a material with these flags, with density `pdf` for all the directions together that were chosen
    /// there; whether the surface is the first one of the path that is no ideal mirror or glass.
    Chosen { pdf: f32, flags: Flags, is_first: bool },
}

/// What a path carries from one surface to the next.
#[derive(Clone, Copy, Debug)]
struct Carried {
    throughput: Rgb,
    /// Product of the relative indices that the path was refracted by.
    eta: f32,
    edge: LastEdge,
    /// Edges so far; 1 at the first surface.
    edges: u32,
    /// Whether no edge so far is [`LastEdge::Chosen`].
    is_first: bool,
    /// Whether the path has met nothing that it did not pass straight through.
    unscattered: bool,
}

impl Carried {
    /// From the camera to the first surface.
    const BEGUN: Self = Self {
        throughput: Rgb::ONE,
        eta: 1.0,
        edge: LastEdge::Forced,
        edges: 1,
        is_first: true,
        unscattered: true,
    };
}

/// What the paths of some lanes carry from one surface to the next.
#[derive(Debug)]
struct Paths<'s, R: Real> {
    throughput: Vec3<R>,
    eta: R,
    /// Directions that the path takes from the surface.
    directions: R,
    /// Where roulette is not played yet.
    is_young: R::Mask,
    /// Where no edge so far is [`LastEdge::Chosen`].
    is_first: R::Mask,
    numbers: PathSamplers<'s, R>,
    /// Of the new edge, where it is [`LastEdge::Forced`].
    is_forced: R::Mask,
    /// Where the new edge goes straight on.
    is_null: R::Mask,
    /// The density of the new edge: see [`LastEdge`].
    pdf: R,
}

impl<'s, R: Real> Paths<'s, R> {
    #[inline(always)]
    fn new(
        throughput: Vec3<R>,
        eta: R,
        directions: R,
        is_young: R::Mask,
        is_first: R::Mask,
        numbers: PathSamplers<'s, R>,
    ) -> Self {
        let never = R::Mask::splat(eta.token(), false);
        let pdf = R::splat(eta.token(), 0.0);
        Self {
            throughput,
            eta,
            directions,
            is_young,
            is_first,
            numbers,
            is_forced: never,
            is_null: never,
            pdf,
        }
    }
}

impl Path {
    /// A path tracer for `scene`.
    #[must_use]
    pub fn new(settings: &PathSettings, scene: &Scene) -> Self {
        let beside_directions = matches!(settings.strategy, Strategy::Mis(_));
        let lights =
            LightSampler::new(settings.emitter_choice, scene.emitters(), beside_directions);
        Self { settings: *settings, lights, extras: Extras::of(settings, scene) }
    }

    /// The same with paths that carry `extras`: with the same estimates, if nothing is missing that the scene requires.
    #[must_use]
    pub fn carrying(self, extras: Extras) -> Self {
        Self { extras, ..self }
    }

    /// Whether a path with so many edges ends where it is.
    fn is_longest(&self, edges: u32) -> bool {
        self.settings.max_depth.is_some_and(|max| edges >= max)
    }

    /// How many directions together a path takes from a surface.
    #[inline(always)]
    fn directions(&self, edges: u32) -> f32 {
        if edges == 1 { self.settings.bsdf_samples as f32 } else { 1.0 }
    }

    /// How many shadow rays a path sends from a surface of a material.
    fn light_samples(&self, flags: Flags) -> u32 {
        let any = self.settings.strategy != Strategy::Bsdf && flags.smooth;
        if any { self.settings.emitter_samples } else { 0 }
    }

    /// The directions in which paths go on, and which of them do. Where one ends with a throughput that is NaN, this stays.
    #[inline(always)]
    fn scatter<R: Real>(
        &self,
        shading: &Shading<'_, R>,
        paths: &mut Paths<'_, R>,
        wanted: R::Mask,
    ) -> (Vec3<R>, R::Mask) {
        let u = paths.numbers.next_2d(wanted);
        let sample = self.settings.directions.sample(shading, u);
        let (direction, goes_on) = shading.onward(&sample);
        let goes_on = wanted & goes_on;
        let throughput = paths.throughput.times(sample.weight / paths.directions);
        paths.throughput = Vec3::select(goes_on, throughput, paths.throughput);
        paths.eta = R::select(goes_on, paths.eta * sample.eta, paths.eta);
        paths.is_forced = sample.is_delta;
        paths.is_null = sample.is_null;
        paths.pdf = paths.directions * sample.pdf;
        let survival = paths.throughput * (paths.eta * paths.eta);
        let numbers = &mut paths.numbers;
        let (factor, survives) = self
            .settings
            .roulette
            .play(paths.is_young, survival, |plays| numbers.next_1d(plays & goes_on));
        let goes_on = goes_on & survives;
        paths.throughput = Vec3::select(goes_on, paths.throughput * factor, paths.throughput);
        (direction, goes_on)
    }

    /// Follows one of the paths into which the path from the camera splits at `first`, which `ray` met, and adds
    /// what it finds to `estimate`; what arrives at `first` straight from emitters, only if it is the `leading` one.
    fn follow<'a>(
        &self,
        tracer: &mut Tracer<'a>,
        ray: &Ray,
        first: Vertex<'a>,
        leading: bool,
        sampler: &mut PathSampler<'_>,
        estimate: &mut Estimate,
    ) {
        let mut ray = *ray;
        let mut vertex = Some(first);
        let mut path = Carried::BEGUN;
        while let Some(here) = &vertex {
            if self.is_longest(path.edges) {
                break;
            }
            let interaction = Interaction::from(here.surface);
            let shading = Shading::of_vertex(here, &ray);
            let mut paths = Paths::<f32>::new(
                path.throughput.into(),
                path.eta,
                self.directions(path.edges),
                path.edges < self.settings.roulette.min_depth,
                path.is_first,
                PathSamplers::one(sampler),
            );
            if leading || path.edges > 1 {
                let samples = self.light_samples(shading.flags);
                let emitters = tracer.scene().emitters();
                let mut arriving = Rgb::ZERO;
                for _ in 0..samples {
                    let lights =
                        self.next_event(emitters, &interaction, &shading, &mut paths, true);
                    for light in lights.iter().filter(|light| light.exists) {
                        let shadow_ray = light.shadow_rays(&interaction).lane(0);
                        if shadow_ray.is_none_or(|ray| !tracer.occluded(&ray)) {
                            arriving += Rgb::from(light.weight);
                        }
                    }
                }
                if samples > 0 {
                    estimate.radiance += path.throughput * (arriving / samples as f32);
                }
            }
            let (direction, goes_on) = self.scatter(&shading, &mut paths, true);
            sampler.go_to(paths.numbers.dimension);
            if !goes_on {
                spoil_if_nan(estimate, paths.throughput.into());
                break;
            }
            path = Carried {
                throughput: paths.throughput.into(),
                eta: paths.eta,
                edge: if paths.is_forced {
                    LastEdge::Forced
                } else {
                    LastEdge::Chosen {
                        pdf: paths.pdf,
                        flags: shading.flags,
                        is_first: path.is_first,
                    }
                },
                edges: path.edges + 1,
                is_first: path.is_first && paths.is_forced,
                unscattered: path.unscattered && paths.is_null,
            };
            ray = interaction.spawn(direction).lane(0);
            vertex = tracer.closest_vertex(&ray);
            self.arrive(tracer, &ray, vertex.as_ref(), &path, estimate);
        }
    }
}

/// Where a path ends with a throughput that is NaN, this spoils the estimate, so that the sample is counted.
fn spoil_if_nan(estimate: &mut Estimate, throughput: Rgb) {
    if throughput.is_nan() {
        estimate.radiance = throughput;
    }
}

impl Integrator for Path {
    fn estimate(
        &self,
        tracer: &mut Tracer<'_>,
        ray: &Ray,
        sampler: &mut PathSampler<'_>,
    ) -> Estimate {
        let mut ray = *ray;
        let (vertex, mut estimate) = tracer.camera_vertex(&mut ray, self.settings.hide_emitters);
        if let Some(first) = vertex {
            for branch in 0..self.settings.bsdf_samples {
                self.follow(tracer, &ray, first, branch == 0, sampler, &mut estimate);
            }
        }
        estimate
    }

    fn estimates<'a, 's>(
        &self,
        tracer: &mut Tracer<'a>,
        samples: &mut dyn Samples<'s>,
        done: &mut dyn FnMut(Estimate, &mut Tracer<'a>),
    ) {
        if self.settings.splits() {
            one_by_one(self, tracer, samples, done);
        } else {
            Pool::new(self, tracer).run(samples, done);
        }
    }
}
