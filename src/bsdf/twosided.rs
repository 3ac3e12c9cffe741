//! Materials for surfaces that are seen from both sides.

use super::{Bsdf, Flags, Material, Place, Scattered};
use crate::math::real::{Mask, Real};
use crate::math::vector::{Vec2, Vec3};

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
}

/// `w` with its z turned around where `behind` is set, which makes the back a front side.
#[inline(always)]
pub(super) fn turned<R: Real>(behind: R::Mask, w: Vec3<R>) -> Vec3<R> {
    Vec3::new(w.x, w.y, R::select(behind, -w.z, w.z))
}

impl Material for TwoSided {
    #[inline(always)]
    fn evaluate<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, wo: Vec3<R>) -> (Vec3<R>, R) {
        let behind = wi.z.lt(0.0);
        let (wi, wo) = (turned(behind, wi), turned(behind, wo));
        let Some(back) = &self.back else { return self.front.evaluate(place, wi, wo) };
        behind.either(
            #[inline(always)]
            || back.evaluate(place, wi, wo),
            #[inline(always)]
            || self.front.evaluate(place, wi, wo),
        )
    }

    #[inline(always)]
    fn sample<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, u: Vec2<R>) -> Scattered<R> {
        let behind = wi.z.lt(0.0);
        let wi = turned(behind, wi);
        let sample = match &self.back {
            None => self.front.scatter(place, wi, u),
            Some(back) => behind.either(
                #[inline(always)]
                || back.scatter(place, wi, u),
                #[inline(always)]
                || self.front.scatter(place, wi, u),
            ),
        };
        Scattered { wo: turned(behind, sample.wo), ..sample }
    }

    fn flags(&self) -> Flags {
        self.flags
    }

    fn albedo(&self, place: &Place, wi: Vec3) -> Vec3 {
        let behind = wi.z < 0.0;
        let back = self.back.as_ref().filter(|_| behind);
        back.unwrap_or(&self.front).albedo(place, turned(behind, wi).into()).into()
    }

    fn interface(&self) -> Option<f32> {
        self.front.interface().or_else(|| self.back.as_ref()?.interface())
    }
}
