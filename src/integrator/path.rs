//! The path tracer: the single-sum path integral, one path a sample.

use super::tracer::{Shading, sight};
use super::{Estimate, Integrator, Tracer, Vertex};
use crate::bsdf::Lobe;
use crate::emitter::{EmitterChoice, Receiver};
use crate::math::Rgb;
use crate::ray::Ray;
use crate::sampler::PathSampler;
use crate::scene::Scene;
use crate::scene::settings::{PathSettings, Strategy};

/// Next-event estimation and directions chosen by the material, weighted by multiple importance
/// sampling, with Russian roulette (Veach 1997, chapters 8 to 10).
#[derive(Debug)]
pub struct Path {
    settings: PathSettings,
    emitters: EmitterChoice,
}

/// How the last edge of a path was chosen.
#[derive(Clone, Copy)]
enum LastEdge {
    /// By the camera or by a delta lobe: no shadow ray could have gone the same way.
    Forced,
    /// From a surface, with density `pdf` for all the directions together that were chosen there.
    Chosen { from: Receiver, pdf: f32 },
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
        let LastEdge::Chosen { from, pdf } = edge else {
            return emitter.radiance(&sight(ray.exact_origin(), ray.direction, vertex));
        };
        let sight = sight(from.position, ray.direction, vertex);
        let weight = match self.settings.strategy {
            Strategy::Bsdf => 1.0,
            Strategy::Emitter => return Rgb::ZERO,
            Strategy::Mis(heuristic) => {
                let emitters = tracer.scene().emitters();
                let other = self.emitters.pdf_toward(emitters, index, &from, &sight);
                heuristic.weight(pdf, self.settings.emitter_samples as f32 * other)
            }
        };
        emitter.radiance(&sight) * weight
    }

    /// Light that arrives at `vertex` straight from emitters and is scattered back along the path: the mean of
    /// as many samples as the settings ask for. From the vertex, `directions` are chosen by the other technique.
    // Inlined for the same reason as `Tracer::closest_vertex`.
    #[inline(always)]
    fn next_event(
        &self,
        tracer: &mut Tracer<'_>,
        vertex: &Vertex<'_>,
        shading: &Shading<'_>,
        directions: f32,
        sampler: &mut PathSampler<'_>,
    ) -> Rgb {
        let count = self.settings.emitter_samples;
        let mut sum = Rgb::ZERO;
        for _ in 0..count {
            sum += self.light_sample(tracer, vertex, shading, directions, sampler);
        }
        sum / count as f32
    }

    /// One sample of [`Path::next_event`].
    // Inlined for the same reason as `Tracer::closest_vertex`.
    #[inline(always)]
    fn light_sample(
        &self,
        tracer: &mut Tracer<'_>,
        vertex: &Vertex<'_>,
        shading: &Shading<'_>,
        directions: f32,
        sampler: &mut PathSampler<'_>,
    ) -> Rgb {
        let u = sampler.next_choice();
        let receiver = shading.receiver(&vertex.surface);
        let emitters = tracer.scene().emitters();
        let Some(light) = self.emitters.sample_toward(emitters, &receiver, u) else {
            return Rgb::ZERO;
        };
        let wo = shading.to_local(light.direction);
        let scattered = shading.eval(wo, light.direction);
        if scattered == Rgb::ZERO || !tracer.light_arrives(&vertex.surface, &light) {
            return Rgb::ZERO;
        }
        let weight = match self.settings.strategy {
            Strategy::Mis(heuristic) if light.pdf > 0.0 => {
                let other = self.settings.directions.pdf(shading, wo);
                heuristic
                    .weight(self.settings.emitter_samples as f32 * light.pdf, directions * other)
            }
            _ => 1.0,
        };
        scattered * light.weight * weight
    }

    /// Follows one of the paths into which the path from the camera splits at `first`, which `ray` met, and adds
    /// what it finds to `estimate`; what arrives at `first` straight from emitters, only if it is the `leading` one.
    // Inlined for the same reason as `Tracer::closest_vertex`.
    #[inline(always)]
    fn follow<'a>(
        &self,
        tracer: &mut Tracer<'a>,
        ray: &Ray,
        first: Vertex<'a>,
        leading: bool,
        sampler: &mut PathSampler<'_>,
        estimate: &mut Estimate,
    ) {
        let s = &self.settings;
        let mut ray = *ray;
        let mut vertex = Some(first);
        let mut throughput = Rgb::ONE;
        // Product of the relative indices that the path was refracted by.
        let mut eta = 1.0;
        // Whether the path has met nothing that it did not pass straight through.
        let mut unscattered = true;

        for edges in 1.. {
            let Some(here) = &vertex else { break };
            if s.max_depth.is_some_and(|max| edges >= max) {
                break;
            }
            let shading = Shading::new(here, &ray);
            let directions = if edges == 1 { s.bsdf_samples as f32 } else { 1.0 };

            // One more edge straight to an emitter.
            if s.strategy != Strategy::Bsdf && shading.flags.smooth && (leading || edges > 1) {
                let arriving = self.next_event(tracer, here, &shading, directions, sampler);
                estimate.radiance += throughput * arriving;
            }

            // The direction in which the path goes on.
            let u = sampler.next_2d();
            let Some(sample) = s.directions.sample(&shading, u) else {
                break;
            };
            let Some(direction) = shading.onward(&sample) else { break };
            unscattered &= sample.lobe == Lobe::Null;
            throughput *= sample.weight / directions;
            eta *= sample.eta;
            let edge = if sample.lobe.is_delta() {
                LastEdge::Forced
            } else {
                let from = shading.receiver(&here.surface);
                LastEdge::Chosen { from, pdf: directions * sample.pdf }
            };
            ray = here.surface.spawn(direction);

            // Whether it goes on.
            let Some(factor) =
                s.roulette.play(edges, throughput * (eta * eta), || sampler.next_1d())
            else {
                // What is no number spoils the sample, so that it is counted.
                if throughput.is_nan() {
                    estimate.radiance = throughput;
                }
                break;
            };
            throughput *= factor;
            vertex = tracer.closest_vertex(&ray);
            if unscattered && vertex.is_none() {
                let alpha = if s.hide_emitters { 0.0 } else { tracer.background_alpha() };
                estimate.alpha += (alpha - 1.0) / s.bsdf_samples as f32;
            }

            // Light that is seen at the end of the new edge.
            estimate.radiance += throughput * self.emitted(tracer, &ray, vertex.as_ref(), edge);
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
}
