//! Window panes.

use glam::{Vec2, Vec3A};

use super::dielectric::Factors;
use super::{Bsdf, BsdfSample, Flags, Lobe, Place, choose, fresnel};
use crate::math::Rgb;
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
    fn reflected(&self, wi: Vec3A) -> f32 {
        let r = fresnel::dielectric(wi.z.abs(), self.eta).reflectance;
        2.0 * r / (1.0 + r)
    }
}

impl Bsdf for ThinDielectric {
    fn eval(&self, _place: &Place, _wi: Vec3A, _wo: Vec3A) -> Rgb {
        Rgb::ZERO
    }

    fn pdf(&self, _place: &Place, _wi: Vec3A, _wo: Vec3A) -> f32 {
        0.0
    }

    fn sample(&self, place: &Place, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        let r = self.reflected(wi);
        Some(if choose(r, u.x).0 {
            BsdfSample {
                wo: Vec3A::new(-wi.x, -wi.y, wi.z),
                weight: self.factors.reflectance.at(place.uv).into(),
                pdf: r,
                lobe: Lobe::Delta,
                eta: 1.0,
            }
        } else {
            BsdfSample {
                wo: -wi,
                weight: self.factors.transmittance.at(place.uv).into(),
                pdf: 1.0 - r,
                lobe: Lobe::Null,
                eta: 1.0,
            }
        })
    }

    fn flags(&self) -> Flags {
        self.factors.flags(Flags::DELTA.transmitting())
    }

    fn albedo(&self, place: &Place, wi: Vec3A) -> Rgb {
        let r = self.reflected(wi);
        self.factors.albedo(place, r)
    }

    fn interface(&self) -> Option<f32> {
        Some(1.0)
    }
}
