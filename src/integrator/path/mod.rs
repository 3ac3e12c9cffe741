//! The path tracer: the single-sum path integral, one path a sample.

use super::tracer::{Shading, sight};
use super::{Estimate, Integrator, Sample, Tracer, Vertex, one_by_one};
use crate::bsdf::Lobe;
use crate::emitter::{EmitterChoice, EmitterSample, Receiver};
use crate::math::Rgb;
use crate::ray::Ray;
use crate::sampler::PathSampler;
use crate::scene::Scene;

mod direct;
mod pool;
pub mod settings;
pub mod strategy;

use pool::Pool;
pub use settings::PathSettings;
pub use strategy::Strategy;

/// Next-event estimation and directions chosen by the material, weighted by multiple importance
/// sampling, with Russian roulette (Veach 1997, chapters 8 to 10).
#[derive(Debug)]
pub struct Path {
    settings: PathSettings,
    emitters: EmitterChoice,
}

/// How the last edge of a path was chosen.
#[derive(Clone, Copy, Debug)]
enum LastEdge {
    /// By the camera or by a delta lobe: no shadow ray could have gone the same way.
    Forced,
    /// From a surface, with density `pdf` for all the directions together that were chosen there; whether the
    /// surface transmits light.
    Chosen { pdf: f32, transmits: bool },
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
        unscattered: true,
    };
}

impl Path {
    /// A path tracer for `scene`.
    #[must_use]
    pub fn new(settings: &PathSettings, scene: &Scene) -> Self {
        let emitters = EmitterChoice::new(settings.emitter_choice, scene.emitters());
        Self { settings: *settings, emitters }
    }

    /// Radiance of the emitter at the end of the last edge, with the weight of having found it by
    /// following the path.
    fn emitted(
        &self,
        tracer: &Tracer<'_>,
        ray: &Ray,
        vertex: Option<&Vertex<'_>>,
        edge: LastEdge,
    ) -> Rgb {
        let Some((index, emitter)) = tracer.emitter_in_sight(vertex) else {
            return Rgb::ZERO;
        };
        let sight = sight(ray.exact_origin(), ray.direction, vertex);
        let (LastEdge::Chosen { pdf, transmits }, Some(start)) = (edge, &ray.start) else {
            return emitter.radiance(&sight);
        };
        let weight = match self.settings.strategy {
            Strategy::Bsdf => 1.0,
            Strategy::Emitter => return Rgb::ZERO,
            Strategy::Mis(heuristic) => {
                let emitters = tracer.scene().emitters();
                let from = Receiver {
                    position: start.point,
                    normal: start.facing_normal(),
                    both_sides: transmits,
                };
                let other = self.emitters.pdf_toward(emitters, index, &from, &sight);
                heuristic.weight(pdf, self.settings.emitter_samples as f32 * other)
            }
        };
        emitter.radiance(&sight) * weight
    }

    /// Whether a path with so many edges ends where it is.
    fn is_longest(&self, edges: u32) -> bool {
        self.settings.max_depth.is_some_and(|max| edges >= max)
    }

    /// How many directions together a path takes from a surface.
    fn directions(&self, edges: u32) -> f32 {
        if edges == 1 { self.settings.bsdf_samples as f32 } else { 1.0 }
    }

    /// How many shadow rays a path sends from a surface.
    fn light_samples(&self, shading: &Shading<'_>) -> u32 {
        let any = self.settings.strategy != Strategy::Bsdf && shading.flags.smooth;
        if any { self.settings.emitter_samples } else { 0 }
    }

    /// One sample of the light that emitters send to `vertex` and that is scattered back along the path, if nothing is
    /// between, and where it comes from. From the vertex, `directions` are chosen by the other technique.
    // Inlined for the same reason as `Tracer::closest_vertex`.
    #[inline(always)]
    fn next_event(
        &self,
        tracer: &Tracer<'_>,
        vertex: &Vertex<'_>,
        shading: &Shading<'_>,
        directions: f32,
        sampler: &mut PathSampler<'_>,
    ) -> Option<(Rgb, EmitterSample)> {
        let u = sampler.next_choice();
        let receiver = shading.receiver(&vertex.surface);
        let emitters = tracer.scene().emitters();
        let light = self.emitters.sample_toward(emitters, &receiver, u)?;
        let wo = shading.to_local(light.direction);
        let scattered = shading.eval(wo, light.direction);
        if scattered == Rgb::ZERO {
            return None;
        }
        let weight = match self.settings.strategy {
            Strategy::Mis(heuristic) if light.pdf > 0.0 => {
                let other = self.settings.directions.pdf(shading, wo);
                heuristic
                    .weight(self.settings.emitter_samples as f32 * light.pdf, directions * other)
            }
            _ => 1.0,
        };
        Some((scattered * light.weight * weight, light))
    }

