//! Window panes.

use super::dielectric::Factors;
use super::null::pass;
use super::{Flags, Material, Place, Scattered, choose, fresnel, mirrored};
use crate::math::Rgb;
use crate::math::real::{Lanes, Mask, Real, Select};
use crate::math::vector::{Vec2, Vec3};
use crate::texture::Textured;

/// Both faces of a thin pane of glass at once: light is reflected or goes straight on, however often it is
/// thrown back inside.
#[derive(Clone, Debug)]
pub struct ThinDielectric {
    /// Index of the pane over that of its surroundings.
    eta: f32,
    factors: Factors,
}

impl ThinDielectric {
    /// `int_ior` of the pane, `ext_ior` around it, both > 0; the two factors scale what is reflected and
    /// transmitted and are 1 for real glass.
    #[must_use]
    pub fn new(
        int_ior: f32,
        ext_ior: f32,
        specular_reflectance: impl Into<Textured<Rgb>>,
        specular_transmittance: impl Into<Textured<Rgb>>,
    ) -> Self {
        Self {
            eta: int_ior / ext_ior,
            factors: Factors::new(specular_reflectance, specular_transmittance),
        }
    }

    /// With r for one face: r + (1 − r)²r + (1 − r)²r³ + … = 2r / (1 + r).
    #[inline(always)]
    fn reflected<R: Real>(&self, wi: Vec3<R>) -> R {
        let r = fresnel::dielectric(wi.z.abs(), self.eta).reflectance;
        r * 2.0 / (r + 1.0)
    }
}

impl Material for ThinDielectric {
    #[inline(always)]
    fn sample<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, u: Vec2<R>) -> Scattered<R> {
        let r = self.reflected(wi);
        let everywhere = R::Mask::splat(wi.token(), true);
        let weight = self.factors.reflectance.at(place.uv);
        let reflected = Scattered::delta(everywhere, mirrored(wi), weight, r);
        let transmitted = pass(wi, self.factors.transmittance.at(place.uv), r.one_minus());
        Scattered::selected(choose(r, u.x).0, reflected, transmitted)
    }

    fn flags(&self) -> Flags {
        self.factors.flags(Flags::DELTA.transmitting())
    }

    fn albedo(&self, place: &Place, wi: Vec3) -> Vec3 {
        let r = self.reflected(wi);
        self.factors.albedo(place, r)
    }

    fn interface(&self) -> Option<f32> {
        Some(1.0)
    }
}
