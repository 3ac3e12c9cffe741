//! Many rays, each number of all of them together.

use glam::{DVec3, Vec3, Vec3A};

use super::{Inward, Ray, RayEnd, RayEnds, Side};
use crate::math::real::{Column, Columns, Lanes, Mask, Real, Uint};
use crate::math::vector;

/// Rays by column. If any has an end, all after it in the list say whether they have.
#[derive(Clone, Debug)]
pub struct Rays {
    /// Origin, direction, `t_min` and `t_max`.
    numbers: Columns<f32, 8>,
    times: Column<f32>,
    starts: Ends,
    ends: Ends,
}

/// Ends of rays by column.
#[derive(Clone, Debug, Default)]
struct Ends {
    points: Columns<f64, 3>,
    /// Normal, and the bits of what else there is: see [`bits_of`].
    numbers: Columns<f32, 4>,
}

/// Of [`RayEnd`]s that there are.
const EXISTS: u32 = 1;

/// Of those whose side is the back.
const IS_BACK: u32 = 2;

/// Whether there is an end, its side, and the bits of [`RayEnd::inward`].
fn bits_of(end: &RayEnd) -> u32 {
    let back = if end.side == Side::Back { IS_BACK } else { 0 };
    EXISTS | back | end.inward.to_bits()
}

impl Ends {
    fn clear(&mut self) {
        self.points.clear();
        self.numbers.clear();
    }

    fn push(&mut self, end: Option<&RayEnd>) {
        let point = end.map_or(DVec3::ZERO, |end| end.point);
        let normal = end.map_or(Vec3::ZERO, |end| end.normal);
        self.points.push(point.to_array());
        self.numbers.push([normal.x, normal.y, normal.z, f32::from_bits(end.map_or(0, bits_of))]);
    }

    #[inline(always)]
    fn append<R: Real>(&mut self, mask: R::Mask, ends: &RayEnds<R>, bits: R::Uint) {
        self.points.append(mask, ends.point.to_array());
        let [x, y, z] = ends.normal.to_array();
        self.numbers.append(mask, [x, y, z, R::from_bits(bits)]);
    }

    #[cfg(feature = "embree")]
    #[inline(always)]
    fn normal(&self, i: usize) -> Option<Vec3A> {
        let [x, y, z, bits] = self.numbers.columns();
        let exists = bits.get(i)?.to_bits() & EXISTS != 0;
        exists.then(|| Vec3A::new(x[i], y[i], z[i]))
    }

    /// Whether it is an end next to an edge.
    #[cfg(feature = "embree")]
    #[inline(always)]
    fn is_at_edge(&self, i: usize) -> bool {
        let [.., bits] = self.numbers.columns();
        bits.get(i).is_some_and(|bits| Inward::from_bits(bits.to_bits()) != Inward::NONE)
    }

    #[inline(always)]
    fn get(&self, i: usize) -> Option<RayEnd> {
        if i >= self.numbers.len() {
            return None;
        }
        let [x, y, z, bits] = self.numbers.row(i);
        let bits = bits.to_bits();
        if bits & EXISTS == 0 {
            return None;
        }
        let side = if bits & IS_BACK == 0 { Side::Front } else { Side::Back };
        let inward = Inward::from_bits(bits);
        Some(RayEnd { point: self.points.row(i).into(), normal: Vec3::new(x, y, z), side, inward })
    }
}

/// Which way a ray runs between surfaces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Between {
    pub(crate) direction: Vec3A,
    pub(crate) t_max: f32,
    /// Unit normal of the surface that it leaves, if it leaves one.
    pub(crate) start: Option<Vec3A>,
    /// The same of the one that it runs to.
    pub(crate) end: Option<Vec3A>,
    /// Whether it leaves its surface next to an edge.
    pub(crate) starts_at_edge: bool,
}

impl From<&Ray> for Between {
    #[inline(always)]
    fn from(ray: &Ray) -> Self {
        let normal = |end: &RayEnd| Vec3A::from(end.normal);
        Self {
            direction: ray.direction,
            t_max: ray.t_max,
            start: ray.start.as_ref().map(normal),
            end: ray.end.as_ref().map(normal),
            starts_at_edge: ray.start.is_some_and(|start| start.inward != Inward::NONE),
        }
    }
}

/// A ray that leaves a surface, in each lane.
#[derive(Clone, Copy, Debug)]
pub struct RayLanes<R: Real> {
    /// See [`Ray::origin`].
    pub origin: vector::Vec3<R>,
    /// See [`Ray::direction`].
    pub direction: vector::Vec3<R>,
    /// See [`Ray::t_max`]; they begin at 0.
    pub t_max: R,
    /// See [`Ray::time`].
    pub time: R,
    /// See [`Ray::start`].
    pub start: RayEnds<R>,
    /// See [`Inward::to_bits`].
    pub(crate) inward: R::Uint,
}

