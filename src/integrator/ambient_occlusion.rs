//! Ambient occlusion.

use super::plugin::Plugin;
use super::{Estimate, Integrator, Parts, Settings, Tracer};
use crate::math::{Frame, Rgb, warp};
use crate::property::{self, Bounds, Given, Kind, Nothing, PropertyInfo, property};
use crate::ray::Ray;
use crate::sampler::PathSampler;
use crate::scene::Scene;

/// All that it can be told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientOcclusionSettings {
    /// How far an occluder counts, in scene units; may be infinite.
    pub ray_length: f32,
}

const RAY_LENGTH: PropertyInfo = property(
    "ray_length",
    Kind::Float(Bounds::Positive),
    property::Default::Absent("infinity"),
    "how far an occluder counts, in scene units",
);

static AO: Plugin = Plugin {
    name: "ao",
    help: "Ambient occlusion: the fraction of the cosine-weighted hemisphere that is free.",
    properties: &[RAY_LENGTH],
    contains: false,
    read: |told| Ok(AmbientOcclusionSettings::read(told).into()),
    in_place_of: None,
};

impl AmbientOcclusionSettings {
    fn read(told: &dyn Given) -> Self {
        let ray_length = told.number(&RAY_LENGTH).map_or(f32::INFINITY, |v| v as f32);
        Self { ray_length }
    }
}

impl Default for AmbientOcclusionSettings {
    fn default() -> Self {
        Self::read(&Nothing)
    }
}

impl Settings for AmbientOcclusionSettings {
    fn plugins() -> &'static [Plugin] {
        std::slice::from_ref(&AO)
    }

    fn build<'a>(&'a self, _: &Scene) -> Parts<'a> {
        (Some(Box::new(AmbientOcclusion::new(self.ray_length))), None)
    }

    fn describe(&self) -> String {
        format!("ambient occlusion within {}", self.ray_length)
    }

    fn shows_light(&self) -> bool {
        false
    }
}

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
