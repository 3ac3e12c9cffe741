//! Surfaces that emit.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::{Emitter, EmitterSample, LightOrigin, Sight};
use crate::math::{Discrete, Rgb, luminance};
use crate::shape::Shape;

/// The same radiance in all directions from the front of a shape.
#[derive(Debug)]
pub struct Area {
    shape: Arc<dyn Shape>,
    radiance: Rgb,
    /// Choice of a primitive by area.
    primitives: Discrete,
}

impl Area {
    /// `None` if the shape has no area.
    #[must_use]
    pub fn new(shape: Arc<dyn Shape>, radiance: Rgb) -> Option<Self> {
        let areas: Vec<f64> =
            (0..shape.primitive_count()).map(|i| shape.primitive_area(i)).collect();
        let primitives = Discrete::new(&areas)?;
        Some(Self { shape, radiance, primitives })
    }
}

impl Emitter for Area {
    fn sample_toward(&self, from: Vec3, u: Vec2) -> Option<EmitterSample> {
        let (primitive, rest) = self.primitives.sample(u.x);
        let sample = self.shape.sample_primitive(primitive, from, Vec2::new(rest, u.y))?;
        if sample.point.geometric_normal.dot(sample.direction) >= 0.0 {
            return None;
        }
        let probability = self.primitives.probability(primitive);
        Some(EmitterSample {
            direction: sample.direction,
            weight: self.radiance * (f64::from(sample.inverse_pdf) / probability) as f32,
            pdf: sample.pdf * probability as f32,
            origin: LightOrigin::Surface(sample.point),
        })
    }

    fn pdf_toward(&self, sight: &Sight<'_>) -> f32 {
        sight.surface.map_or(0.0, |(primitive, point)| {
            let pdf = self.shape.primitive_pdf(primitive, sight.from, point);
            pdf * self.primitives.probability(primitive) as f32
        })
    }

    fn radiance(&self, sight: &Sight<'_>) -> Rgb {
        match sight.surface {
            Some((_, point)) if point.geometric_normal.dot(sight.direction) < 0.0 => self.radiance,
            _ => Rgb::ZERO,
        }
    }

    fn power(&self, _scene_radius: f64) -> f64 {
        PI * self.primitives.total() * f64::from(luminance(self.radiance))
    }
}