impl<R: Real> RayLanes<R> {
    /// That of one lane.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, i: usize) -> Ray {
        let inward = Inward::from_bits(self.inward.lane(i));
        Ray {
            origin: Vec3A::from(self.origin.lane(i)),
            direction: Vec3A::from(self.direction.lane(i)),
            t_min: 0.0,
            t_max: self.t_max.lane(i),
            time: self.time.lane(i),
            start: Some(RayEnd { inward, ..self.start.lane(i) }),
            end: None,
        }
    }
}

/// A ray that leaves the camera, in each lane.
#[derive(Clone, Copy, Debug)]
pub struct CameraRays<R: Real> {
    /// See [`Ray::origin`].
    pub origin: vector::Vec3<R>,
    /// See [`Ray::direction`].
    pub direction: vector::Vec3<R>,
    /// See [`Ray::t_min`].
    pub t_min: R,
    /// See [`Ray::t_max`].
    pub t_max: R,
    /// See [`Ray::time`].
    pub time: R,
}

impl<R: Real> CameraRays<R> {
    /// That of one lane.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, i: usize) -> Ray {
        Ray {
            t_min: self.t_min.lane(i),
            t_max: self.t_max.lane(i),
            time: self.time.lane(i),
            ..Ray::new(Vec3A::from(self.origin.lane(i)), Vec3A::from(self.direction.lane(i)))
        }
    }

    /// What `of` makes of each.
    #[must_use]
    pub fn map(&self, of: impl Fn(Ray) -> Ray) -> Self {
        let token = self.time.token();
        let rays = R::each(|i| of(self.lane(i)));
        let rays = rays.as_ref();
        Self {
            origin: vector::Vec3::from_fn(token, |i| rays[i].origin.into()),
            direction: vector::Vec3::from_fn(token, |i| rays[i].direction.into()),
            t_min: R::from_fn(token, |i| rays[i].t_min),
            t_max: R::from_fn(token, |i| rays[i].t_max),
            time: R::from_fn(token, |i| rays[i].time),
        }
    }
}

/// The bits of ends that exist.
#[inline(always)]
fn end_bits<R: Real>(ends: &RayEnds<R>) -> R::Uint {
    R::Uint::select(ends.is_front, EXISTS, EXISTS | IS_BACK)
}

impl Default for Rays {
    fn default() -> Self {
        Self::with_time(true)
    }
}

impl Rays {
    /// Bytes of a ray, its time and its ends aside.
    pub const BYTES: usize = size_of::<[f32; 8]>();

    /// Bytes of the surface that a ray leaves.
    pub const END_BYTES: usize = size_of::<[f64; 3]>() + size_of::<[f32; 4]>();

    /// None yet; of those that come, time is kept, or is 0 for all, as where nothing moves.
    #[must_use]
    pub fn with_time(is_kept: bool) -> Self {
        Self {
            numbers: Columns::default(),
            times: Column::new(is_kept, 0.0),
            starts: Ends::default(),
            ends: Ends::default(),
        }
    }

    /// How many there are.
    #[inline(always)]
    #[must_use]
    pub fn len(&self) -> usize {
        self.numbers.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }

    /// Takes all out.
    pub fn clear(&mut self) {
        self.numbers.clear();
        self.times.clear();
        self.starts.clear();
        self.ends.clear();
    }

    /// One at the end.
    pub fn push(&mut self, ray: &Ray) {
        let (o, d) = (ray.origin, ray.direction);
        self.numbers.push([o.x, o.y, o.z, d.x, d.y, d.z, ray.t_min, ray.t_max]);
        self.times.push(ray.time);
        self.starts.push(ray.start.as_ref());
        if ray.end.is_some() || !self.ends.numbers.is_empty() {
            while self.ends.numbers.len() + 1 < self.numbers.len() {
                self.ends.push(None);
            }
            self.ends.push(ray.end.as_ref());
        }
    }

    /// At the end, those of the lanes that are set, which leave no surface.
    #[inline(always)]
    pub fn append_from_camera<R: Real>(&mut self, mask: R::Mask, rays: &CameraRays<R>) {
        let CameraRays { origin: o, direction: d, t_min, t_max, time } = *rays;
        self.numbers.append(mask, [o.x, o.y, o.z, d.x, d.y, d.z, t_min, t_max]);
        self.times.append(mask, time);
        let token = mask.token();
        let none = RayEnds::<R> {
            point: vector::Vec3::splat(token, DVec3::ZERO.into()),
            normal: vector::Vec3::splat(token, vector::Vec3::default()),
            is_front: R::Mask::splat(token, true),
        };
        self.starts.append(mask, &none, R::Uint::splat(token, 0));
    }

