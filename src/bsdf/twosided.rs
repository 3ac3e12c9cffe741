//! Materials for surfaces that are seen from both sides.

use glam::{Vec2, Vec3A};

use super::{Bsdf, BsdfSample, Flags, Place};
use crate::math::Rgb;

/// One reflecting material on the side of the normal, one (perhaps the same) on the other.
#[derive(Debug)]
pub struct TwoSided {
    front: Box<dyn Bsdf>,
    /// `None`: the front material on both sides.
    back: Option<Box<dyn Bsdf>>,
    flags: Flags,
}

impl TwoSided {
    /// `None` if one of them transmits: light that passes through cannot be given to two materials.
    #[must_use]
    pub fn new(front: Box<dyn Bsdf>, back: Option<Box<dyn Bsdf>>) -> Option<Self> {
        let flags = back.iter().fold(front.flags(), |all, back| all.union(back.flags()));
        (!flags.transmits).then_some(Self { front, back, flags })
    }

    /// The material on the side of `w`, and the factor for z that makes it a front side.
    fn side(&self, w: Vec3A) -> (&dyn Bsdf, Vec3A) {
        if w.z < 0.0 {
            (self.back.as_ref().unwrap_or(&self.front).as_ref(), Vec3A::new(1.0, 1.0, -1.0))
        } else {
            (self.front.as_ref(), Vec3A::ONE)
        }
    }
}

impl Bsdf for TwoSided {
    fn eval(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> Rgb {
        let (bsdf, mirror) = self.side(wi);
        bsdf.eval(place, wi * mirror, wo * mirror)
    }

    fn pdf(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> f32 {
        let (bsdf, mirror) = self.side(wi);
        bsdf.pdf(place, wi * mirror, wo * mirror)
    }

    fn sample(&self, place: &Place, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        let (bsdf, mirror) = self.side(wi);
        bsdf.sample(place, wi * mirror, u).map(|s| BsdfSample { wo: s.wo * mirror, ..s })
    }

    fn flags(&self) -> Flags {
        self.flags
    }

    fn albedo(&self, place: &Place, wi: Vec3A) -> Rgb {
        let (bsdf, mirror) = self.side(wi);
        bsdf.albedo(place, wi * mirror)
    }

    fn interface(&self) -> Option<f32> {
        self.front.interface().or_else(|| self.back.as_ref()?.interface())
    }
}
