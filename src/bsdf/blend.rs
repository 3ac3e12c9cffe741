//! Mixtures of two materials.

use glam::{Vec2, Vec3A};

use super::{Bsdf, BsdfSample, Flags, Lobe, Place, choose};
use crate::math::Rgb;
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
    fn weights(&self, place: &Place) -> [f32; 2] {
        let second = self.weight.at(place.uv).clamp(0.0, 1.0);
        [1.0 - second, second]
    }

    /// The value and the density of the mixture for what `weights` say.
    fn mixed(&self, place: &Place, weights: [f32; 2], wi: Vec3A, wo: Vec3A) -> (Rgb, f32) {
        let [a, b] = &self.materials;
        let value = a.eval(place, wi, wo) * weights[0] + b.eval(place, wi, wo) * weights[1];
        (value, a.pdf(place, wi, wo) * weights[0] + b.pdf(place, wi, wo) * weights[1])
    }
}

impl Bsdf for Blend {
    fn eval(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> Rgb {
        self.mixed(place, self.weights(place), wi, wo).0
    }

    fn pdf(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> f32 {
        self.mixed(place, self.weights(place), wi, wo).1
    }

    fn sample(&self, place: &Place, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        let weights = self.weights(place);
        let (second, rest) = choose(weights[1], u.x);
        let chosen = usize::from(second);
        let sample = self.materials[chosen].sample(place, wi, Vec2::new(rest, u.y))?;
        if sample.lobe != Lobe::Smooth {
            return Some(BsdfSample { pdf: sample.pdf * weights[chosen], ..sample });
        }
        // Both may send light there.
        let (value, pdf) = self.mixed(place, weights, wi, sample.wo);
        (pdf > 0.0 && pdf.is_finite()).then(|| BsdfSample { weight: value / pdf, pdf, ..sample })
    }

    fn flags(&self) -> Flags {
        self.flags
    }

    fn albedo(&self, place: &Place, wi: Vec3A) -> Rgb {
        let weights = self.weights(place);
        let [a, b] = &self.materials;
        a.albedo(place, wi) * weights[0] + b.albedo(place, wi) * weights[1]
    }

    fn interface(&self) -> Option<f32> {
        self.interface
    }
}
