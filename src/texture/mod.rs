//! Quantities that vary over a surface: the contract that each texture keeps, and one file for each.

use std::fmt::Debug;
use std::sync::Arc;

use glam::Vec2 as GlamVec2;

use crate::math::real::{Lanes, Real};
use crate::math::vector::{Vec2, Vec3};
use crate::math::{Rgb, luminance};

pub mod bitmap;
pub mod checkerboard;
pub mod image;

pub use bitmap::Bitmap;
pub use checkerboard::Checkerboard;
pub use image::Image;

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
    /// The colour at `uv`. Textures are looked up lane by lane.
    #[inline(always)]
    #[must_use]
    pub fn at<R: Real>(&self, uv: Vec2<R>) -> Vec3<R> {
        match self {
            Self::Uniform(value) => Vec3::splat(uv.token(), (*value).into()),
            Self::Varying(texture) => {
                Vec3::from_fn(uv.token(), |i| texture.rgb(uv.lane(i).into()).into())
            }
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
    /// The number at `uv`. Textures are looked up lane by lane.
    #[inline(always)]
    #[must_use]
    pub fn at<R: Real>(&self, uv: Vec2<R>) -> R {
        match self {
            Self::Uniform(value) => R::splat(uv.token(), *value),
            Self::Varying(texture) => R::from_fn(uv.token(), |i| texture.scalar(uv.lane(i).into())),
        }
    }
}

impl<T> From<T> for Textured<T> {
    fn from(value: T) -> Self {
        Self::Uniform(value)
    }
}
