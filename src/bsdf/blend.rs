//! Mixtures of two materials.

use super::{Bsdf, Flags, Material, Place, Scattered, choose, is_usable};
use crate::math::real::{Mask, Real};
use crate::math::vector::{Vec2, Vec3};
use crate::texture::Textured;

/// One material to a fraction, another for the rest.
#[derive(Debug)]
pub struct Blend {
    weight: Textured<f32>,
    materials: [Box<dyn Bsdf>; 2],
    /// Found once: materials inside materials that share parts would be asked exponentially often.
    flags: Flags,
    /// Found once, for the same reason.
    interface: Option<f32>,
}

impl Blend {
    /// `weight` is the fraction of the second material, clamped to `[0, 1]`.
    #[must_use]
    pub fn new(weight: impl Into<Textured<f32>>, materials: [Box<dyn Bsdf>; 2]) -> Self {
        let weight = weight.into();
        let [a, b] = &materials;
        let flags = a.flags().union(b.flags()).textured(&weight);
        // Glass is harder to please.
        let [of_a, of_b] = materials.each_ref().map(|material| material.interface());
        let interface = of_a.filter(|&eta| eta != 1.0).or(of_b).or(of_a);
        Self { weight, materials, flags, interface }
    }

    /// The fractions of both.
    #[inline(always)]
    fn weights<R: Real>(&self, place: &Place<R>) -> [R; 2] {
        let second = self.weight.at(place.uv).clamp(0.0, 1.0);
        [second.one_minus(), second]
    }
}

impl Material for Blend {
    #[inline(always)]
    fn evaluate<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, wo: Vec3<R>) -> (Vec3<R>, R) {
        let ([first, second], [a, b]) = (self.weights(place), &self.materials);
        let (a, b) = (a.evaluate(place, wi, wo), b.evaluate(place, wi, wo));
        (a.0 * first + b.0 * second, a.1 * first + b.1 * second)
    }

    #[inline(always)]
    fn sample<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, u: Vec2<R>) -> Scattered<R> {
        let weights = self.weights(place);
        let (is_second, rest) = choose(weights[1], u.x);
        let (u, [a, b]) = (Vec2::new(rest, u.y), &self.materials);
        let sample = is_second.either(
            #[inline(always)]
            || b.scatter(place, wi, u),
            #[inline(always)]
            || a.scatter(place, wi, u),
        );
        let probability = sample.pdf * R::select(is_second, weights[1], weights[0]);
        (sample.is_delta | !sample.exists).either(
            #[inline(always)]
            || Scattered { pdf: probability, ..sample },
            #[inline(always)]
            || {
                // Both may send light there.
                let (value, pdf) = self.evaluate(place, wi, sample.wo);
                let exists = sample.exists & is_usable(pdf);
                Scattered { exists, weight: value / pdf, pdf, ..sample }
            },
        )
    }

    fn flags(&self) -> Flags {
        self.flags
    }

    fn albedo(&self, place: &Place, wi: Vec3) -> Vec3 {
        let [first, second] = self.weights(place);
        let [a, b] = self.materials.each_ref().map(|m| Vec3::from(m.albedo(place, wi.into())));
        a * first + b * second
    }

    fn interface(&self) -> Option<f32> {
        self.interface
    }
}
