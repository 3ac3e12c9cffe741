//! Light that arrives at a point from an emitter, and the ray that has to be free for it.

use glam::{DVec3, Vec3A};

use crate::math::real::{Double, Float, Lanes, Mask, Real, Select};
use crate::math::vector::Vec3;
use crate::math::{Rgb, UNIT_ROUNDOFF};
use crate::ray::{Ray, RayEnd, RayEnds, RayLanes, Rays};
use crate::shape::{Interaction, SurfacePoint};

/// Light that arrives at a point, chosen by [`Emitter::sample_toward`](super::Emitter::sample_toward).
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

    /// From a point in space; no other technique can choose its direction.
    #[inline(always)]
    pub(super) fn of_point(
        exists: R::Mask,
        direction: Vec3<R>,
        weight: Vec3<R>,
        position: Vec3<R::Double>,
    ) -> Self {
        let token = exists.token();
        let normal = Vec3::splat(token, Vec3::default());
        let end = RayEnds::new(position, normal, -direction);
        let never = R::Mask::splat(token, false);
        let pdf = R::splat(token, 0.0);
        Self { exists, direction, weight, pdf, is_infinite: never, is_of_surface: never, end }
    }

    /// From a point in space that has an intensity towards `from`; the direction to it is undefined at the point itself.
    #[inline(always)]
    pub(super) fn of_intensity(position: Vec3A, intensity: Vec3<R>, from: Vec3<R::Double>) -> Self {
        let token = from.token();
        let position = Vec3::splat(token, position.as_dvec3().into());
        let to = position - from;
        let distance_squared = to.length_squared();
        let weight = (intensity.widen() / distance_squared).narrow();
        let Vec3 { x, y, z } = weight.abs().map(|channel| channel.lt(f32::INFINITY));
        let direction = (to / distance_squared.sqrt()).narrow();
        let exists = distance_squared.gt(0.0) & x & y & z;
        Self::of_point(exists, direction, weight, position)
    }

    /// From outside of the scene.
    #[inline(always)]
    pub(super) fn of_infinity(
        exists: R::Mask,
        direction: Vec3<R>,
        weight: Vec3<R>,
        pdf: R,
    ) -> Self {
        let token = exists.token();
        let origin = Vec3::splat(token, DVec3::ZERO.into());
        let samples = Self::of_point(exists, direction, weight, origin);
        Self { pdf, is_infinite: R::Mask::splat(token, true), ..samples }
    }

    /// One sample, or none, in all lanes.
    #[inline(always)]
    pub(crate) fn splat(token: R::Token, sample: Option<&EmitterSample>) -> Self {
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

    /// The same where they are `wanted`, of what was chosen with a probability.
    #[inline(always)]
    pub(super) fn chosen(mut self, wanted: R::Mask, probability: R::Double) -> Self {
        let probability = probability.narrow();
        self.exists &= wanted;
        self.weight = self.weight / probability;
        self.pdf *= probability;
        self
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
