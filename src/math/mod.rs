//! Numbers below everything else: reals in lanes, vectors, frames, warps of the unit square, discrete
//! distributions, bounds, special functions.

pub mod aabb;
pub mod cone;
pub mod discrete;
pub mod frame;
pub mod keys;
pub mod motion;
pub mod real;
pub mod special;
pub mod vector;
pub mod warp;

pub use aabb::Aabb;
pub use cone::Cone;
pub use discrete::{Choice, Choices, Discrete};
pub use frame::Frame;
pub use keys::{Keys, KeysError};
pub use motion::Motion;

/// Linear sRGB: radiance in W·m⁻²·sr⁻¹ per channel, or a unitless reflectance.
pub type Rgb = glam::Vec3A;

/// Unit roundoff of f32, u = 2⁻²⁴: by how much at most, relatively, rounding to f32 changes a number.
pub(crate) const UNIT_ROUNDOFF: f32 = 0.5 * f32::EPSILON;

/// The last word of a type's name, for reports: `Diffuse`.
#[must_use]
pub(crate) fn type_word<T: ?Sized>() -> &'static str {
    let path = std::any::type_name::<T>();
    path.rsplit("::").next().unwrap_or(path)
}

/// Luminance of linear sRGB (Rec. 709 primaries, D65), in the unit of the input.
#[must_use]
pub fn luminance(rgb: Rgb) -> f32 {
    vector::Vec3::<f32>::from(rgb).luminance()
}
