//! A material over any number of lanes, and how it becomes a [`Bsdf`].

use std::fmt::Debug;

use glam::{Vec2 as GlamVec2, Vec3A};

use super::{Bsdf, BsdfSample, Flags, Lobe, Place};
use crate::math::Rgb;
use crate::math::real::{Lanes, Level, Mask, Real, Rows, Select, Simd, Task, f32x8};
use crate::math::vector::{Vec2, Vec3};

/// A [`Bsdf`] that is written once for one path and for eight.
///
/// All is as [`Bsdf`] says, in each lane. What follows from it is done here: a type that implements this is a [`Bsdf`].
pub trait Material: Debug + Send + Sync {
    /// [`Bsdf::eval`] and [`Bsdf::pdf`]. Unless said otherwise, those of a material that has delta lobes alone: 0.
    #[inline(always)]
    fn evaluate<R: Real>(&self, _place: &Place<R>, wi: Vec3<R>, _wo: Vec3<R>) -> (Vec3<R>, R) {
        (Vec3::splat(wi.token(), Vec3::default()), R::splat(wi.token(), 0.0))
    }

    /// See [`Bsdf::sample`].
    fn sample<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, u: Vec2<R>) -> Scattered<R>;

    /// See [`Bsdf::flags`].
    fn flags(&self) -> Flags;

    /// See [`Bsdf::albedo`].
    fn albedo(&self, place: &Place, wi: Vec3) -> Vec3;

    /// See [`Bsdf::interface`].
    fn interface(&self) -> Option<f32> {
        None
    }
}

/// A [`BsdfSample`] in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Scattered<R: Real> {
    /// Where there is one; elsewhere the rest means nothing.
    pub exists: R::Mask,
    /// See [`BsdfSample::wo`].
    pub wo: Vec3<R>,
    /// See [`BsdfSample::weight`].
    pub weight: Vec3<R>,
    /// See [`BsdfSample::pdf`].
    pub pdf: R,
    /// Where it comes from a delta lobe.
    pub is_delta: R::Mask,
    /// Where that is [`Lobe::Null`].
    pub is_null: R::Mask,
    /// See [`BsdfSample::eta`].
    pub eta: R,
}

impl<R: Real> Scattered<R> {
    /// Of a lobe with a density, on the side of `wi`.
    #[inline(always)]
    pub fn smooth(exists: R::Mask, wo: Vec3<R>, weight: Vec3<R>, pdf: R) -> Self {
        let token = exists.token();
        let none = R::Mask::splat(token, false);
        let eta = R::splat(token, 1.0);
        Self { exists, wo, weight, pdf, is_delta: none, is_null: none, eta }
    }

    /// Of a delta lobe that this is the discrete probability of, on the side of `wi`.
    #[inline(always)]
    pub fn delta(exists: R::Mask, wo: Vec3<R>, weight: Vec3<R>, probability: R) -> Self {
        let is_delta = R::Mask::splat(exists.token(), true);
        Self { is_delta, ..Self::smooth(exists, wo, weight, probability) }
    }

    /// Those of the lanes where the mask is set.
    #[inline(always)]
    pub fn only_where(self, mask: R::Mask) -> Self {
        Self { exists: self.exists & mask, ..self }
    }

    /// That of a lane, if there is one.
    ///
    /// # Panics
    /// There is no such lane.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, i: usize) -> Option<BsdfSample> {
        let lobe = match (self.is_delta.lane(i), self.is_null.lane(i)) {
            (false, _) => Lobe::Smooth,
            (true, false) => Lobe::Delta,
            (true, true) => Lobe::Null,
        };
        self.exists.lane(i).then(|| BsdfSample {
            wo: self.wo.lane(i).into(),
            weight: self.weight.lane(i).into(),
            pdf: self.pdf.lane(i),
            lobe,
            eta: self.eta.lane(i),
        })
    }
}

impl<R: Real> Select for Scattered<R> {
    type Mask = R::Mask;

    #[inline(always)]
    fn selected(mask: R::Mask, yes: Self, no: Self) -> Self {
        Self {
            exists: mask.select(yes.exists, no.exists),
            wo: Vec3::select(mask, yes.wo, no.wo),
            weight: Vec3::select(mask, yes.weight, no.weight),
            pdf: R::select(mask, yes.pdf, no.pdf),
            is_delta: mask.select(yes.is_delta, no.is_delta),
            is_null: mask.select(yes.is_null, no.is_null),
            eta: R::select(mask, yes.eta, no.eta),
        }
    }
}

