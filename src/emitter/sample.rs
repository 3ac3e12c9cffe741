//! Light that arrives at a point from an emitter, and the ray that has to be free for it.

use glam::{DVec2, DVec3, Vec3A};

use super::Emitter;
use crate::math::real::{Lanes, Mask, Real, Rows, Select};
use crate::math::vector::{Vec2, Vec3};
use crate::math::{Rgb, UNIT_ROUNDOFF};
use crate::ray::{Ray, RayEnd, RayEnds, RayLanes, Rays};
use crate::shape::{Interaction, SurfacePoint};

/// Light that arrives at a point, chosen by [`Emitter::sample_toward`].
#[derive(Clone, Copy, Debug)]
pub struct EmitterSample {
    /// Unit direction towards the light.
    pub direction: Vec3A,
    /// Radiance over density; for an emitter without extent its intensity over squared distance.
    pub weight: Rgb,
    /// Density per solid angle. Infinitely many directions miss an emitter without extent, and 0
    /// stands for that: no other technique can choose this direction.
    pub pdf: f32,
    /// Where the light comes from.
    pub origin: LightOrigin,
}

/// The far end of a shadow ray.
#[derive(Clone, Copy, Debug)]
pub enum LightOrigin {
    /// A point in space.
    Point(Vec3A),
    /// A point of a surface.
    Surface(RayEnd),
    /// Outside of the scene.
    Infinity,
}

impl EmitterSample {
    /// See [`EmitterSamples::shadow_rays`].
    #[must_use]
    pub fn shadow_ray(&self, receiver: &SurfacePoint) -> Option<Ray> {
        let sample = EmitterSamples::<f32>::splat((), Some(self));
        sample.shadow_rays(&Interaction::from(*receiver)).lane(0)
    }
}

/// An [`EmitterSample`] in each lane.
#[derive(Clone, Copy, Debug)]
pub struct EmitterSamples<R: Real> {
    /// Where there is one; elsewhere the rest means nothing.
    pub exists: R::Mask,
    /// See [`EmitterSample::direction`].
    pub direction: Vec3<R>,
    /// See [`EmitterSample::weight`].
    pub weight: Vec3<R>,
    /// See [`EmitterSample::pdf`].
    pub pdf: R,
    /// Where the light comes from outside of the scene.
    pub is_infinite: R::Mask,
    /// Where it comes from a surface.
    pub is_of_surface: R::Mask,
    /// Where else it comes from, away from edges; of a point in space the normal is 0.
    pub end: RayEnds<R>,
}

impl<R: Real> EmitterSamples<R> {
    /// From surfaces.
    #[inline(always)]
    pub(super) fn of_surface(
        exists: R::Mask,
        direction: Vec3<R>,
        weight: Vec3<R>,
        pdf: R,
        end: RayEnds<R>,
    ) -> Self {
        let token = exists.token();
        let (never, always) = (R::Mask::splat(token, false), R::Mask::splat(token, true));
        Self { exists, direction, weight, pdf, is_infinite: never, is_of_surface: always, end }
    }

    /// One sample, or none, in all lanes.
    #[inline(always)]
    pub(super) fn splat(token: R::Token, sample: Option<&EmitterSample>) -> Self {
        let origin = sample.map_or(LightOrigin::Infinity, |sample| sample.origin);
        let direction = sample.map_or(Vec3A::ZERO, |sample| sample.direction);
        let end = match origin {
            LightOrigin::Surface(end) => end,
            LightOrigin::Point(point) => RayEnd::new(point.as_dvec3(), Vec3A::ZERO, -direction),
            LightOrigin::Infinity => RayEnd::new(DVec3::ZERO, Vec3A::ZERO, -direction),
        };
        let everywhere = |set| R::Mask::splat(token, set);
        Self {
            exists: everywhere(sample.is_some()),
            direction: Vec3::splat(token, direction.into()),
            weight: Vec3::splat(token, sample.map_or(Rgb::ZERO, |s| s.weight).into()),
            pdf: R::splat(token, sample.map_or(0.0, |s| s.pdf)),
            is_infinite: everywhere(matches!(origin, LightOrigin::Infinity)),
            is_of_surface: everywhere(matches!(origin, LightOrigin::Surface(_))),
            end: RayEnds::splat(token, &end),
        }
    }

