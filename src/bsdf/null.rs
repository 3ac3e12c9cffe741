//! Surfaces that are not there.

use super::{Flags, Material, Place, Scattered};
use crate::math::real::{Lanes, Mask, Real};
use crate::math::vector::{Vec2, Vec3};

/// Light passes as if there were no surface. A shadow ray is stopped all the same, so light behind it is
/// found by paths that go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Null;

/// The sample that goes straight on, with this weight and probability.
#[inline(always)]
pub(super) fn pass<R: Real>(wi: Vec3<R>, weight: Vec3<R>, probability: R) -> Scattered<R> {
    let everywhere = R::Mask::splat(wi.token(), true);
    Scattered { is_null: everywhere, ..Scattered::delta(everywhere, -wi, weight, probability) }
}

impl Material for Null {
    #[inline(always)]
    fn sample<R: Real>(&self, _place: &Place<R>, wi: Vec3<R>, _u: Vec2<R>) -> Scattered<R> {
        let one = R::splat(wi.token(), 1.0);
        pass(wi, Vec3::new(one, one, one), one)
    }

    fn flags(&self) -> Flags {
        Flags::DELTA.transmitting()
    }

    fn albedo(&self, _place: &Place, _wi: Vec3) -> Vec3 {
        Vec3::new(1.0, 1.0, 1.0)
    }
}
