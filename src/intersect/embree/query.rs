//! Ray queries.

use embree_sys::*;

use super::Embree;
use crate::intersect::{Intersector, for_each_ray};
use crate::ray::{Hit, Ray};

impl Intersector for Embree {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        if !ray.is_traceable() {
            return None;
        }
        let hit = RTCHit {
            geomID: RTC_INVALID_GEOMETRY_ID,
            primID: RTC_INVALID_GEOMETRY_ID,
            instID: [RTC_INVALID_GEOMETRY_ID],
            ..Default::default()
        };
        let mut query = RTCRayHit { ray: embree_ray(ray), hit };
        // SAFETY: the scene is committed; the query has the type, hence the alignment, asked for, and the
        // ray passed the validation without which Embree's assertions would fail.
        unsafe { telamon_intersect1(self.scene, &raw mut query) };
        let RTCRayHit { ray, hit } = query;
        found(hit.geomID, hit.primID, [ray.tfar, hit.u, hit.v])
    }

    fn occluded(&self, ray: &Ray) -> bool {
        if !ray.is_traceable() {
            return false;
        }
        let mut query = embree_ray(ray);
        // SAFETY: as in `closest_hit`.
        unsafe { telamon_occluded1(self.scene, &raw mut query) };
        query.tfar == f32::NEG_INFINITY
    }

    /// In packets of eight, unless the modes say otherwise.
    fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        assert_eq!(rays.len(), hits.len(), "one answer for each ray");
        if !self.modes.packets {
            return for_each_ray(rays, hits, |ray| self.closest_hit(ray));
        }
        let packets = rays.chunks_exact(LANES).zip(hits.chunks_exact_mut(LANES));
        for (rays, hits) in packets {
            let (ray, valid) = packet(rays);
            let hit = RTCHit8 {
                geomID: [RTC_INVALID_GEOMETRY_ID; LANES],
                primID: [RTC_INVALID_GEOMETRY_ID; LANES],
                instID: [[RTC_INVALID_GEOMETRY_ID; LANES]],
                ..Default::default()
            };
            let mut query = RTCRayHit8 { ray, hit };
            // SAFETY: as in `closest_hit`; `Lanes` aligns the mask as the manual demands, and rays that
            // did not pass the validation are masked out.
            unsafe { telamon_intersect8(valid.0.as_ptr(), self.scene, &raw mut query, false) };
            let RTCRayHit8 { ray, hit } = query;
            for (lane, slot) in hits.iter_mut().enumerate() {
                let numbers = [ray.tfar[lane], hit.u[lane], hit.v[lane]];
                *slot = found(hit.geomID[lane], hit.primID[lane], numbers);
            }
        }
        let rest = rays.len() / LANES * LANES;
        for_each_ray(&rays[rest..], &mut hits[rest..], |ray| self.closest_hit(ray));
    }

    /// In packets of eight, unless the modes say otherwise.
    fn occluded_many(&self, rays: &[Ray], occluded: &mut [bool]) {
        assert_eq!(rays.len(), occluded.len(), "one answer for each ray");
        if !self.modes.packets {
            return for_each_ray(rays, occluded, |ray| self.occluded(ray));
        }
        let packets = rays.chunks_exact(LANES).zip(occluded.chunks_exact_mut(LANES));
        for (rays, occluded) in packets {
            let (mut query, valid) = packet(rays);
            // SAFETY: as in `closest_hits`.
            unsafe { telamon_occluded8(valid.0.as_ptr(), self.scene, &raw mut query, false) };
            for (t, slot) in query.tfar.iter().zip(occluded) {
                *slot = *t == f32::NEG_INFINITY;
            }
        }
        let rest = rays.len() / LANES * LANES;
        for_each_ray(&rays[rest..], &mut occluded[rest..], |ray| self.occluded(ray));
    }

    fn bytes(&self) -> usize {
        self.device.bytes()
    }

    fn name(&self) -> String {
        format!("Embree {}, {}", RTC_VERSION_STRING.to_string_lossy(), self.modes)
    }
}

/// What a query found. Embree reports t = ∞ or NaN for triangles whose test leaves the range of f32.
fn found(shape: u32, primitive: u32, [t, u, v]: [f32; 3]) -> Option<Hit> {
    (shape != RTC_INVALID_GEOMETRY_ID && t.is_finite()).then_some(Hit { t, u, v, shape, primitive })
}

fn embree_ray(ray: &Ray) -> RTCRay {
    let ([org_x, org_y, org_z], [dir_x, dir_y, dir_z]) =
        (ray.origin.to_array(), ray.direction.to_array());
    RTCRay {
        org_x,
        org_y,
        org_z,
        tnear: ray.t_min,
        dir_x,
        dir_y,
        dir_z,
        time: ray.time,
        tfar: ray.t_max,
        mask: u32::MAX,
        ..Default::default()
    }
}

const LANES: usize = 8;

/// A mask of eight rays: −1 for those that are traced.
#[repr(align(32))]
struct Lanes([i32; LANES]);

/// Eight rays, and which of them may be traced.
fn packet(rays: &[Ray]) -> (RTCRay8, Lanes) {
    let mut packet = RTCRay8 { mask: [u32::MAX; LANES], ..Default::default() };
    let mut valid = Lanes([0; LANES]);
    for (lane, ray) in rays.iter().enumerate() {
        [packet.org_x[lane], packet.org_y[lane], packet.org_z[lane]] = ray.origin.to_array();
        [packet.dir_x[lane], packet.dir_y[lane], packet.dir_z[lane]] = ray.direction.to_array();
        packet.tnear[lane] = ray.t_min;
        packet.tfar[lane] = ray.t_max;
        packet.time[lane] = ray.time;
        valid.0[lane] = -i32::from(ray.is_traceable());
    }
    (packet, valid)
}