    /// That of a lane, if there is one.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, i: usize) -> Option<EmitterSample> {
        if !self.exists.lane(i) {
            return None;
        }
        let origin = if self.is_infinite.lane(i) {
            LightOrigin::Infinity
        } else if self.is_of_surface.lane(i) {
            LightOrigin::Surface(self.end.lane(i))
        } else {
            LightOrigin::Point(self.end.lane(i).point.as_vec3a())
        };
        Some(EmitterSample {
            direction: self.direction.lane(i).into(),
            weight: self.weight.lane(i).into(),
            pdf: self.pdf.lane(i),
            origin,
        })
    }

    /// The rays that have to be free for the light to arrive at `receiver`. None where the two ends are
    /// so close that rounding turns the ray around, and nothing can be said to lie between them.
    #[inline(always)]
    #[must_use]
    pub fn shadow_rays(&self, receiver: &Interaction<R>) -> ShadowRays<R> {
        let mut rays = receiver.spawn(self.direction);
        // Of a point in space the lift is 0, with its normal.
        let segment = self.end.start() - rays.origin;
        let length = segment.length();
        let is_ahead = segment.dot(self.direction).gt(0.0);
        rays.direction = Vec3::select(self.is_infinite, rays.direction, segment / length);
        rays.t_max = R::select(self.is_infinite, rays.t_max, length * BEFORE_END);
        let exists = self.exists & (self.is_infinite | is_ahead);
        ShadowRays { exists, rays, is_to_surface: self.is_of_surface, end: self.end }
    }
}

impl<R: Real> Select for EmitterSamples<R> {
    type Mask = R::Mask;

    #[inline(always)]
    fn selected(mask: R::Mask, yes: Self, no: Self) -> Self {
        Self {
            exists: mask.select(yes.exists, no.exists),
            direction: Vec3::select(mask, yes.direction, no.direction),
            weight: Vec3::select(mask, yes.weight, no.weight),
            pdf: R::select(mask, yes.pdf, no.pdf),
            is_infinite: mask.select(yes.is_infinite, no.is_infinite),
            is_of_surface: mask.select(yes.is_of_surface, no.is_of_surface),
            end: RayEnds {
                point: Vec3::select(mask, yes.end.point, no.end.point),
                normal: Vec3::select(mask, yes.end.normal, no.end.normal),
                is_front: mask.select(yes.end.is_front, no.end.is_front),
            },
        }
    }
}

/// How much of a segment is searched: an engine's distances are off by a few roundings of f32, and would place the
/// light's own surface before the light.
const BEFORE_END: f32 = 1.0 - 8.0 * UNIT_ROUNDOFF;

/// A shadow ray in each lane.
#[derive(Clone, Copy, Debug)]
pub struct ShadowRays<R: Real> {
    /// Where there is one.
    pub exists: R::Mask,
    rays: RayLanes<R>,
    is_to_surface: R::Mask,
    end: RayEnds<R>,
}

impl<R: Real> ShadowRays<R> {
    /// Appends those of the lanes that are set, where there is one or not.
    #[inline(always)]
    pub fn append_to(&self, rays: &mut Rays, mask: R::Mask) {
        rays.append_between(mask, &self.rays, self.is_to_surface, &self.end);
    }

    /// That of a lane, if there is one.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, i: usize) -> Option<Ray> {
        let end = || self.is_to_surface.lane(i).then(|| self.end.lane(i));
        self.exists.lane(i).then(|| Ray { end: end(), ..self.rays.lane(i) })
    }
}

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
}
