//! Ray queries.

use std::mem::offset_of;

use embree_sys::*;
use glam::{Vec3A, Vec4};

use super::Embree;
use super::asked::{Asked, AskedRays};
use crate::intersect::spurious::after;
use crate::intersect::{Intersector, for_each_ray};
use crate::ray::{Hit, Ray, Rays, is_traceable};
use crate::shape::Geometry;

impl Intersector for Embree {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        if !ray.is_traceable() {
            return None;
        }
        let asked = Asked { engine: self, rays: AskedRays::One(ray) };
        let mut t_min = ray.t_min;
        loop {
            let hit = self.nearest(&asked, ray, t_min)?;
            if asked.counts(0, hit.t, hit.shape, hit.primitive) {
                return Some(hit);
            }
            t_min = after(hit.t);
        }
    }

    fn occluded(&self, ray: &Ray) -> bool {
        if !ray.is_traceable() {
            return false;
        }
        self.is_stopped(EmbreeRay::new(ray, ray.t_min), AskedRays::One(ray))
    }

    /// In packets of eight, unless the modes say otherwise.
    fn closest_hits(&self, rays: &Rays, hits: &mut [Option<Hit>]) {
        assert_eq!(rays.len(), hits.len(), "one answer for each ray");
        if !self.modes.packets {
            return for_each_ray(rays, hits, |ray| self.closest_hit(ray));
        }
        for (packet, hits) in hits.chunks_mut(LANES).enumerate() {
            let first = packet * LANES;
            let asked = Asked { engine: self, rays: AskedRays::Packet { rays, first } };
            let shim_query = asked.query();
            let (ray, valid) = rtc_rays(rays, first, hits.len());
            let hit = RTCHit8 {
                geomID: [RTC_INVALID_GEOMETRY_ID; LANES],
                primID: [RTC_INVALID_GEOMETRY_ID; LANES],
                instID: [[RTC_INVALID_GEOMETRY_ID; LANES]],
                ..Default::default()
            };
            let mut query = RTCRayHit8 { ray, hit };
            let mask = valid.0.as_ptr();
            // SAFETY: as in `nearest`; `Lanes` aligns the mask as the manual demands, and rays that
            // did not pass the validation are masked out.
            unsafe {
                telamon_intersect8(
                    mask,
                    self.scene,
                    &raw mut query,
                    COHERENT,
                    &raw const shim_query,
                );
            }
            let RTCRayHit8 { ray: end, hit } = &query;
            for (lane, slot) in hits.iter_mut().enumerate() {
                let ids = [hit.geomID[lane], hit.primID[lane], hit.instID[0][lane]];
                let numbers = [end.tfar[lane], hit.u[lane], hit.v[lane]];
                let ray = || rays.get(first + lane);
                *slot = self.found(ray, ids, numbers);
                let is_sure = |hit: Hit| {
                    asked.counts(lane, hit.t, hit.shape, hit.primitive) && !self.may_tie(&hit)
                };
                if !slot.is_none_or(is_sure) {
                    *slot = self.closest_hit(&ray());
                }
            }
        }
    }

    /// Ray by ray: whether a packet is stopped by a triangle whose edge a ray touches depends on its other rays
    /// (1046 of the 2e5 rays of the parity test at `cornell-box`), and nothing tells which rays to ask again.
    fn occluded_many(&self, rays: &Rays, occluded: &mut [bool]) {
        assert_eq!(rays.len(), occluded.len(), "one answer for each ray");
        let [ox, oy, oz, dx, dy, dz, t_min, t_max] = rays.columns();
        let times = rays.times();
        for (i, occluded) in occluded.iter_mut().enumerate() {
            let (origin, direction) =
                (Vec3A::new(ox[i], oy[i], oz[i]), Vec3A::new(dx[i], dy[i], dz[i]));
            let [t_min, t_max, time] = [t_min[i], t_max[i], times.map_or(0.0, |times| times[i])];
            *occluded = is_traceable(origin, direction, [t_min, t_max, time]) && {
                let ray = EmbreeRay::of(origin.extend(t_min), direction.extend(time), t_max);
                self.is_stopped(ray, AskedRays::Packet { rays, first: i })
            };
        }
    }

    fn bytes(&self) -> usize {
        self.device.bytes() + self.user_shapes.iter().map(|user| user.bytes()).sum::<usize>()
    }

    fn name(&self) -> String {
        format!("Embree {}, {}", RTC_VERSION_STRING.to_string_lossy(), self.modes)
    }
}