    /// The next ray of the path, if it goes on. Where it ends with a throughput that is NaN, this spoils the estimate, so
    /// that the sample is counted.
    // Inlined for the same reason as `Tracer::closest_vertex`.
    #[inline(always)]
    fn go_on(
        &self,
        vertex: &Vertex<'_>,
        shading: &Shading<'_>,
        path: &mut Carried,
        sampler: &mut PathSampler<'_>,
        estimate: &mut Estimate,
    ) -> Option<Ray> {
        let next = self.scatter(vertex, shading, path, sampler);
        if next.is_none() && path.throughput.is_nan() {
            estimate.radiance = path.throughput;
        }
        next
    }

    /// Chooses the direction in which the path goes on, and whether it does.
    // Inlined for the same reason as `Tracer::closest_vertex`.
    #[inline(always)]
    fn scatter(
        &self,
        vertex: &Vertex<'_>,
        shading: &Shading<'_>,
        path: &mut Carried,
        sampler: &mut PathSampler<'_>,
    ) -> Option<Ray> {
        let directions = self.directions(path.edges);
        let sample = self.settings.directions.sample(shading, sampler.next_2d())?;
        let direction = shading.onward(&sample)?;
        path.unscattered &= sample.lobe == Lobe::Null;
        path.throughput *= sample.weight / directions;
        path.eta *= sample.eta;
        path.edge = if sample.lobe.is_delta() {
            LastEdge::Forced
        } else {
            LastEdge::Chosen { pdf: directions * sample.pdf, transmits: shading.flags.transmits }
        };
        let Carried { throughput, eta, edges, .. } = *path;
        let survival = throughput * (eta * eta);
        let factor = self.settings.roulette.play(edges, survival, || sampler.next_1d())?;
        path.throughput *= factor;
        path.edges += 1;
        Some(vertex.surface.spawn(direction))
    }

    /// Adds what is seen at the end of the newest edge, `ray`, to what the path has found.
    // Inlined for the same reason as `Tracer::closest_vertex`.
    #[inline(always)]
    fn arrive(
        &self,
        tracer: &Tracer<'_>,
        ray: &Ray,
        vertex: Option<&Vertex<'_>>,
        path: &Carried,
        estimate: &mut Estimate,
    ) {
        if path.unscattered && vertex.is_none() {
            let alpha = if self.settings.hide_emitters { 0.0 } else { tracer.background_alpha() };
            estimate.alpha += (alpha - 1.0) / self.settings.bsdf_samples as f32;
        }
        estimate.radiance += path.throughput * self.emitted(tracer, ray, vertex, path.edge);
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
            let shading = Shading::new(here, &ray);
            if leading || path.edges > 1 {
                let samples = self.light_samples(&shading);
                let directions = self.directions(path.edges);
                let mut arriving = Rgb::ZERO;
                for _ in 0..samples {
                    let found = self.next_event(tracer, here, &shading, directions, sampler);
                    let Some((light, sample)) = found else { continue };
                    let shadow_ray = sample.shadow_ray(&here.surface);
                    if shadow_ray.is_none_or(|ray| !tracer.occluded(&ray)) {
                        arriving += light;
                    }
                }
                if samples > 0 {
                    estimate.radiance += path.throughput * (arriving / samples as f32);
                }
            }
            let next = self.go_on(here, &shading, &mut path, sampler, estimate);
            let Some(next) = next else { break };
            ray = next;
            vertex = tracer.closest_vertex(&ray);
            self.arrive(tracer, &ray, vertex.as_ref(), &path, estimate);
        }
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
        samples: &mut dyn Iterator<Item = Sample<'s>>,
        done: &mut dyn FnMut(Estimate, &mut Tracer<'a>),
    ) {
        if self.settings.bsdf_samples == 1 {
            Pool::new(self, tracer).run(samples, done);
        } else {
            // A path that splits has to keep its first vertex.
            one_by_one(self, tracer, samples, done);
        }
    }
}
