//! Layers beside the picture.

use crate::property::Named;

/// One property of the first surface, as a layer of the EXR file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AovLayer {
    /// Name of the layer: the part of its channels' names before the dot.
    pub name: String,
    /// What it holds.
    pub kind: AovKind,
}

/// A property of the first surface. Averaged over a pixel, and 0 where there is no surface, but for
/// the two indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AovKind {
    /// Distance from the camera in scene units.
    Depth,
    /// World position.
    Position,
    /// Unit normal of the geometry.
    GeometricNormal,
    /// Unit normal for shading.
    ShadingNormal,
    /// Texture coordinates.
    Uv,
    /// Fraction of light that the material scatters.
    Albedo,
    /// Index of the shape at the pixel's first sample; 4294967295 where there is none.
    ShapeIndex,
    /// Index of the primitive at the pixel's first sample; 4294967295 where there is none.
    PrimitiveIndex,
}

/// The names that Mitsuba gives them.
impl Named for AovKind {
    const ALL: &'static [(&'static str, Self)] = &[
        ("depth", Self::Depth),
        ("position", Self::Position),
        ("uv", Self::Uv),
        ("geo_normal", Self::GeometricNormal),
        ("sh_normal", Self::ShadingNormal),
        ("albedo", Self::Albedo),
        ("shape_index", Self::ShapeIndex),
        ("prim_index", Self::PrimitiveIndex),
    ];
}

impl AovKind {
    /// Names of the components, as after the dot in a channel's name.
    #[must_use]
    pub fn components(self) -> &'static [&'static str] {
        match self {
            Self::Depth => &["T"],
            Self::Position | Self::GeometricNormal | Self::ShadingNormal => &["X", "Y", "Z"],
            Self::Uv => &["U", "V"],
            Self::Albedo => &["R", "G", "B"],
            Self::ShapeIndex | Self::PrimitiveIndex => &["I"],
        }
    }

    /// Whether the layer holds whole numbers, of which no mean makes sense.
    #[must_use]
    pub fn is_index(self) -> bool {
        matches!(self, Self::ShapeIndex | Self::PrimitiveIndex)
    }
}
