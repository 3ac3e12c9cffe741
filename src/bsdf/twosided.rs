//! Materials for surfaces that are seen from both sides.

use glam::{Vec2, Vec3A};

use super::{Bsdf, BsdfSample};
use crate::math::Rgb;

/// One reflecting material on the side of the normal, one (perhaps the same) on the other.
#[derive(Debug)]
pub struct TwoSided {
    front: Box<dyn Bsdf>,
    /// `None`: the front material on both sides.
    back: Option<Box<dyn Bsdf>>,
}

impl TwoSided {
    /// `None` if one of them transmits: light that passes through cannot be given to two materials.
    #[must_use]
    pub fn new(front: Box<dyn Bsdf>, back: Option<Box<dyn Bsdf>>) -> Option<Self> {
        let transmits = front.transmits() || back.as_ref().is_some_and(|b| b.transmits());
        (!transmits).then_some(Self { front, back })
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
    fn eval(&self, wi: Vec3A, wo: Vec3A) -> Rgb {
        let (bsdf, mirror) = self.side(wi);
        bsdf.eval(wi * mirror, wo * mirror)
    }

    fn pdf(&self, wi: Vec3A, wo: Vec3A) -> f32 {
        let (bsdf, mirror) = self.side(wi);
        bsdf.pdf(wi * mirror, wo * mirror)
    }

    fn sample(&self, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        let (bsdf, mirror) = self.side(wi);
        bsdf.sample(wi * mirror, u).map(|s| BsdfSample { wo: s.wo * mirror, ..s })
    }

    fn is_delta(&self) -> bool {
        self.front.is_delta() && self.back.as_ref().is_none_or(|b| b.is_delta())
    }

    fn transmits(&self) -> bool {
        false
    }

    fn albedo(&self, wi: Vec3A) -> Rgb {
        let (bsdf, mirror) = self.side(wi);
        bsdf.albedo(wi * mirror)
    }
}