impl Embree {
    /// Whether anything lies within the segment of a traceable ray, the first of those that are asked about.
    #[inline(always)]
    fn is_stopped(&self, mut ray: EmbreeRay, rays: AskedRays<'_>) -> bool {
        let asked = Asked { engine: self, rays };
        let query = asked.query();
        // SAFETY: as in `nearest`.
        unsafe { telamon_occluded1(self.scene, (&raw mut ray).cast(), &raw const query) };
        ray.t_max == f32::NEG_INFINITY
    }

    /// The nearest hit of a traceable ray from `t_min` on, whether the ray truly has it or not.
    #[inline(always)]
    fn nearest(&self, asked: &Asked<'_>, ray: &Ray, t_min: f32) -> Option<Hit> {
        let hit = RTCHit {
            geomID: RTC_INVALID_GEOMETRY_ID,
            primID: RTC_INVALID_GEOMETRY_ID,
            instID: [RTC_INVALID_GEOMETRY_ID],
            ..Default::default()
        };
        let shim_query = asked.query();
        let mut query = Query { ray: EmbreeRay::new(ray, t_min), hit };
        let ray_hit = (&raw mut query).cast();
        // SAFETY: the scene is committed; the query has the layout and the alignment asked for (asserted
        // below), the ray passed the validation without which Embree's assertions would fail, and what the callbacks
        // are given lives until the call returns.
        unsafe { telamon_intersect1(self.scene, ray_hit, &raw const shim_query) };
        let Query { ray: end, hit } = query;
        self.found(|| *ray, [hit.geomID, hit.primID, hit.instID[0]], [end.t_max, hit.u, hit.v])
    }

    /// Whether a hit lies on an edge of its triangle. There the neighbour is met at the same distance, and which of both
    /// a packet finds first depends on its other rays.
    #[inline(always)]
    fn may_tie(&self, hit: &Hit) -> bool {
        let least = hit.u.min(hit.v).min(1.0 - hit.u - hit.v);
        least <= f32::EPSILON && self.is_of_triangles(hit.shape)
    }

    #[cold]
    fn is_of_triangles(&self, shape: u32) -> bool {
        matches!(self.shapes[shape as usize].geometry(), Geometry::Triangles { .. })
    }

    /// What a query found. Embree's own instances are not used: their place in a hit holds the member of ours,
    /// or nothing.
    #[inline(always)]
    fn found(
        &self,
        ray: impl FnOnce() -> Ray,
        [shape, primitive, member]: [u32; 3],
        [t, u, v]: [f32; 3],
    ) -> Option<Hit> {
        // NaN is what the fast mode reports for triangles whose test leaves the range of f32.
        if shape == RTC_INVALID_GEOMETRY_ID || !t.is_finite() {
            return None;
        }
        let member = if member == RTC_INVALID_GEOMETRY_ID { 0 } else { member };
        let mut hit = Hit { t, u, v, shape, primitive, member };
        // One comparison for both; neither is below 0 by more than a rounding.
        if u + v == 0.0 {
            self.weigh(&ray(), &mut hit);
        }
        Some(hit)
    }

    /// Puts the right weights in the place of zeros. Embree divides by the determinant, twice the area
    /// seen along the ray, only above 1e-18 and reports zeros for all smaller triangles: a mesh of
    /// a million on a sphere of radius 1e-6 would consist of its vertices.
    #[cold]
    fn weigh(&self, ray: &Ray, hit: &mut Hit) {
        let Geometry::Triangles { positions, triangles } =
            self.shapes[hit.shape as usize].geometry()
        else {
            return;
        };
        let corners = triangles[hit.primitive as usize].map(|i| positions[i as usize]);
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        // Möller and Trumbore (1997) in f64, for the weights alone.
        let (edge_1, edge_2) = (b - a, c - a);
        let direction = ray.direction.as_dvec3();
        let to_origin = ray.origin.as_dvec3() - a;
        let p = direction.cross(edge_2);
        let determinant = edge_1.dot(p);
        let weights = [to_origin.dot(p), direction.dot(to_origin.cross(edge_1))];
        let [u, v] = weights.map(|w| (w / determinant).clamp(0.0, 1.0));
        if u.is_finite() && v.is_finite() {
            (hit.u, hit.v) = (u as f32, v as f32);
        }
    }
}

