//! Where on a surface a material is asked.

use crate::math::Frame;
use crate::math::real::{Lanes, Real};
use crate::math::vector::{Vec2, Vec3};

/// What a material has to be told of the place; each of these includes those before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Needs {
    /// Nothing: it is the same everywhere.
    #[default]
    Nothing,
    /// Texture coordinates.
    TextureCoordinates,
    /// How texture coordinates run over the surface.
    Tangents,
}

/// A place on a surface in each lane, as far as the material's [`Needs`] go; the rest has its default.
#[derive(Clone, Copy, Debug)]
pub struct Place<R = f32> {
    /// Texture coordinates.
    pub uv: Vec2<R>,
    /// Derivative of the position after the first texture coordinate, in scene units and in the local
    /// frame, whose x is its direction in the plane of the shading normal.
    pub dp_du: Vec3<R>,
    /// Derivative of the position after the second texture coordinate.
    pub dp_dv: Vec3<R>,
    /// The geometric normal, in the local frame. Also told to what has an [interface](super::Bsdf::interface).
    pub geometric_normal: Vec3<R>,
}

impl Default for Place {
    fn default() -> Self {
        Self::anywhere(())
    }
}

impl<R: Real> Place<R> {
    /// What a material is told that needs nothing.
    #[inline(always)]
    #[must_use]
    pub fn anywhere(token: R::Token) -> Self {
        let [zero, one] = [0.0, 1.0].map(|number| R::splat(token, number));
        Self {
            uv: Vec2::new(zero, zero),
            dp_du: Vec3::new(one, zero, zero),
            dp_dv: Vec3::new(zero, one, zero),
            geometric_normal: Vec3::new(zero, zero, one),
        }
    }

    /// The same place in another local frame, given in coordinates of this one.
    #[inline(always)]
    #[must_use]
    pub fn in_frame(&self, frame: &Frame<R>) -> Self {
        Self {
            uv: self.uv,
            dp_du: frame.to_local(self.dp_du),
            dp_dv: frame.to_local(self.dp_dv),
            geometric_normal: frame.to_local(self.geometric_normal),
        }
    }

    /// That of one lane.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, i: usize) -> Place {
        Place {
            uv: self.uv.lane(i),
            dp_du: self.dp_du.lane(i),
            dp_dv: self.dp_dv.lane(i),
            geometric_normal: self.geometric_normal.lane(i),
        }
    }
}

impl<R: Copy> Place<R> {
    /// All of its numbers.
    #[inline(always)]
    pub(super) fn to_array(self) -> [R; 11] {
        let Self { uv, dp_du, dp_dv, geometric_normal: n } = self;
        let [u, v] = uv.to_array();
        let ([a, b, c], [d, e, f], [g, h, i]) = (dp_du.to_array(), dp_dv.to_array(), n.to_array());
        [u, v, a, b, c, d, e, f, g, h, i]
    }
}

impl<R> From<[R; 11]> for Place<R> {
    #[inline(always)]
    fn from([u, v, a, b, c, d, e, f, g, h, i]: [R; 11]) -> Self {
        Self {
            uv: Vec2::new(u, v),
            dp_du: Vec3::new(a, b, c),
            dp_dv: Vec3::new(d, e, f),
            geometric_normal: Vec3::new(g, h, i),
        }
    }
}
