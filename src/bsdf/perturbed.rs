//! Bump maps and normal maps.

use std::sync::Arc;

use super::{Bsdf, Flags, Material, Needs, Place, Scattered, shading_normal};
use crate::math::real::{Lanes, Mask, Real};
use crate::math::vector::{Vec2, Vec3};
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
    #[inline(always)]
    fn frame<R: Real>(&self, place: &Place<R>, wi: Vec3<R>) -> Frame<R> {
        let (zero, one) = (R::splat(wi.token(), 0.0), R::splat(wi.token(), 1.0));
        let (x, z) = (Vec3::new(one, zero, zero), Vec3::new(zero, zero, one));
        let mut n = match &self.normals {
            Normals::Map(texture) => texture.at(place.uv).map(|color| color * 2.0 - 1.0),
            Normals::Bump { height, scale } => {
                let slope = height.slope(place.uv) * *scale;
                let flat = |d: Vec3<R>, rise: R| d.truncate().extend(rise);
                let n = flat(place.dp_du, slope.x).cross(flat(place.dp_dv, slope.y));
                Vec3::select(n.dot(place.geometric_normal).lt(0.0), -n, n)
            }
        };
        if self.options.flip_invalid_normals {
            let from_behind = (wi.z * wi.dot(n)).le(0.0);
            n = Vec3::select(from_behind, Vec3::new(-n.x, -n.y, n.z), n);
        }
        // A black map, or slopes beyond what an f32 can hold, turn nothing.
        let (unit, exists) = n.try_normalize();
        let mut n = Vec3::select(exists, unit, z);
        if self.options.flip_invalid_normals && self.interface.is_some() {
            n = shading_normal::bend(n, z, wi, self.interface);
        }
        Frame::from_normal_and_tangent(n, x)
    }

    /// The factor for light that leaves towards `wo` where the normal is `n`.
    #[inline(always)]
    fn shadowing<R: Real>(&self, n: Vec3<R>, wo: Vec3<R>) -> R {
        if !self.options.use_shadowing_function {
            return R::splat(wo.token(), 1.0);
        }
        // The roughness of a GGX surface whose normals deviate as this one does, and its masking.
        let across = |v: Vec3<R>| v.truncate().length_squared();
        let alpha2 = (across(n) * 0.125 / (n.z * n.z)).min(1.0);
        let z = wo.z.abs();
        z * 2.0 / (z + (z * z + alpha2 * across(wo)).sqrt())
    }
}

/// A direction in the turned frame, and whether both frames have it on the same side: the turned surface can send
/// no light through the other one.
#[inline(always)]
fn turned<R: Real>(frame: &Frame<R>, w: Vec3<R>) -> (Vec3<R>, R::Mask) {
    let turned = frame.to_local(w);
    (turned, (turned.z * w.z).gt(0.0))
}

impl Material for Perturbed {
    #[inline(always)]
    fn evaluate<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, wo: Vec3<R>) -> (Vec3<R>, R) {
        let frame = self.frame(place, wi);
        let ((turned_wi, sees), (turned_wo, leaves)) = (turned(&frame, wi), turned(&frame, wo));
        let inner = place.in_frame(&frame);
        let (value, pdf) = self.material.evaluate(&inner, turned_wi, turned_wo);
        let value = value * self.shadowing(frame.n, wo);
        (value.only_where(sees & leaves), R::select(sees & leaves, pdf, 0.0))
    }

    #[inline(always)]
    fn sample<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, u: Vec2<R>) -> Scattered<R> {
        let frame = self.frame(place, wi);
        let (inner, (turned_wi, sees)) = (place.in_frame(&frame), turned(&frame, wi));
        let sample = self.material.scatter(&inner, turned_wi, u);
        let (wo, has_direction) = frame.to_world(sample.wo).try_normalize();
        let (turned_wo, leaves) = turned(&frame, wo);
        let exists = sample.exists & has_direction & sees & leaves;
        let sample = Scattered { exists, wo, ..sample };
        (sample.is_delta | !exists).either(
            #[inline(always)]
            || sample,
            #[inline(always)]
            || {
                let weight = sample.weight * self.shadowing(frame.n, wo);
                // Of the rounded direction, as `evaluate` will find it.
                let (_, pdf) = self.material.evaluate(&inner, turned_wi, turned_wo);
                Scattered { exists: exists & pdf.gt(0.0), weight, pdf, ..sample }
            },
        )
    }

    fn flags(&self) -> Flags {
        self.flags
    }

    fn albedo(&self, place: &Place, wi: Vec3) -> Vec3 {
        let frame = self.frame(place, wi);
        self.material.albedo(&place.in_frame(&frame), frame.to_local(wi).into()).into()
    }

    fn interface(&self) -> Option<f32> {
        self.interface
    }
}
