//! Rays and the hits that an engine reports for them.

use glam::{DAffine3, DMat3, DVec3, Vec3, Vec3A};

use crate::math::UNIT_ROUNDOFF as U;
use crate::math::real::{Lanes, Mask, Real};
use crate::math::vector::Vec3 as Real3;

mod rays;

pub(crate) use rays::Between;
pub use rays::{CameraRays, RayLanes, Rays};

/// A segment of a half-line: the points `origin + t * direction` with `t` in `[t_min, t_max]`.
///
/// World frame, lengths in scene units. `direction` has unit length, so `t` is a distance.
/// `time` is the moment within the shutter, in `[0, 1]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where the ray starts.
    pub origin: Vec3A,
    /// Unit vector.
    pub direction: Vec3A,
    /// Hits nearer than this are ignored; at least 0.
    pub t_min: f32,
    /// Hits farther than this are ignored; may be infinite.
    pub t_max: f32,
    /// Moment within the shutter, in `[0, 1]`.
    pub time: f32,
    /// The point of a surface that it leaves, if it leaves one, of which `origin` is a rounded neighbour.
    /// Engines pass over hits close to it that a ray from the point itself has not.
    pub start: Option<RayEnd>,
    /// The point of a surface that it runs to, if its end is one; likewise.
    pub end: Option<RayEnd>,
}

/// Where a ray begins or ends on a surface, before any rounding to f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayEnd {
    /// World position, exact to a few roundings of f64.
    pub point: DVec3,
    /// Unit normal of the surface there, on either side.
    pub normal: Vec3,
    /// On which side of the surface the ray is.
    pub side: Side,
    /// Where the edge of the surface is not, if one is near.
    pub inward: Inward,
}

/// The way off the edges next to a point of a surface, along that: so long that each unit of it leads at least one away
/// from every edge; shorter where the point is already that far from them. In eighths, so that it fits where a ray has
/// room, and nothing where no edge is near.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inward([i8; 3]);

impl Inward {
    /// No edge is near.
    pub const NONE: Self = Self([0; 3]);

    /// About this way, at most 15 long on each axis: from a corner narrower than 7 degrees it leads less far.
    #[must_use]
    pub fn new(way: DVec3) -> Self {
        let longest = way.abs().max_element();
        let way = if longest > LONGEST { way * (LONGEST / longest) } else { way };
        Self((way * 8.0).round().to_array().map(|eighths| eighths as i8))
    }

    /// About this way, as short as it can be.
    pub(crate) fn least(way: DVec3) -> Self {
        let longest = way.abs().max_element();
        if longest > 0.0 { Self::new(way / (8.0 * longest)) } else { Self::NONE }
    }

    /// As bits, from bit 8 on: below them there is room for what else is to be said of an end.
    pub(crate) fn to_bits(self) -> u32 {
        let [x, y, z] = self.0.map(|eighths| u32::from(eighths.cast_unsigned()));
        x << 8 | y << 16 | z << 24
    }

    /// The inverse of [`Inward::to_bits`], whatever is below bit 8.
    pub(crate) fn from_bits(bits: u32) -> Self {
        Self([8, 16, 24].map(|shift| (bits >> shift) as u8 as i8))
    }

    /// The way, along the surface; 0 if no edge is near.
    #[must_use]
    pub fn way(self) -> DVec3 {
        DVec3::from(self.0.map(f64::from)) / 8.0
    }
}

/// Of a way off the edges, on each axis.
const LONGEST: f64 = 15.0;

/// A side of a surface, as its normal says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// That to which the normal points.
    Front,
    /// The other.
    Back,
}

/// A [`RayEnd`] away from edges in each lane.
#[derive(Clone, Copy, Debug)]
pub struct RayEnds<R: Real> {
    /// See [`RayEnd::point`].
    pub point: Real3<R::Double>,
    /// See [`RayEnd::normal`].
    pub normal: Real3<R>,
    /// Where [`RayEnd::side`] is the front.
    pub is_front: R::Mask,
}

impl<R: Real> RayEnds<R> {
    /// See [`RayEnd::new`].
    #[inline(always)]
    #[must_use]
    pub fn new(point: Real3<R::Double>, normal: Real3<R>, direction: Real3<R>) -> Self {
        Self { point, normal, is_front: !normal.dot(direction).lt(0.0) }
    }

