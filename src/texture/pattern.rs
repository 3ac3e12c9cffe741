//! A texture over any number of lanes, and how it becomes a [`Texture`].

use std::fmt::Debug;
use std::sync::Arc;

use glam::Vec2 as GlamVec2;

use super::Texture;
use crate::math::Rgb;
use crate::math::real::{Lanes, Level, Real, Rows, Simd, Task, f32x8};
use crate::math::vector::{Vec2, Vec3};

/// A [`Texture`] that is written once for one lane and for eight.
///
/// All is as [`Texture`] says, in each lane. What follows from it is done here: a type that implements this is a
/// [`Texture`].
pub trait Pattern: Debug + Send + Sync {
    /// See [`Texture::rgb`].
    fn rgb<R: Real>(&self, uv: Vec2<R>) -> Vec3<R>;

    /// See [`Texture::scalar`].
    fn scalar<R: Real>(&self, uv: Vec2<R>) -> R;

    /// See [`Texture::gradient`].
    fn gradient<R: Real>(&self, uv: Vec2<R>) -> Vec2<R>;

    /// See [`Texture::range`].
    fn range(&self) -> [f32; 2];

    /// See [`Texture::clamped`].
    fn clamped(&self, limits: [f32; 2]) -> Arc<dyn Texture>;

    /// See [`Texture::mean`].
    fn mean(&self) -> f32;
}

/// What is asked of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// [`Texture::rgb`].
    Rgb,
    /// [`Texture::scalar`], in the first number.
    Scalar,
    /// [`Texture::gradient`], in the first two.
    Gradient,
}

impl dyn Texture + '_ {
    /// [`Texture::rgb`] in each lane.
    #[inline(always)]
    pub fn color<R: Real>(&self, uv: Vec2<R>) -> Vec3<R> {
        self.look_up(Quantity::Rgb, uv).into()
    }

    /// [`Texture::scalar`] in each lane.
    #[inline(always)]
    pub fn number<R: Real>(&self, uv: Vec2<R>) -> R {
        self.look_up(Quantity::Scalar, uv)[0]
    }

    /// [`Texture::gradient`] in each lane.
    #[inline(always)]
    pub fn slope<R: Real>(&self, uv: Vec2<R>) -> Vec2<R> {
        let [u, v, _] = self.look_up(Quantity::Gradient, uv);
        Vec2::new(u, v)
    }

    #[inline(always)]
    fn look_up<R: Real>(&self, quantity: Quantity, uv: Vec2<R>) -> [R; 3] {
        let token = uv.token();
        if R::LANES == 1 {
            return look_up(self, quantity, uv.lane(0)).map(|number| R::splat(token, number));
        }
        let mut values = Rows::ZERO;
        self.look_up_eight(R::level(token), quantity, &Rows::of(uv.to_array()), &mut values);
        values.load(token)
    }
}

/// What is asked, in one lane.
#[inline(always)]
fn look_up(texture: &(impl Texture + ?Sized), quantity: Quantity, uv: Vec2) -> [f32; 3] {
    match quantity {
        Quantity::Rgb => texture.rgb(uv.into()).to_array(),
        Quantity::Scalar => [texture.scalar(uv.into()), 0.0, 0.0],
        Quantity::Gradient => texture.gradient(uv.into()).extend(0.0).to_array(),
    }
}

/// [`Texture::look_up_eight`] of a texture that has but one lane.
pub(super) fn look_up_lane_by_lane(
    texture: &(impl Texture + ?Sized),
    quantity: Quantity,
    uv: &Rows<2>,
    values: &mut Rows<3>,
) {
    for lane in 0..8 {
        values.set_lane(lane, look_up(texture, quantity, uv.lane(lane).into()));
    }
}

impl<P: Pattern> Texture for P {
    fn rgb(&self, uv: GlamVec2) -> Rgb {
        Pattern::rgb::<f32>(self, uv.into()).into()
    }

    fn scalar(&self, uv: GlamVec2) -> f32 {
        Pattern::scalar::<f32>(self, uv.into())
    }

    fn range(&self) -> [f32; 2] {
        Pattern::range(self)
    }

    fn clamped(&self, limits: [f32; 2]) -> Arc<dyn Texture> {
        Pattern::clamped(self, limits)
    }

    fn gradient(&self, uv: GlamVec2) -> GlamVec2 {
        Pattern::gradient::<f32>(self, uv.into()).into()
    }

    fn mean(&self) -> f32 {
        Pattern::mean(self)
    }

    fn look_up_eight(&self, level: Level, quantity: Quantity, uv: &Rows<2>, values: &mut Rows<3>) {
        level.run(LookUp { pattern: self, quantity, uv, values });
    }
}

struct LookUp<'a, P> {
    pattern: &'a P,
    quantity: Quantity,
    uv: &'a Rows<2>,
    values: &'a mut Rows<3>,
}

impl<P: Pattern> Task for LookUp<'_, P> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let uv = Vec2::from(self.uv.load::<f32x8<S>>(simd));
        let zero = f32x8::splat(simd, 0.0);
        self.values.store(match self.quantity {
            Quantity::Rgb => self.pattern.rgb(uv).to_array(),
            Quantity::Scalar => [self.pattern.scalar(uv), zero, zero],
            Quantity::Gradient => self.pattern.gradient(uv).extend(zero).to_array(),
        });
    }
}