    /// At the end, those of the lanes that are set.
    #[inline(always)]
    pub fn append<R: Real>(&mut self, mask: R::Mask, rays: &RayLanes<R>) {
        let RayLanes { origin: o, direction: d, t_max, time, ref start, inward } = *rays;
        let t_min = R::splat(mask.token(), 0.0);
        self.numbers.append(mask, [o.x, o.y, o.z, d.x, d.y, d.z, t_min, t_max]);
        self.times.append(mask, time);
        self.starts.append(mask, start, end_bits(start) | inward);
    }

    /// The same for rays that end at surfaces where `has_end` says so.
    #[inline(always)]
    pub fn append_between<R: Real>(
        &mut self,
        mask: R::Mask,
        rays: &RayLanes<R>,
        has_end: R::Mask,
        end: &RayEnds<R>,
    ) {
        self.append(mask, rays);
        self.ends.append(mask, end, R::Uint::select(has_end, end_bits(end), 0));
    }

    /// One of them.
    ///
    /// # Panics
    /// There is no such ray.
    #[inline(always)]
    #[must_use]
    pub fn get(&self, i: usize) -> Ray {
        let [ox, oy, oz, dx, dy, dz, t_min, t_max] = self.numbers.row(i);
        Ray {
            origin: Vec3A::new(ox, oy, oz),
            direction: Vec3A::new(dx, dy, dz),
            t_min,
            t_max,
            time: self.times.row(i),
            start: self.starts.get(i),
            end: self.ends.get(i),
        }
    }

    /// Direction and `t_max` of one of them, and the normals of the surfaces at its ends: less than [`Rays::get`] reads.
    #[cfg(feature = "embree")]
    #[inline(always)]
    pub(crate) fn between(&self, i: usize) -> Between {
        let columns = self.numbers.columns();
        Between {
            direction: Vec3A::new(columns[3][i], columns[4][i], columns[5][i]),
            t_max: columns[7][i],
            start: self.starts.normal(i),
            end: self.ends.normal(i),
            starts_at_edge: self.starts.is_at_edge(i),
        }
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = Ray> {
        (0..self.len()).map(|i| self.get(i))
    }

    /// Origin, direction, `t_min` and `t_max`, each of all rays.
    #[inline(always)]
    #[must_use]
    pub fn columns(&self) -> [&[f32]; 8] {
        self.numbers.columns()
    }

    /// The times of all rays; `None`: 0.
    #[inline(always)]
    #[must_use]
    pub fn times(&self) -> Option<&[f32]> {
        self.times.all()
    }

    /// Of the rays that are named, one for each lane, the surfaces that they leave; of others it means nothing.
    ///
    /// # Panics
    /// There is no such ray.
    #[inline(always)]
    #[must_use]
    pub fn gather_starts<R: Real>(&self, token: R::Token, rays: &[usize]) -> RayEnds<R> {
        let [x, y, z, bits] = self.starts.numbers.gather::<R>(token, rays);
        RayEnds {
            point: self.starts.points.gather::<R::Double>(token, rays).into(),
            normal: vector::Vec3::new(x, y, z),
            is_front: (bits.to_bits() & IS_BACK).eq(0),
        }
    }

    /// Of the rays that are named, one for each lane, the exact origin ([`Ray::exact_origin`]), the direction and the time.
    ///
    /// # Panics
    /// There is no such ray.
    #[inline(always)]
    #[must_use]
    pub fn gather<R: Real>(
        &self,
        token: R::Token,
        rays: &[usize],
    ) -> (vector::Vec3<R::Double>, vector::Vec3<R>, R) {
        let [ox, oy, oz, dx, dy, dz, _, _] = self.numbers.gather::<R>(token, rays);
        let point = self.starts.points.gather::<R::Double>(token, rays).into();
        let [.., bits] = self.starts.numbers.gather::<R>(token, rays);
        let from_surface = !(bits.to_bits() & EXISTS).eq(0);
        let origin = vector::Vec3::new(ox, oy, oz).widen();
        let origin = if from_surface.all() {
            point
        } else {
            vector::Vec3::select(from_surface, point, origin)
        };
        (origin, vector::Vec3::new(dx, dy, dz), self.times.gather(token, rays))
    }
}

impl<'a> FromIterator<&'a Ray> for Rays {
    fn from_iter<I: IntoIterator<Item = &'a Ray>>(all: I) -> Self {
        let mut rays = Self::default();
        all.into_iter().for_each(|ray| rays.push(ray));
        rays
    }
}
