//! The lecture's recursive estimator, kept to show what it costs. With one branch, one bounce and uniform
//! directions it is the lecture's first tracer: direct light by uniform hemisphere sampling.

use super::tracer::{Shading, Vertex};
use super::{DirectionSampling, Estimate, Integrator, Tracer};
use crate::math::Rgb;
use crate::ray::Ray;
use crate::sampler::PathSampler;

/// N rays at each vertex, each of which branches again: N^depth rays for one estimate. Emitters are
/// found by directions alone.
#[derive(Debug)]
pub struct Branching {
    branches: u32,
    max_depth: u32,
    directions: DirectionSampling,
    hide_emitters: bool,
}

impl Branching {
    /// `branches` rays at each vertex, of which paths of up to `max_depth` edges come.
    #[must_use]
    pub fn new(
        branches: u32,
        max_depth: u32,
        directions: DirectionSampling,
        hide_emitters: bool,
    ) -> Self {
        Self { branches, max_depth, directions, hide_emitters }
    }

    /// Mean over N directions of what arrives at `vertex` and is scattered back along `ray`, which was
    /// edge number `edges` of its path.
    fn scattered(
        &self,
        tracer: &mut Tracer<'_>,
        ray: &Ray,
        vertex: &Vertex<'_>,
        edges: u32,
        sampler: &mut PathSampler<'_>,
    ) -> Rgb {
        if edges >= self.max_depth {
            return Rgb::ZERO;
        }
        let shading = Shading::new(vertex, ray);
        let mut sum = Rgb::ZERO;
        for _ in 0..self.branches {
            let Some((direction, weight)) = shading.scatter(self.directions, sampler) else {
                continue;
            };
            let ray = vertex.surface.spawn(direction);
            let next = tracer.closest_vertex(&ray);
            let mut arriving = tracer.emitted(&ray, next.as_ref());
            if let Some(next) = next {
                arriving += self.scattered(tracer, &ray, &next, edges + 1, sampler);
            }
            sum += weight * arriving;
        }
        sum / self.branches as f32
    }
}

impl Integrator for Branching {
    fn estimate(
        &self,
        tracer: &mut Tracer<'_>,
        ray: &Ray,
        sampler: &mut PathSampler<'_>,
    ) -> Estimate {
        let mut ray = *ray;
        let (vertex, mut estimate) = tracer.camera_vertex(&mut ray, self.hide_emitters);
        if let Some(vertex) = vertex {
            estimate.radiance += self.scattered(tracer, &ray, &vertex, 1, sampler);
        }
        estimate
    }
}