/// In which lanes there is a sample, by bits, and what it comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleBits {
    exists: u32,
    delta: u32,
    null: u32,
}

/// What is asked of eight lanes: place, `wi` and `wo`.
pub type EvalRows = Rows<17>;

/// What is asked of eight lanes: place, `wi` and `u`.
pub type SampleRows = Rows<16>;

/// A sample: `wo`, weight, density and index.
pub type ScatteredRows = Rows<8>;

impl dyn Bsdf + '_ {
    /// [`Bsdf::eval`] and [`Bsdf::pdf`] in each lane.
    #[inline(always)]
    pub fn evaluate<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, wo: Vec3<R>) -> (Vec3<R>, R) {
        let token = wi.token();
        if R::LANES == 1 {
            let (place, wi, wo) = (place.lane(0), wi.lane(0).into(), wo.lane(0).into());
            let (value, pdf) = self.eval_with_pdf(&place, wi, wo);
            return (Vec3::splat(token, value.into()), R::splat(token, pdf));
        }
        let mut input = EvalRows::ZERO;
        let [x, y, z] = wi.to_array();
        let [u, v, w] = wo.to_array();
        let [a, b, c, d, e, f, g, h, i, j, k] = place.to_array();
        input.store([a, b, c, d, e, f, g, h, i, j, k, x, y, z, u, v, w]);
        let mut output = Rows::ZERO;
        self.eval_eight(R::level(token), &input, &mut output);
        let [x, y, z, pdf] = output.load(token);
        (Vec3::new(x, y, z), pdf)
    }

    /// [`Bsdf::sample`] in each lane.
    #[inline(always)]
    pub fn scatter<R: Real>(&self, place: &Place<R>, wi: Vec3<R>, u: Vec2<R>) -> Scattered<R> {
        let token = wi.token();
        if R::LANES == 1 {
            let sample = self.sample(&place.lane(0), wi.lane(0).into(), u.lane(0).into());
            return scattered(token, sample);
        }
        let mut input = SampleRows::ZERO;
        let [x, y, z] = wi.to_array();
        let [a, b, c, d, e, f, g, h, i, j, k] = place.to_array();
        input.store([a, b, c, d, e, f, g, h, i, j, k, x, y, z, u.x, u.y]);
        let mut output = ScatteredRows::ZERO;
        let SampleBits { exists, delta, null } =
            self.sample_eight(R::level(token), &input, &mut output);
        let [a, b, c, d, e, f, pdf, eta] = output.load(token);
        Scattered {
            exists: R::Mask::from_bits(token, exists),
            wo: Vec3::new(a, b, c),
            weight: Vec3::new(d, e, f),
            pdf,
            is_delta: R::Mask::from_bits(token, delta),
            is_null: R::Mask::from_bits(token, null),
            eta,
        }
    }
}

/// One sample, or none, in all lanes.
#[inline(always)]
fn scattered<R: Real>(token: R::Token, sample: Option<BsdfSample>) -> Scattered<R> {
    let everywhere = |set| R::Mask::splat(token, set);
    let exists = everywhere(sample.is_some());
    let BsdfSample { wo, weight, pdf, lobe, eta } = sample.unwrap_or(BsdfSample {
        wo: Vec3A::ZERO,
        weight: Rgb::ZERO,
        pdf: 0.0,
        lobe: Lobe::Smooth,
        eta: 1.0,
    });
    Scattered {
        exists,
        wo: Vec3::splat(token, wo.into()),
        weight: Vec3::splat(token, weight.into()),
        pdf: R::splat(token, pdf),
        is_delta: everywhere(lobe.is_delta()),
        is_null: everywhere(lobe == Lobe::Null),
        eta: R::splat(token, eta),
    }
}

/// [`Bsdf::eval_eight`] of a material that has but one lane.
pub(super) fn eval_lane_by_lane(
    bsdf: &(impl Bsdf + ?Sized),
    input: &EvalRows,
    output: &mut Rows<4>,
) {
    for lane in 0..8 {
        let [a, b, c, d, e, f, g, h, i, j, k, x, y, z, u, v, w] = input.lane(lane);
        let place = Place::from([a, b, c, d, e, f, g, h, i, j, k]);
        let (wi, wo) = (Vec3A::new(x, y, z), Vec3A::new(u, v, w));
        let (value, pdf) = bsdf.eval_with_pdf(&place, wi, wo);
        output.set_lane(lane, [value.x, value.y, value.z, pdf]);
    }
}

