//! Bump maps and normal maps.

use std::sync::Arc;

use glam::{Vec2, Vec3A};

use super::{Bsdf, BsdfSample, Flags, Needs, Place, shading_normal};
use crate::math::vector::Vec3;
use crate::math::{Frame, Rgb};
use crate::texture::{Texture, Textured};

/// A material whose shading normal is turned by a texture.
#[derive(Debug)]
pub struct Perturbed {
    normals: Normals,
    options: PerturbedOptions,
    material: Box<dyn Bsdf>,
    /// Found once: materials inside materials that share parts would be asked exponentially often.
    flags: Flags,
    /// That of the material.
    interface: Option<f32>,
}

/// Where the normals come from.
#[derive(Clone, Debug)]
pub enum Normals {
    /// From the colour: (n + 1)/2 in the local frame, whose x is the direction of the first texture
    /// coordinate.
    Map(Textured<Rgb>),
    /// From the slope of a height in scene units.
    Bump {
        /// The height.
        height: Arc<dyn Texture>,
        /// Factor for the height.
        scale: f32,
    },
}

/// What is done about normals that no surface could have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PerturbedOptions {
    /// Turn a normal that would be seen from behind half round the shading normal (Schüssler et al. 2017). For
    /// materials with an [`Bsdf::interface`], also bend one that would lose light ([`shading_normal`]).
    pub flip_invalid_normals: bool,
    /// Darken what leaves, but by delta lobes, at angles that the unperturbed surface would nearly hide: Conty Estevez, Lecocq and
    /// Stein, "A Microfacet-Based Shadowing Function to Solve the Bump Terminator Problem" (2019).
    pub use_shadowing_function: bool,
}

impl Perturbed {
    /// `material` with these normals.
    #[must_use]
    pub fn new(normals: Normals, options: PerturbedOptions, material: Box<dyn Bsdf>) -> Self {
        let flags = material.flags().needing(Needs::Tangents);
        let interface = material.interface();
        Self { normals, options, material, flags, interface }
    }

    /// The frame around the turned normal, in coordinates of the local frame.
    fn frame(&self, place: &Place, wi: Vec3A) -> Frame {
        let mut n = match &self.normals {
            Normals::Map(texture) => Vec3A::from(texture.at(place.uv)) * 2.0 - 1.0,
            Normals::Bump { height, scale } => {
                let slope = height.gradient(place.uv.into()) * *scale;
                let flat = |d: Vec3, rise: f32| Vec3A::new(d.x, d.y, rise);
                let n = flat(place.dp_du, slope.x).cross(flat(place.dp_dv, slope.y));
                if n.dot(place.geometric_normal.into()) < 0.0 { -n } else { n }
            }
        };
        if self.options.flip_invalid_normals && wi.z * wi.dot(n) <= 0.0 {
            n = Vec3A::new(-n.x, -n.y, n.z);
        }
        // A black map, or slopes beyond what an f32 can hold, turn nothing.
        let mut n = n.try_normalize().unwrap_or(Vec3A::Z);
        if self.options.flip_invalid_normals && self.interface.is_some() {
            n = shading_normal::bend(n, Vec3A::Z, wi, self.interface);
        }
        Frame::from_normal_and_tangent(n.into(), Vec3A::X.into())
    }

    /// The factor for light that leaves towards `wo` where the normal is `n`.
    fn shadowing(&self, n: Vec3A, wo: Vec3A) -> f32 {
        if !self.options.use_shadowing_function {
            return 1.0;
        }
        // The roughness of a GGX surface whose normals deviate as this one does, and its masking.
        let across = |v: Vec3A| v.truncate().length_squared();
        let alpha2 = (0.125 * across(n) / (n.z * n.z)).min(1.0);
        let z = wo.z.abs();
        2.0 * z / (z + (z * z + alpha2 * across(wo)).sqrt())
    }

    /// A direction in the turned frame, if both frames have it on the same side: the turned surface can send
    /// no light through the other one.
    fn turned(frame: &Frame, w: Vec3A) -> Option<Vec3A> {
        let turned = Vec3A::from(frame.to_local(w.into()));
        (turned.z * w.z > 0.0).then_some(turned)
    }

    /// Both directions in the frame of the turned normal.
    fn both_turned(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> Option<(Frame, Vec3A, Vec3A)> {
        let frame = self.frame(place, wi);
        let (wi, wo) = (Self::turned(&frame, wi)?, Self::turned(&frame, wo)?);
        Some((frame, wi, wo))
    }
}

impl Bsdf for Perturbed {
    fn eval(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> Rgb {
        self.both_turned(place, wi, wo).map_or(Rgb::ZERO, |(frame, turned_wi, turned_wo)| {
            let value = self.material.eval(&place.in_frame(&frame), turned_wi, turned_wo);
            value * self.shadowing(frame.n.into(), wo)
        })
    }

    fn pdf(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> f32 {
        self.both_turned(place, wi, wo).map_or(0.0, |(frame, turned_wi, turned_wo)| {
            self.material.pdf(&place.in_frame(&frame), turned_wi, turned_wo)
        })
    }

    fn sample(&self, place: &Place, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        let frame = self.frame(place, wi);
        let (inner, turned_wi) = (place.in_frame(&frame), Self::turned(&frame, wi)?);
        let sample = self.material.sample(&inner, turned_wi, u)?;
        let wo = Vec3A::from(frame.to_world(sample.wo.into())).try_normalize()?;
        let turned_wo = Self::turned(&frame, wo)?;
        if sample.lobe.is_delta() {
            return Some(BsdfSample { wo, ..sample });
        }
        let weight = sample.weight * self.shadowing(frame.n.into(), wo);
        // Of the rounded direction, as `pdf` will find it.
        let pdf = self.material.pdf(&inner, turned_wi, turned_wo);
        (pdf > 0.0).then_some(BsdfSample { wo, weight, pdf, ..sample })
    }

    fn flags(&self) -> Flags {
        self.flags
    }

    fn albedo(&self, place: &Place, wi: Vec3A) -> Rgb {
        let frame = self.frame(place, wi);
        self.material.albedo(&place.in_frame(&frame), Vec3A::from(frame.to_local(wi.into())))
    }

    fn interface(&self) -> Option<f32> {
        self.interface
    }
}
