//! The path tracer: the single-sum path integral, one path a sample.

use glam::Vec3;

use super::tracer::{Shading, sight};
use super::{Estimate, Integrator, Tracer, Vertex};
use crate::emitter::EmitterChoice;
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
    /// From a surface at `from`, with density `pdf`.
    Chosen { from: Vec3, pdf: f32 },
}

impl Path {
    /// A path tracer for `scene`.
    #[must_use]
    pub fn new(settings: &PathSettings, scene: &Scene) -> Self {
        let emitters =
            EmitterChoice::new(settings.emitter_choice, scene.emitters(), scene.radius());
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
            return emitter.radiance(&sight(ray.origin, ray.direction, vertex));
        };
        let sight = sight(from, ray.direction, vertex);
        let weight = match self.settings.strategy {
            Strategy::Bsdf => 1.0,
            Strategy::Emitter => return Rgb::ZERO,
            Strategy::Mis(heuristic) => {
                let other = self.emitters.probability(index) * emitter.pdf_toward(&sight);
                heuristic.weight(pdf, other)
            }
        };
        emitter.radiance(&sight) * weight
    }

    /// Light that arrives at `vertex` straight from one emitter and is scattered back along the path.
    fn next_event(
        &self,
        tracer: &mut Tracer<'_>,
        vertex: &Vertex<'_>,
        shading: &Shading<'_>,
        sampler: &mut PathSampler<'_>,
    ) -> Rgb {
        let u = sampler.next_2d();
        let Some((index, probability, rest)) = self.emitters.sample(u.x) else {
            return Rgb::ZERO;
        };
        let emitter = &tracer.scene().emitters()[index];
        let u = glam::Vec2::new(rest, u.y);
        let Some(light) = emitter.sample_toward(vertex.surface.position, u) else {
            return Rgb::ZERO;
        };
        let wo = shading.to_local(light.direction);
        let scattered = shading.eval(wo, light.direction);
        if scattered == Rgb::ZERO || !tracer.light_arrives(&vertex.surface, &light) {
            return Rgb::ZERO;
        }
        let weight = match self.settings.strategy {
            Strategy::Mis(heuristic) if light.pdf > 0.0 => {
                let other = self.settings.directions.pdf(shading.bsdf(), shading.wi, wo);
                heuristic.weight(probability * light.pdf, other)
            }
            _ => 1.0,
        };
        scattered * light.weight * (weight / probability)
    }
}

/// A path on its way: its last edge, and what it carries along it.
struct Walk<'a> {
    ray: Ray,
    edge: LastEdge,
    /// Edges so far.
    edges: u32,
    throughput: Rgb,
    /// Product of the relative indices that the path was refracted by.
    eta: f32,
    /// What the last edge met.
    vertex: Option<Vertex<'a>>,
}

impl Path {
    /// The path with one more edge, unless it is absorbed or ends by chance.
    fn extend<'a>(
        &self,
        tracer: &mut Tracer<'a>,
        walk: &Walk<'a>,
        vertex: &Vertex<'a>,
        shading: &Shading<'a>,
        sampler: &mut PathSampler<'_>,
    ) -> Option<Walk<'a>> {
        let s = &self.settings;
        let sample = s.directions.sample(shading.bsdf(), shading.wi, sampler.next_2d())?;
        let direction = shading.to_world(sample.wo);
        if !shading.sides_agree(sample.wo, direction) {
            return None;
        }
        let throughput = walk.throughput * sample.weight;
        let eta = walk.eta * sample.eta;
        let factor = s.roulette.play(walk.edges, throughput * (eta * eta), || sampler.next_1d())?;
        let edge = if sample.delta {
            LastEdge::Forced
        } else {
            LastEdge::Chosen { from: vertex.surface.position, pdf: sample.pdf }
        };
        let ray = vertex.surface.spawn(direction);
        let edges = walk.edges + 1;
        let vertex = tracer.closest_vertex(&ray);
        Some(Walk { ray, edge, edges, throughput: throughput * factor, eta, vertex })
    }
}

impl Integrator for Path {
    fn estimate(
        &self,
        tracer: &mut Tracer<'_>,
        ray: &Ray,
        sampler: &mut PathSampler<'_>,
    ) -> Estimate {
        let s = &self.settings;
        let mut ray = *ray;
        let (vertex, alpha) = tracer.camera_vertex(&mut ray, s.hide_emitters);
        let (edge, throughput) = (LastEdge::Forced, Rgb::ONE);
        let mut walk = Walk { ray, edge, edges: 1, throughput, eta: 1.0, vertex };
        let mut radiance = Rgb::ZERO;
        loop {
            // Light that is seen at the end of the last edge.
            if walk.edges > 1 || !s.hide_emitters {
                let emitted = self.emitted(tracer, &walk.ray, walk.vertex.as_ref(), walk.edge);
                radiance += walk.throughput * emitted;
            }
            let Some(vertex) = walk.vertex else { break };
            if s.max_depth.is_some_and(|max| walk.edges >= max) {
                break;
            }
            let shading = Shading::new(&vertex, &walk.ray);

            // The edge on which the path goes on. It is traced before the shadow ray, so that its surface
            // comes from memory while that one is under way.
            let next = self.extend(tracer, &walk, &vertex, &shading, sampler);

            // Another edge straight to an emitter.
            if s.strategy != Strategy::Bsdf && !vertex.bsdf.is_delta() {
                radiance += walk.throughput * self.next_event(tracer, &vertex, &shading, sampler);
            }
            match next {
                Some(next) => walk = next,
                None => break,
            }
        }
        Estimate { radiance, alpha }
    }
}
