//! Where on a surface a material is asked.

use glam::{Vec2, Vec3A};

use crate::math::Frame;

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

/// A place on a surface, as far as the material's [`Needs`] go; the rest has its default.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Texture coordinates.
    pub uv: Vec2,
    /// Derivative of the position after the first texture coordinate, in scene units and in the local
    /// frame, whose x is its direction in the plane of the shading normal.
    pub dp_du: Vec3A,
    /// Derivative of the position after the second texture coordinate.
    pub dp_dv: Vec3A,
    /// The geometric normal, in the local frame.
    pub geometric_normal: Vec3A,
}

impl Default for Place {
    fn default() -> Self {
        Self { uv: Vec2::ZERO, dp_du: Vec3A::X, dp_dv: Vec3A::Y, geometric_normal: Vec3A::Z }
    }
}

impl Place {
    /// The same place in another local frame, given in coordinates of this one.
    #[must_use]
    pub fn in_frame(&self, frame: &Frame) -> Self {
        Self {
            uv: self.uv,
            dp_du: frame.to_local(self.dp_du.into()).into(),
            dp_dv: frame.to_local(self.dp_dv.into()).into(),
            geometric_normal: frame.to_local(self.geometric_normal.into()).into(),
        }
    }
}