    /// The same in each lane.
    #[inline(always)]
    #[must_use]
    pub fn splat(token: R::Token, end: &RayEnd) -> Self {
        Self {
            point: Real3::splat(token, end.point.into()),
            normal: Real3::splat(token, end.normal.into()),
            is_front: R::Mask::splat(token, end.side == Side::Front),
        }
    }

    /// See [`RayEnd::facing_normal`].
    #[inline(always)]
    #[must_use]
    pub fn facing_normal(&self) -> Real3<R> {
        Real3::select(self.is_front, self.normal, -self.normal)
    }

    /// How far from the surface the ray starts in f32, along the normal, in scene units: what keeps the rounded start on
    /// its side of the surface.
    ///
    /// Rounding the point to f32 moves it along the normal n by u Σ|nᵢpᵢ| at most, u = 2⁻²⁴; so does rounding the
    /// sum of point and lift. Two more are for the engine's differences. The last term keeps the start off a plane
    /// in which all coordinates are exact, such as z = 0.
    #[inline(always)]
    #[must_use]
    pub fn lift(&self) -> R {
        const TINY: f32 = 1.0 / (1u64 << 40) as f32;
        let weights = self.normal.abs().map(|n| n * (4.0 * U) + TINY);
        self.point.narrow().abs().dot(weights)
    }

    /// The start of the ray in f32: the point, lifted off the surface.
    #[inline(always)]
    #[must_use]
    pub fn start(&self) -> Real3<R> {
        self.point.narrow() + self.facing_normal() * self.lift()
    }

    /// That of one lane.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, i: usize) -> RayEnd {
        RayEnd {
            point: self.point.lane(i).into(),
            normal: self.normal.lane(i).into(),
            side: if self.is_front.lane(i) { Side::Front } else { Side::Back },
            inward: Inward::NONE,
        }
    }
}

impl RayEnd {
    /// The end at `point` of a ray that leaves towards `direction` (unit), on a surface whose unit normal is `normal`.
    #[must_use]
    #[inline(always)]
    pub fn new(point: DVec3, normal: Vec3A, direction: Vec3A) -> Self {
        RayEnds::<f32>::new(point.into(), normal.into(), direction.into()).lane(0)
    }

    /// Unit normal of the surface, on the side of the ray.
    #[must_use]
    #[inline(always)]
    pub fn facing_normal(&self) -> Vec3A {
        RayEnds::<f32>::splat((), self).facing_normal().into()
    }

    /// See [`RayEnds::lift`].
    #[must_use]
    #[inline(always)]
    pub fn lift(&self) -> f32 {
        RayEnds::<f32>::splat((), self).lift()
    }

    /// See [`RayEnds::start`].
    #[must_use]
    #[inline(always)]
    pub fn start(&self) -> Vec3A {
        RayEnds::<f32>::splat((), self).start().into()
    }

    /// The same end, away from edges, of the ray whose direction `map` turns into `direction`, in the space that `map` leads to; `normals`
    /// is the inverse transpose of its matrix.
    #[must_use]
    pub fn mapped(&self, map: &DAffine3, normals: &DMat3, direction: Vec3A) -> Self {
        let normal = (*normals * self.normal.as_dvec3()).normalize().as_vec3a();
        Self::new(map.transform_point3(self.point), normal, direction)
    }
}

impl Ray {
    /// Components at or above this magnitude overflow in Embree's own tests of a box
    /// (its `FLT_LARGE`, the square root of the largest f32 over 100).
    pub const LARGEST_COORDINATE: f32 = 1.844e18;

    /// The whole half-line from `origin`, at time 0.
    ///
    /// `t_min` is the smallest positive normal number and not 0, because a watertight test accepts
    /// `t == t_min`, and a surface through the origin is at exactly 0.
    #[must_use]
    pub fn new(origin: impl Into<Vec3A>, direction: impl Into<Vec3A>) -> Self {
        let (origin, direction) = (origin.into(), direction.into());
        let (t_min, t_max) = (f32::MIN_POSITIVE, f32::INFINITY);
        Self { origin, direction, t_min, t_max, time: 0.0, start: None, end: None }
    }

