//! Quantities that vary over a surface: the contract that each texture keeps, and one file for each.

use std::fmt::Debug;
use std::sync::Arc;

use glam::{Affine2, Vec2 as GlamVec2};

use self::pattern::Quantity;
use crate::math::real::{Lanes, Level, Real, Rows};
use crate::math::vector::{Vec2, Vec3};
use crate::math::{Rgb, luminance};

pub mod bitmap;
pub mod checkerboard;
pub mod image;
pub mod pattern;

pub use bitmap::Bitmap;
pub use checkerboard::Checkerboard;
pub use image::Image;
pub use pattern::Pattern;

/// A function of texture coordinates.
pub trait Texture: Debug + Send + Sync {
    /// Its colour, linear sRGB.
    fn rgb(&self, uv: GlamVec2) -> Rgb;

    /// Its value where one number is asked for: the luminance of its colour.
    fn scalar(&self, uv: GlamVec2) -> f32 {
        luminance(self.rgb(uv))
    }

    /// The smallest and the largest value of any channel of its colour.
    fn range(&self) -> [f32; 2];

    /// The same with its values clamped to `[least, most]`.
    fn clamped(&self, limits: [f32; 2]) -> Arc<dyn Texture>;

    /// Derivatives of [`Texture::scalar`] after both coordinates; 0 where it jumps.
    fn gradient(&self, uv: GlamVec2) -> GlamVec2;

    /// The mean of [`Texture::scalar`] over the unit square. Guides the choice among lobes, so a rough
    /// value costs noise but no bias.
    fn mean(&self) -> f32;

    /// What is asked in eight lanes, with the same bits: of a [`Pattern`] all at once, of others one after the other.
    fn look_up_eight(&self, _level: Level, quantity: Quantity, uv: &Rows<2>, values: &mut Rows<3>) {
        pattern::look_up_lane_by_lane(self, quantity, uv, values);
    }
}

/// The point that `map` sends `uv` to.
#[inline(always)]
fn mapped<R: Real>(map: &Affine2, uv: Vec2<R>) -> Vec2<R> {
    let [x_axis, y_axis] = [map.matrix2.x_axis, map.matrix2.y_axis];
    Vec2::new(
        uv.x * x_axis.x + uv.y * y_axis.x + map.translation.x,
        uv.x * x_axis.y + uv.y * y_axis.y + map.translation.y,
    )
}

/// A quantity that is the same everywhere, or is looked up in a texture.
#[derive(Clone, Debug)]
pub enum Textured<T> {
    /// The same everywhere.
    Uniform(T),
    /// From a texture.
    Varying(Arc<dyn Texture>),
}

impl<T> Textured<T> {
    /// Whether it has to be told the texture coordinates.
    #[must_use]
    pub fn varies(&self) -> bool {
        matches!(self, Self::Varying(_))
    }
}

impl Textured<Rgb> {
    /// The colour at `uv`.
    #[inline(always)]
    #[must_use]
    pub fn at<R: Real>(&self, uv: Vec2<R>) -> Vec3<R> {
        match self {
            Self::Uniform(value) => Vec3::splat(uv.token(), (*value).into()),
            Self::Varying(texture) => texture.color(uv),
        }
    }

    /// As [`Texture::range`].
    #[must_use]
    pub fn range(&self) -> [f32; 2] {
        match self {
            Self::Uniform(value) => [value.min_element(), value.max_element()],
            Self::Varying(texture) => texture.range(),
        }
    }

    /// The mean luminance.
    #[must_use]
    pub fn mean(&self) -> f32 {
        match self {
            Self::Uniform(value) => luminance(*value),
            Self::Varying(texture) => texture.mean(),
        }
    }
}

impl Textured<f32> {
    /// The number at `uv`.
    #[inline(always)]
    #[must_use]
    pub fn at<R: Real>(&self, uv: Vec2<R>) -> R {
        match self {
            Self::Uniform(value) => R::splat(uv.token(), *value),
            Self::Varying(texture) => texture.number(uv),
        }
    }
}

impl<T> From<T> for Textured<T> {
    fn from(value: T) -> Self {
        Self::Uniform(value)
    }
}
