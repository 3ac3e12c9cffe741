//! Ray queries.

use std::mem::offset_of;
use std::slice;

use embree_sys::*;
use glam::{Mat4, Vec4};

use super::Embree;
use super::asked::Asked;
use crate::intersect::spurious::after;
use crate::intersect::{Intersector, for_each_ray};
use crate::ray::{Hit, Ray};
use crate::shape::Geometry;

impl Intersector for Embree {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        if !ray.is_traceable() {
            return None;
        }
        let asked = Asked { engine: self, rays: slice::from_ref(ray) };
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
        let asked = Asked { engine: self, rays: slice::from_ref(ray) };
        let query = asked.query();
        let mut ray = EmbreeRay::new(ray, ray.t_min);
        // SAFETY: as in `nearest`.
        unsafe { telamon_occluded1(self.scene, (&raw mut ray).cast(), &raw const query) };
        ray.t_max == f32::NEG_INFINITY
    }

    /// In packets of eight, unless the modes say otherwise.
    fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        assert_eq!(rays.len(), hits.len(), "one answer for each ray");
        if !self.modes.packets {
            return for_each_ray(rays, hits, |ray| self.closest_hit(ray));
        }
        let (packets, rest) = rays.as_chunks::<LANES>();
        let (slots, rest_of_slots) = hits.as_chunks_mut::<LANES>();
        for (rays, hits) in packets.iter().zip(slots) {
            let asked = Asked { engine: self, rays };
            let shim_query = asked.query();
            let (ray, valid) = packet(rays);
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
            let RTCRayHit8 { ray: end, hit } = query;
            for (lane, (ray, slot)) in rays.iter().zip(hits).enumerate() {
                let numbers = [end.tfar[lane], hit.u[lane], hit.v[lane]];
                let ids = [hit.geomID[lane], hit.primID[lane], hit.instID[0][lane]];
                *slot = self.found(ray, ids, numbers);
                let is_sure = |hit: Hit| {
                    asked.counts(lane, hit.t, hit.shape, hit.primitive) && !self.may_tie(&hit)
                };
                if !slot.is_none_or(is_sure) {
                    *slot = self.closest_hit(ray);
                }
            }
        }
        for_each_ray(rest, rest_of_slots, |ray| self.closest_hit(ray));
    }

    /// Ray by ray: whether a packet is stopped by a triangle whose edge a ray touches depends on its other rays
    /// (1046 of the 2e5 rays of the parity test at `cornell-box`), and nothing tells which rays to ask again.
    fn occluded_many(&self, rays: &[Ray], occluded: &mut [bool]) {
        for_each_ray(rays, occluded, |ray| self.occluded(ray));
    }

    fn bytes(&self) -> usize {
        self.device.bytes() + self.user_shapes.iter().map(|user| user.bytes()).sum::<usize>()
    }

    fn name(&self) -> String {
        format!("Embree {}, {}", RTC_VERSION_STRING.to_string_lossy(), self.modes)
    }
}

impl Embree {
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
        self.found(ray, [hit.geomID, hit.primID, hit.instID[0]], [end.t_max, hit.u, hit.v])
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
    fn found(
        &self,
        ray: &Ray,
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
            self.weigh(ray, &mut hit);
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
        Self {
            origin_and_t_min: ray.origin.extend(t_min),
            direction_and_time: ray.direction.extend(ray.time),
            t_max: end(ray),
            mask: u32::MAX,
            id: 0,
            flags: 0,
        }
    }
}

/// The end of the ray's segment. Finite, because at infinity Embree finds triangles whose test
/// overflows, and −∞ is how it says that a ray is occluded.
fn end(ray: &Ray) -> f32 {
    ray.t_max.clamp(-1.0, f32::MAX)
}

const LANES: usize = 8;

/// What Embree is told of packets, also where it would be true: its walk for coherent rays takes them as one frustum and loses
/// hits on edges, even in robust mode (100 of the 2e5 rays of the parity test at `cornell-box`; the other walk 10, as
/// single rays do).
const COHERENT: bool = false;

/// A mask of eight rays: −1 for those that are traced.
#[repr(align(32))]
struct Lanes([i32; LANES]);

/// Eight rays, and which of them may be traced.
#[inline(always)]
fn packet(rays: &[Ray; LANES]) -> (RTCRay8, Lanes) {
    let [org_x, org_y, org_z, tnear] = transposed(|i| rays[i].origin.extend(rays[i].t_min));
    let [dir_x, dir_y, dir_z, time] = transposed(|i| rays[i].direction.extend(rays[i].time));
    let (mut tfar, mut valid) = ([0.0; LANES], Lanes([0; LANES]));
    for (lane, ray) in rays.iter().enumerate() {
        tfar[lane] = end(ray);
        valid.0[lane] = -i32::from(ray.is_traceable());
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
        tfar,
        mask: [u32::MAX; LANES],
        id: [0, 1, 2, 3, 4, 5, 6, 7],
        flags: [0; LANES],
    };
    (packet, valid)
}

/// The components of eight vectors: of each component all eight.
#[inline(always)]
fn transposed(vector: impl Fn(usize) -> Vec4) -> [[f32; LANES]; 4] {
    let four = |i: usize| {
        Mat4::from_cols(vector(i), vector(i + 1), vector(i + 2), vector(i + 3)).transpose()
    };
    let [low, high] = [four(0), four(4)];
    let mut components = [[0.0; LANES]; 4];
    for (component, all) in components.iter_mut().enumerate() {
        low.col(component).write_to_slice(&mut all[..4]);
        high.col(component).write_to_slice(&mut all[4..]);
    }
    components
}
