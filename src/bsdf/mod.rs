//! Surface scattering: the contract that every material keeps, and one file for each.

use std::fmt::Debug;
use std::sync::Arc;

use glam::{Vec2, Vec3A};

use self::material::{EvalRows, SampleBits, SampleRows, ScatteredRows};
use crate::math::discrete::ONE_MINUS_ULP;
use crate::math::real::{Level, Real, Rows};
use crate::math::vector::Vec3;
use crate::math::{Rgb, type_word};
use crate::texture::Textured;

pub mod blend;
pub mod conductor;
pub mod dielectric;
pub mod diffuse;
pub mod fresnel;
pub mod mask;
pub mod material;
pub mod microfacet;
pub mod null;
pub mod perturbed;
pub mod place;
pub mod plastic;
pub mod rough_conductor;
pub mod rough_dielectric;
pub mod rough_plastic;
pub mod shading_normal;
pub mod thin_dielectric;
pub mod twosided;

pub use blend::Blend;
pub use conductor::Conductor;
pub use dielectric::Dielectric;
pub use diffuse::Diffuse;
pub use mask::Mask;
pub use material::{Material, Scattered};
pub use null::Null;
pub use perturbed::Perturbed;
pub use place::{Needs, Place};
pub use plastic::Plastic;
pub use rough_conductor::RoughConductor;
pub use rough_dielectric::RoughDielectric;
pub use rough_plastic::RoughPlastic;
pub use thin_dielectric::ThinDielectric;
pub use twosided::TwoSided;

