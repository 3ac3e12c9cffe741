//! Surfaces with holes.

use glam::{Vec2, Vec3A};

use super::null::pass;
use super::{Bsdf, BsdfSample, Flags, Place, choose};
use crate::math::Rgb;
use crate::texture::Textured;

/// A material that is there to a fraction; the rest of the light goes straight on.
#[derive(Debug)]
pub struct Mask {
    opacity: Textured<f32>,
    material: Box<dyn Bsdf>,
    /// Found once: materials inside materials that share parts would be asked exponentially often.
    flags: Flags,
}

impl Mask {
    /// `opacity` is the fraction of `material`, clamped to `[0, 1]`.
    #[must_use]
    pub fn new(opacity: impl Into<Textured<f32>>, material: Box<dyn Bsdf>) -> Self {
        let opacity = opacity.into();
        let flags = material.flags().union(Flags::DELTA.transmitting()).textured(&opacity);
        Self { opacity, material, flags }
    }

    fn opacity(&self, place: &Place) -> f32 {
        self.opacity.at(place.uv).clamp(0.0, 1.0)
    }
}

impl Bsdf for Mask {
    fn eval(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> Rgb {
        self.material.eval(place, wi, wo) * self.opacity(place)
    }

    fn pdf(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> f32 {
        self.material.pdf(place, wi, wo) * self.opacity(place)
    }

    fn sample(&self, place: &Place, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        let opacity = self.opacity(place);
        let (opaque, rest) = choose(opacity, u.x);
        if !opaque {
            return Some(pass(wi, 1.0 - opacity));
        }
        let sample = self.material.sample(place, wi, Vec2::new(rest, u.y))?;
        Some(BsdfSample { pdf: sample.pdf * opacity, ..sample })
    }

    fn flags(&self) -> Flags {
        self.flags
    }

    fn albedo(&self, place: &Place, wi: Vec3A) -> Rgb {
        let opacity = self.opacity(place);
        self.material.albedo(place, wi) * opacity + Rgb::splat(1.0 - opacity)
    }

    fn interface(&self) -> Option<f32> {
        self.material.interface()
    }
}
