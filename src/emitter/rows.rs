//! What emitters are asked in eight lanes, and what they answer: trait objects cannot be generic over levels.

use glam::{DVec2, DVec3};

use super::{Emitter, EmitterSample, EmitterSamples, Sight};
use crate::math::real::{Lanes, Mask, Real, Rows};
use crate::math::vector::{Vec2, Vec3};
use crate::ray::RayEnds;

/// What an emitter is asked in eight lanes.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct SampleRows {
    /// Where light is to arrive: x, y and z.
    pub from: Rows<3, f64>,
    /// See [`Emitter::sample_toward`].
    pub u: Rows<2, f64>,
    /// See [`Emitter::sample_part_toward`]; `None` for [`Emitter::sample_toward`].
    pub parts: Option<[u32; 8]>,
}

/// What it answers.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct EmitterSampleRows {
    point: Rows<3, f64>,
    /// Direction, weight, density, normal of the end.
    numbers: Rows<10>,
    exists: u32,
    is_infinite: u32,
    is_of_surface: u32,
    is_front: u32,
}

impl EmitterSampleRows {
    /// For what is written next.
    const NONE: Self = Self {
        point: Rows([[0.0; 8]; 3]),
        numbers: Rows::ZERO,
        exists: 0,
        is_infinite: 0,
        is_of_surface: 0,
        is_front: 0,
    };

    /// Samples into memory.
    #[inline(always)]
    pub(super) fn store<R: Real>(&mut self, samples: &EmitterSamples<R>) {
        let EmitterSamples { direction: d, weight: w, pdf, ref end, .. } = *samples;
        let n = end.normal;
        self.point.store(end.point.to_array());
        self.numbers.store([d.x, d.y, d.z, w.x, w.y, w.z, pdf, n.x, n.y, n.z]);
        self.exists = samples.exists.bits();
        self.is_infinite = samples.is_infinite.bits();
        self.is_of_surface = samples.is_of_surface.bits();
        self.is_front = end.is_front.bits();
    }

    #[inline(always)]
    fn load<R: Real>(&self, token: R::Token) -> EmitterSamples<R> {
        let [a, b, c, d, e, f, pdf, g, h, i] = self.numbers.load::<R>(token);
        let mask = |bits| R::Mask::from_bits(token, bits);
        EmitterSamples {
            exists: mask(self.exists),
            direction: Vec3::new(a, b, c),
            weight: Vec3::new(d, e, f),
            pdf,
            is_infinite: mask(self.is_infinite),
            is_of_surface: mask(self.is_of_surface),
            end: RayEnds {
                point: self.point.load::<R::Double>(token).into(),
                normal: Vec3::new(g, h, i),
                is_front: mask(self.is_front),
            },
        }
    }
}

/// Along which rays an environment is seen, in eight lanes.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct SightRows {
    /// See [`Sight::from`].
    pub from: Rows<3, f64>,
    /// See [`Sight::direction`].
    pub direction: Rows<3>,
}

/// What is seen there: radiance and density.
pub type BackgroundRows = Rows<4>;

/// [`Emitter::background_eight`] of an emitter that has but one lane.
pub(super) fn background_lane_by_lane(
    emitter: &(impl Emitter + ?Sized),
    sights: &SightRows,
    seen: &mut BackgroundRows,
) {
    for lane in 0..8 {
        let (from, direction) = (sights.from.lane(lane).into(), sights.direction.lane(lane).into());
        let sight = Sight { from, direction, surface: None };
        let [x, y, z] = emitter.radiance(&sight).to_array();
        seen.set_lane(lane, [x, y, z, emitter.pdf_toward(&sight)]);
    }
}

/// What an emitter is asked in one lane.
fn ask(
    emitter: &(impl Emitter + ?Sized),
    part: Option<u32>,
    from: DVec3,
    u: DVec2,
) -> Option<EmitterSample> {
    match part {
        Some(part) => emitter.sample_part_toward(part as usize, from, u),
        None => emitter.sample_toward(from, u),
    }
}

/// [`Emitter::sample_eight`] of an emitter that has but one lane.
pub(super) fn lane_by_lane(
    emitter: &(impl Emitter + ?Sized),
    asked: &SampleRows,
    rows: &mut EmitterSampleRows,
) {
    for lane in 0..8 {
        let (from, u) = (asked.from.lane(lane).into(), asked.u.lane(lane).into());
        let part = asked.parts.map(|parts| parts[lane]);
        let Some(sample) = ask(emitter, part, from, u) else { continue };
        let EmitterSamples {
            direction: d, weight: w, pdf, end, is_infinite, is_of_surface, ..
        } = EmitterSamples::<f32>::splat((), Some(&sample));
        let n = end.normal;
        rows.numbers.set_lane(lane, [d.x, d.y, d.z, w.x, w.y, w.z, pdf, n.x, n.y, n.z]);
        rows.point.set_lane(lane, end.point.to_array());
        rows.exists |= 1 << lane;
        rows.is_infinite |= u32::from(is_infinite) << lane;
        rows.is_of_surface |= u32::from(is_of_surface) << lane;
        rows.is_front |= u32::from(end.is_front) << lane;
    }
}

impl dyn Emitter + '_ {
    /// [`Emitter::sample_toward`], or with parts [`Emitter::sample_part_toward`], in each lane.
    #[inline(always)]
    pub fn sample<R: Real>(
        &self,
        parts: Option<R::Each<u32>>,
        from: Vec3<R::Double>,
        u: Vec2<R::Double>,
    ) -> EmitterSamples<R> {
        let token = u.x.token();
        if R::LANES == 1 {
            let part = parts.map(|parts| parts.as_ref()[0]);
            let sample = ask(self, part, from.lane(0).into(), u.lane(0).into());
            return EmitterSamples::splat(token, sample.as_ref());
        }
        let asked = SampleRows {
            from: Rows::of(from.to_array()),
            u: Rows::of(u.to_array()),
            parts: parts.map(|parts| std::array::from_fn(|i| parts.as_ref()[i])),
        };
        let mut rows = EmitterSampleRows::NONE;
        self.sample_eight(R::level(token), &asked, &mut rows);
        rows.load(token)
    }

    /// Of an environment the radiance that a ray sees in each lane, and [`Emitter::pdf_toward`].
    #[inline(always)]
    pub fn background<R: Real>(&self, from: Vec3<R::Double>, direction: Vec3<R>) -> (Vec3<R>, R) {
        let token = direction.token();
        if R::LANES == 1 {
            let (from, direction) = (from.lane(0).into(), direction.lane(0).into());
            let sight = Sight { from, direction, surface: None };
            let radiance = Vec3::splat(token, self.radiance(&sight).into());
            return (radiance, R::splat(token, self.pdf_toward(&sight)));
        }
        let sights = SightRows {
            from: Rows::of(from.to_array()),
            direction: Rows::of(direction.to_array()),
        };
        let mut seen = BackgroundRows::ZERO;
        self.background_eight(R::level(token), &sights, &mut seen);
        let [x, y, z, pdf] = seen.load::<R>(token);
        (Vec3::new(x, y, z), pdf)
    }
}