/// A bidirectional scattering distribution function.
///
/// `wi` points to where the path came from, `wo` to where it goes: unit vectors, both away from the
/// surface, in a local frame whose z is the shading normal. `place` says where on the surface the
/// material is asked, as far as its [`Flags::needs`] go. Values are per channel, linear sRGB.
pub trait Bsdf: Debug + Send + Sync {
    /// f(wi, wo)·|cosθₒ| in sr⁻¹. A delta lobe evaluates to 0.
    fn eval(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> Rgb;

    /// Density with which [`Bsdf::sample`] returns `wo`, in sr⁻¹. A delta lobe has density 0. Integrates
    /// over all `wo` to the probability that `sample` returns a direction of a non-delta lobe.
    fn pdf(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> f32;

    /// [`Bsdf::eval`] and [`Bsdf::pdf`], together where that is cheaper.
    fn eval_with_pdf(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> (Rgb, f32) {
        (self.eval(place, wi, wo), self.pdf(place, wi, wo))
    }

    /// A direction for the path to go on, chosen by `u` in `[0, 1)²`. `None` where the surface
    /// absorbs, or cannot be seen from `wi`.
    fn sample(&self, place: &Place, wi: Vec3A, u: Vec2) -> Option<BsdfSample>;

    /// What holds of the material everywhere.
    fn flags(&self) -> Flags;

    /// The fraction of light from `wi` that is scattered, as shown in an albedo layer. Exact where a
    /// closed form exists; a rough interface counts as a smooth one.
    fn albedo(&self, place: &Place, wi: Vec3A) -> Rgb;

    /// The interface that reflects around the mirror direction, smooth or rough, or refracts: the refractive index
    /// on the side that the normal points away from over that on the other, 1 if nothing is refracted. `None`
    /// without one. It decides which shading normals are valid ([`shading_normal`]).
    fn interface(&self) -> Option<f32> {
        None
    }

    /// Name of the material's type, for reports.
    fn kind(&self) -> &'static str {
        type_word::<Self>()
    }

    /// [`Bsdf::eval`] and [`Bsdf::pdf`] in eight lanes, with the same bits: of a [`Material`] all at once, of others one
    /// after the other.
    fn eval_eight(&self, _level: Level, input: &EvalRows, output: &mut Rows<4>) {
        material::eval_lane_by_lane(self, input, output);
    }

    /// [`Bsdf::sample`] in eight lanes, likewise.
    fn sample_eight(
        &self,
        _level: Level,
        input: &SampleRows,
        output: &mut ScatteredRows,
    ) -> SampleBits {
        material::sample_lane_by_lane(self, input, output)
    }
}

/// A material that is part of several.
impl Bsdf for Arc<dyn Bsdf> {
    fn eval(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> Rgb {
        self.as_ref().eval(place, wi, wo)
    }

    fn pdf(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> f32 {
        self.as_ref().pdf(place, wi, wo)
    }

    fn eval_with_pdf(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> (Rgb, f32) {
        self.as_ref().eval_with_pdf(place, wi, wo)
    }

    fn sample(&self, place: &Place, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        self.as_ref().sample(place, wi, u)
    }

    fn flags(&self) -> Flags {
        self.as_ref().flags()
    }

    fn albedo(&self, place: &Place, wi: Vec3A) -> Rgb {
        self.as_ref().albedo(place, wi)
    }

    fn interface(&self) -> Option<f32> {
        self.as_ref().interface()
    }

    fn kind(&self) -> &'static str {
        self.as_ref().kind()
    }

    fn eval_eight(&self, level: Level, input: &EvalRows, output: &mut Rows<4>) {
        self.as_ref().eval_eight(level, input, output);
    }

    fn sample_eight(
        &self,
        level: Level,
        input: &SampleRows,
        output: &mut ScatteredRows,
    ) -> SampleBits {
        self.as_ref().sample_eight(level, input, output)
    }
}

/// What holds of a material everywhere on it and for all directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flags {
    /// Whether it has lobes that shadow rays can find light for: lobes that are no delta lobes.
    pub smooth: bool,
    /// Whether some of those are not diffuse, so that it matters from where light arrives.
    pub glossy: bool,
    /// Whether it has delta lobes, for which only [`Bsdf::sample`] finds light.
    pub delta: bool,
    /// Whether light passes to the other side.
    pub transmits: bool,
    /// What it has to be told of the place.
    pub needs: Needs,
}

impl Flags {
    /// Diffuse reflection alone.
    pub const DIFFUSE: Self = Self { smooth: true, glossy: false, delta: false, ..Self::DELTA };
    /// Reflection without delta lobes.
    pub const SMOOTH: Self = Self { glossy: true, ..Self::DIFFUSE };
    /// Reflection by a delta lobe alone.
    pub const DELTA: Self =
        Self { smooth: false, glossy: false, delta: true, transmits: false, needs: Needs::Nothing };

    /// The same and transmission.
    #[must_use]
    pub const fn transmitting(self) -> Self {
        Self { transmits: true, ..self }
    }

    /// The same for a material that has to be told more.
    #[must_use]
    pub fn needing(self, needs: Needs) -> Self {
        Self { needs: self.needs.max(needs), ..self }
    }

    /// The same for a material that has this quantity.
    #[must_use]
    pub fn textured<T>(self, quantity: &Textured<T>) -> Self {
        if quantity.varies() { self.needing(Needs::TextureCoordinates) } else { self }
    }

    /// Those of a material that has the lobes of both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            smooth: self.smooth || other.smooth,
            glossy: self.glossy || other.glossy,
            delta: self.delta || other.delta,
            transmits: self.transmits || other.transmits,
            needs: self.needs.max(other.needs),
        }
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
    /// What `wo` comes from.
    pub lobe: Lobe,
    /// Refractive index of the side of `wo` over that of the side of `wi`; 1 unless refracted.
    /// Radiance is scaled by its inverse square, which Russian roulette has to undo.
    pub eta: f32,
}

/// What a sampled direction comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lobe {
    /// A lobe with a density.
    Smooth,
    /// A delta lobe.
    Delta,
    /// The delta lobe of light that goes straight on, as if nothing were there.
    Null,
}

impl Lobe {
    /// Whether `wo` has no density, so that no other technique can choose it.
    #[must_use]
    pub fn is_delta(self) -> bool {
        self != Self::Smooth
    }
}

/// `wi` reflected by the surface.
#[inline(always)]
fn mirrored<R: Real>(wi: Vec3<R>) -> Vec3<R> {
    Vec3::new(-wi.x, -wi.y, wi.z)
}

/// `wi` reflected by a mirror with the unit normal `m`, of length 1 but for rounding.
#[inline(always)]
fn reflect<R: Real>(wi: Vec3<R>, m: Vec3<R>) -> Vec3<R> {
    m * (wi.dot(m) * 2.0) - wi
}

/// Chooses the first of two lobes with probability `p`: whether it is the first, and a number in `[0, 1)`
/// that is independent of the choice.
#[inline(always)]
fn choose<R: Real>(p: R, u: R) -> (R::Mask, R) {
    let first = u.lt(p);
    let rest = R::select(first, u / p, (u - p) / p.one_minus());
    (first, rest.min(ONE_MINUS_ULP))
}

/// Whether a path can go on with a sample of this density: whether it is finite and above 0.
#[inline(always)]
fn is_usable<R: Real>(pdf: R) -> R::Mask {
    pdf.gt(0.0) & pdf.lt(f32::INFINITY)
}
