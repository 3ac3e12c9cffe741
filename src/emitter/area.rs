//! Surfaces that emit.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec2, Vec3A};

use super::{Emitter, EmitterSample, LightOrigin, Sight};
use crate::math::discrete::round_below_one;
use crate::math::{Choice, Discrete, Rgb, luminance};
use crate::shape::{Shape, SurfacePoint};

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
    fn sample_toward(&self, from: Vec3A, u: DVec2) -> Option<EmitterSample> {
        let Choice { index, probability, rest } = self.primitives.sample(u.x);
        let on_primitive = round_below_one(DVec2::new(rest, u.y));
        let sample = self.shape.sample_primitive(index, from, on_primitive)?;
        if !is_front(&sample.point, sample.direction) {
            return None;
        }
        let pdf = sample.pdf * probability;
        let weight = if (1e-30..1e30).contains(&pdf) {
            self.radiance * (1.0 / pdf as f32)
        } else {
            // The inverse may be too small for an f32, and its product with the radiance not.
            (self.radiance.as_dvec3() / pdf).as_vec3a()
        };
        Some(EmitterSample {
            direction: sample.direction,
            weight,
            pdf: narrow(pdf),
            origin: LightOrigin::Point {
                end: sample.point.leave_towards(-sample.direction),
                error: sample.point.offset,
            },
        })
    }

    fn pdf_toward(&self, sight: &Sight<'_>) -> f32 {
        match sight.surface {
            Some((primitive, point)) if is_front(point, sight.direction) => {
                let pdf = self.shape.primitive_pdf(primitive, sight.from, point);
                narrow(pdf * self.primitives.probability(primitive))
            }
            _ => 0.0,
        }
    }

    fn radiance(&self, sight: &Sight<'_>) -> Rgb {
        match sight.surface {
            Some((_, point)) if is_front(point, sight.direction) => self.radiance,
            _ => Rgb::ZERO,
        }
    }

    fn power(&self) -> Option<f64> {
        Some(PI * self.primitives.total() * f64::from(luminance(self.radiance)))
    }
}

/// Whether `direction` arrives at the side that emits.
fn is_front(point: &SurfacePoint, direction: Vec3A) -> bool {
    point.geometric_normal.dot(direction) < 0.0
}

/// The density as an f32: a finite one even where a light of a solid angle below 1e-38 has a greater.
fn narrow(pdf: f64) -> f32 {
    pdf.min(f64::from(f32::MAX)) as f32
}