/// [`Bsdf::sample_eight`] of a material that has but one lane.
pub(super) fn sample_lane_by_lane(
    bsdf: &(impl Bsdf + ?Sized),
    input: &SampleRows,
    output: &mut ScatteredRows,
) -> SampleBits {
    let mut bits = SampleBits::default();
    for lane in 0..8 {
        let [a, b, c, d, e, f, g, h, i, j, k, x, y, z, u, v] = input.lane(lane);
        let place = Place::from([a, b, c, d, e, f, g, h, i, j, k]);
        let sample = bsdf.sample(&place, Vec3A::new(x, y, z), GlamVec2::new(u, v));
        let Some(BsdfSample { wo, weight, pdf, lobe, eta }) = sample else { continue };
        bits.exists |= 1 << lane;
        bits.delta |= u32::from(lobe.is_delta()) << lane;
        bits.null |= u32::from(lobe == Lobe::Null) << lane;
        output.set_lane(lane, [wo.x, wo.y, wo.z, weight.x, weight.y, weight.z, pdf, eta]);
    }
    bits
}

impl<M: Material> Bsdf for M {
    fn eval(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> Rgb {
        self.evaluate::<f32>(place, wi.into(), wo.into()).0.into()
    }

    fn pdf(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> f32 {
        self.evaluate::<f32>(place, wi.into(), wo.into()).1
    }

    fn eval_with_pdf(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> (Rgb, f32) {
        let (value, pdf) = self.evaluate::<f32>(place, wi.into(), wo.into());
        (value.into(), pdf)
    }

    fn sample(&self, place: &Place, wi: Vec3A, u: GlamVec2) -> Option<BsdfSample> {
        Material::sample::<f32>(self, place, wi.into(), u.into()).lane(0)
    }

    fn flags(&self) -> Flags {
        Material::flags(self)
    }

    fn albedo(&self, place: &Place, wi: Vec3A) -> Rgb {
        Material::albedo(self, place, wi.into()).into()
    }

    fn interface(&self) -> Option<f32> {
        Material::interface(self)
    }

    fn eval_eight(&self, level: Level, input: &EvalRows, output: &mut Rows<4>) {
        level.run(Eval { material: self, input, output });
    }

    fn sample_eight(
        &self,
        level: Level,
        input: &SampleRows,
        output: &mut ScatteredRows,
    ) -> SampleBits {
        level.run(Sample { material: self, input, output })
    }
}

struct Eval<'a, M> {
    material: &'a M,
    input: &'a EvalRows,
    output: &'a mut Rows<4>,
}

impl<M: Material> Task for Eval<'_, M> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let [a, b, c, d, e, f, g, h, i, j, k, x, y, z, u, v, w] = self.input.load::<f32x8<S>>(simd);
        let place = Place::from([a, b, c, d, e, f, g, h, i, j, k]);
        let (wi, wo) = (Vec3::new(x, y, z), Vec3::new(u, v, w));
        let (Vec3 { x, y, z }, pdf) = self.material.evaluate(&place, wi, wo);
        self.output.store([x, y, z, pdf]);
    }
}

struct Sample<'a, M> {
    material: &'a M,
    input: &'a SampleRows,
    output: &'a mut ScatteredRows,
}

impl<M: Material> Task for Sample<'_, M> {
    type Output = SampleBits;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> SampleBits {
        let [a, b, c, d, e, f, g, h, i, j, k, x, y, z, u, v] = self.input.load::<f32x8<S>>(simd);
        let place = Place::from([a, b, c, d, e, f, g, h, i, j, k]);
        let sample = self.material.sample(&place, Vec3::new(x, y, z), Vec2::new(u, v));
        let Scattered { exists, wo, weight, pdf, is_delta, is_null, eta } = sample;
        self.output.store([wo.x, wo.y, wo.z, weight.x, weight.y, weight.z, pdf, eta]);
        SampleBits { exists: exists.bits(), delta: is_delta.bits(), null: is_null.bits() }
    }
}
