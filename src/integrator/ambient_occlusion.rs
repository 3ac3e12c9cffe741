//! Ambient occlusion.

use super::{Estimate, Integrator, Tracer};
use crate::math::{Frame, Rgb, warp};
use crate::ray::Ray;
use crate::sampler::PathSampler;

/// The cosine-weighted fraction of the hemisphere that is free of surfaces up to a given distance; the
/// materials do not matter.
#[derive(Debug)]
pub struct AmbientOcclusion {
    ray_length: f32,
}

impl AmbientOcclusion {
    /// `ray_length` in scene units, > 0, may be infinite.
    #[must_use]
    pub fn new(ray_length: f32) -> Self {
        Self { ray_length }
    }
}

impl Integrator for AmbientOcclusion {
    fn estimate(
        &self,
        tracer: &mut Tracer<'_>,
        ray: &Ray,
        sampler: &mut PathSampler<'_>,
    ) -> Estimate {
        let Some(vertex) = tracer.closest_vertex(ray) else {
            return Estimate::default();
        };
        let normal = vertex.surface.geometric_normal;
        // The side that is seen.
        let frame = Frame::from_normal((normal * -normal.dot(ray.direction).signum()).into());
        let direction = warp::square_to_cosine_hemisphere(sampler.next_2d().into());
        let direction = frame.to_world(direction).into();
        let free = !tracer.occluded(&vertex.surface.spawn(direction).until(self.ray_length));
        Estimate { radiance: Rgb::splat(f32::from(u8::from(free))), alpha: 1.0 }
    }
}
