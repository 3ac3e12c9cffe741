//! Surface scattering: the contract that every material keeps, and one file for each.

use std::fmt::Debug;

use glam::{Vec2, Vec3A};

use crate::math::{Rgb, type_word};

pub mod conductor;
pub mod dielectric;
pub mod diffuse;
pub mod fresnel;
pub mod twosided;

pub use conductor::Conductor;
pub use dielectric::Dielectric;
pub use diffuse::Diffuse;
pub use twosided::TwoSided;

/// A bidirectional scattering distribution function.
///
/// `wi` points to where the path came from, `wo` to where it goes: unit vectors, both away from the
/// surface, in a local frame whose z is the shading normal. Values are per channel, linear sRGB.
pub trait Bsdf: Debug + Send + Sync {
    /// f(wi, wo)·|cosθₒ| in sr⁻¹. A delta lobe evaluates to 0.
    fn eval(&self, wi: Vec3A, wo: Vec3A) -> Rgb;

    /// Density with which [`Bsdf::sample`] returns `wo`, in sr⁻¹. A delta lobe has density 0. Integrates
    /// over all `wo` to the probability that `sample` returns a direction of a non-delta lobe.
    fn pdf(&self, wi: Vec3A, wo: Vec3A) -> f32;

    /// A direction for the path to go on, chosen by `u` in `[0, 1)²`. `None` where the surface
    /// absorbs, or cannot be seen from `wi`.
    fn sample(&self, wi: Vec3A, u: Vec2) -> Option<BsdfSample>;

    /// Whether all lobes are delta lobes, so that only [`Bsdf::sample`] finds light.
    fn is_delta(&self) -> bool;

    /// Whether light passes to the other side.
    fn transmits(&self) -> bool;

    /// The fraction of light from `wi` that is scattered, as shown in an albedo layer; exact where a
    /// closed form exists.
    fn albedo(&self, wi: Vec3A) -> Rgb;

    /// Name of the material's type, for reports.
    fn kind(&self) -> &'static str {
        type_word::<Self>()
    }
}

/// A direction that [`Bsdf::sample`] chose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// The direction.
    pub wo: Vec3A,
    /// f·|cosθₒ|/pdf, or the reflectance or transmittance of a delta lobe over its probability.
    pub weight: Rgb,
    /// Density per solid angle; for a delta lobe, its discrete probability.
    pub pdf: f32,
    /// Whether `wo` comes from a delta lobe.
    pub delta: bool,
    /// Refractive index of the side of `wo` over that of the side of `wi`; 1 unless refracted.
    /// Radiance is scaled by its inverse square, which Russian roulette has to undo.
    pub eta: f32,
}
