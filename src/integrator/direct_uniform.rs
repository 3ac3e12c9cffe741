//! The lecture's first tracer: direct light by uniform hemisphere sampling.

use super::tracer::Shading;
use super::{Estimate, Integrator, Tracer};
use crate::math::Rgb;
use crate::ray::Ray;
use crate::sampler::PathSampler;
use crate::scene::settings::DirectionSampling;

/// One direction, uniform in the hemisphere around the normal, sees an emitter or does not. Ideal
/// mirrors and glass show one reflection or refraction of emitters, point lights are never found.
#[derive(Debug)]
pub struct DirectUniform {
    hide_emitters: bool,
}

impl DirectUniform {
    /// `hide_emitters` leaves emitters out of the camera's view.
    #[must_use]
    pub fn new(hide_emitters: bool) -> Self {
        Self { hide_emitters }
    }
}

impl Integrator for DirectUniform {
    fn estimate(
        &self,
        tracer: &mut Tracer<'_>,
        ray: &Ray,
        sampler: &mut PathSampler<'_>,
    ) -> Estimate {
        let mut ray = *ray;
        let (vertex, alpha) = tracer.camera_vertex(&mut ray, self.hide_emitters);
        let mut radiance =
            if self.hide_emitters { Rgb::ZERO } else { tracer.emitted(&ray, vertex.as_ref()) };
        if let Some(vertex) = vertex {
            let shading = Shading::new(&vertex, &ray);
            let scattered = shading.scatter(DirectionSampling::UniformHemisphere, sampler);
            if let Some((direction, weight)) = scattered {
                let ray = vertex.surface.spawn(direction);
                let light = tracer.closest_vertex(&ray);
                radiance += weight * tracer.emitted(&ray, light.as_ref());
            }
        }
        Estimate { radiance, alpha }
    }
}
