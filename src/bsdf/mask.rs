//! Surfaces with holes.

use super::null::pass;
use super::{Bsdf, Flags, Material, Place, Scattered, choose};
use crate::math::real::{Lanes, Mask as _, Real};
use crate::math::vector::{Vec2, Vec3};
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

    #[inline(always)]
    fn opacity<R: Real>(&self, place: &Place<R>) -> R {
        self.opacity.at(place.uv).clamp(0.0, 1.0)
    }
}

impl Material for Mask {
    #[inline(always)]
    fn evaluate<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, wo: Vec3<R>) -> (Vec3<R>, R) {
        let opacity = self.opacity(place);
        let (value, pdf) = self.material.evaluate(place, wi, wo);
        (value * opacity, pdf * opacity)
    }

    #[inline(always)]
    fn sample<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, u: Vec2<R>) -> Scattered<R> {
        let opacity = self.opacity(place);
        let (opaque, rest) = choose(opacity, u.x);
        let one = R::splat(wi.token(), 1.0);
        opaque.either(
            #[inline(always)]
            || {
                let sample = self.material.scatter(place, wi, Vec2::new(rest, u.y));
                Scattered { pdf: sample.pdf * opacity, ..sample }
            },
            #[inline(always)]
            || pass(wi, Vec3::new(one, one, one), opacity.one_minus()),
        )
    }

    fn flags(&self) -> Flags {
        self.flags
    }

    fn albedo(&self, place: &Place, wi: Vec3) -> Vec3 {
        let opacity = self.opacity(place);
        Vec3::from(self.material.albedo(place, wi.into())).map(|a| a * opacity + (1.0 - opacity))
    }

    fn interface(&self) -> Option<f32> {
        self.material.interface()
    }
}