/// An [`RTCRay`] in whole vectors. Embree reads it so, and a load that spans several small stores has to
/// wait until they have left the processor's store buffer.
#[repr(C, align(16))]
struct EmbreeRay {
    origin_and_t_min: Vec4,
    direction_and_time: Vec4,
    t_max: f32,
    mask: u32,
    id: u32,
    flags: u32,
}

/// An [`RTCRayHit`].
#[repr(C)]
struct Query {
    ray: EmbreeRay,
    hit: RTCHit,
}

const _: () = {
    assert!(size_of::<EmbreeRay>() == size_of::<RTCRay>());
    assert!(align_of::<EmbreeRay>() >= align_of::<RTCRay>());
    assert!(offset_of!(EmbreeRay, origin_and_t_min) == offset_of!(RTCRay, org_x));
    assert!(offset_of!(RTCRay, tnear) == offset_of!(RTCRay, org_x) + 12);
    assert!(offset_of!(EmbreeRay, direction_and_time) == offset_of!(RTCRay, dir_x));
    assert!(offset_of!(RTCRay, time) == offset_of!(RTCRay, dir_x) + 12);
    assert!(offset_of!(EmbreeRay, t_max) == offset_of!(RTCRay, tfar));
    assert!(offset_of!(EmbreeRay, mask) == offset_of!(RTCRay, mask));
    assert!(size_of::<Query>() == size_of::<RTCRayHit>());
    assert!(offset_of!(Query, hit) == offset_of!(RTCRayHit, hit));
};

impl EmbreeRay {
    fn new(ray: &Ray, t_min: f32) -> Self {
        Self::of(ray.origin.extend(t_min), ray.direction.extend(ray.time), ray.t_max)
    }

    fn of(origin_and_t_min: Vec4, direction_and_time: Vec4, t_max: f32) -> Self {
        Self {
            origin_and_t_min,
            direction_and_time,
            t_max: end(t_max),
            mask: u32::MAX,
            id: 0,
            flags: 0,
        }
    }
}

/// The end of the ray's segment. Finite, because at infinity Embree finds triangles whose test
/// overflows, and −∞ is how it says that a ray is occluded.
fn end(t_max: f32) -> f32 {
    t_max.clamp(-1.0, f32::MAX)
}

const LANES: usize = 8;

/// What Embree is told of packets, also where it would be true: its walk for coherent rays takes them as one frustum and loses
/// hits on edges, even in robust mode (100 of the 2e5 rays of the parity test at `cornell-box`; the other walk 10, as
/// single rays do).
const COHERENT: bool = false;

/// A mask of eight rays: −1 for those that are traced.
#[repr(align(32))]
struct Lanes([i32; LANES]);

/// The rays from `first` on, and which of them may be traced; at most `count`.
#[inline(always)]
fn rtc_rays(rays: &Rays, first: usize, count: usize) -> (RTCRay8, Lanes) {
    let eight = |column: &[f32]| match column[first..].first_chunk() {
        Some(numbers) => *numbers,
        None => {
            let mut numbers = [0.0; LANES];
            numbers[..count].copy_from_slice(&column[first..first + count]);
            numbers
        }
    };
    let [org_x, org_y, org_z, dir_x, dir_y, dir_z, tnear, t_max] = rays.columns().map(eight);
    let time = rays.times().map_or([0.0; LANES], eight);
    let mut valid = Lanes([0; LANES]);
    for (lane, valid) in valid.0.iter_mut().enumerate() {
        let origin = Vec3A::new(org_x[lane], org_y[lane], org_z[lane]);
        let direction = Vec3A::new(dir_x[lane], dir_y[lane], dir_z[lane]);
        let segment = [tnear[lane], t_max[lane], time[lane]];
        *valid = -i32::from(lane < count && is_traceable(origin, direction, segment));
    }
    let packet = RTCRay8 {
        org_x,
        org_y,
        org_z,
        tnear,
        dir_x,
        dir_y,
        dir_z,
        time,
        tfar: t_max.map(end),
        mask: [u32::MAX; LANES],
        id: [0, 1, 2, 3, 4, 5, 6, 7],
        flags: [0; LANES],
    };
    (packet, valid)
}