    /// Where the ray starts before rounding.
    #[must_use]
    #[inline(always)]
    pub fn exact_origin(&self) -> DVec3 {
        self.start.map_or_else(|| self.origin.as_dvec3(), |start| start.point)
    }

    /// The same from an exact point, of no surface that matters.
    #[must_use]
    pub fn from_exact(point: DVec3, direction: Vec3A) -> Self {
        let end = RayEnd::new(point, Vec3A::ZERO, direction);
        Self { start: Some(end), ..Self::new(point.as_vec3a(), direction) }
    }

    /// The same ray, ending at `t_max`.
    #[must_use]
    pub fn until(self, t_max: f32) -> Self {
        Self { t_max, ..self }
    }

    /// The ray in the space that `map` leads to, formed in f64 and rounded once, and lengths along it over
    /// lengths along this one. The map must not flatten its direction. What surfaces it runs between is not kept.
    #[must_use]
    pub fn mapped(&self, map: &DAffine3) -> (Self, f64) {
        let origin = map.transform_point3(self.origin.as_dvec3());
        let direction = map.transform_vector3(self.direction.as_dvec3());
        let stretch = direction.length();
        let along = |t: f32| (f64::from(t) * stretch) as f32;
        let ray = Self {
            origin: origin.as_vec3a(),
            direction: (direction / stretch).as_vec3a(),
            // 0 stands for the surface that the ray leaves, as in `Ray::new`.
            t_min: along(self.t_min).max(f32::MIN_POSITIVE),
            t_max: along(self.t_max),
            time: self.time,
            start: None,
            end: None,
        };
        (ray, stretch)
    }

    /// Whether an engine may be asked about this ray. Engines report no hit for any other:
    /// Debian 12's Embree is compiled with assertions and would end the process, Debian 13's
    /// would answer with an arbitrary hit.
    ///
    /// Every comparison is written so that NaN fails it.
    #[must_use]
    #[inline(always)]
    pub fn is_traceable(&self) -> bool {
        is_traceable(self.origin, self.direction, [self.t_min, self.t_max, self.time])
    }
}

/// [`Ray::is_traceable`] of a ray with these `t_min`, `t_max` and time.
#[inline(always)]
pub(crate) fn is_traceable(
    origin: Vec3A,
    direction: Vec3A,
    [t_min, t_max, time]: [f32; 3],
) -> bool {
    let largest = Vec3A::splat(Ray::LARGEST_COORDINATE);
    let small = origin.abs().cmplt(largest) & direction.abs().cmplt(largest);
    small.all() && t_min >= 0.0 && !t_max.is_nan() && (0.0..=1.0).contains(&time)
}

/// Where a ray meets a shape. Position and normals are rebuilt from these numbers and the shape's
/// own data (`Shape::surface`), never from `origin + t * direction`, whose error grows with `t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, in scene units.
    pub t: f32,
    /// First surface parameter: for a triangle the barycentric weight of its second vertex.
    pub u: f32,
    /// Second surface parameter: for a triangle the barycentric weight of its third vertex.
    pub v: f32,
    /// Index of the shape in the scene.
    pub shape: u32,
    /// Index of the primitive in the shape: the triangle of a mesh, 0 for the others.
    pub primitive: u32,
    /// Of an instance, index of the shape in its group, whose primitive is meant; else 0.
    pub member: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_that_no_engine_may_see_are_recognised() {
        let good = Ray::new(Vec3A::ZERO, Vec3A::Z);
        assert!(good.is_traceable());
        assert!(Ray { t_min: 0.0, time: 1.0, ..good }.is_traceable());
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e20, -1e20] {
            for axis in 0..3 {
                let mut v = Vec3A::splat(0.5);
                v[axis] = bad;
                assert!(!Ray { origin: v, ..good }.is_traceable(), "origin {v}");
                assert!(!Ray { direction: v, ..good }.is_traceable(), "direction {v}");
            }
        }
        for t_min in [-1.0, f32::NAN] {
            assert!(!Ray { t_min, ..good }.is_traceable(), "t_min {t_min}");
        }
        assert!(!Ray { t_max: f32::NAN, ..good }.is_traceable());
        for time in [-1e-7, 1.000_000_1, f32::NAN] {
            assert!(!Ray { time, ..good }.is_traceable(), "time {time}");
        }
    }
}
