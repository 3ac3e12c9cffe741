//! Occlusion queries ask of each hit whether it counts, and go on past those that do not.

use std::ffi::c_void;
use std::sync::Mutex;

use embree_sys::*;

use crate::scene::{Mask, SOME, Scene, device, no_hit, ray_at, rays_at, triangle_geometry};

/// What a query's hits are asked of.
struct Asked {
    /// The ray whose hits do not count.
    refused: u32,
    /// Ray, geometry, primitive and distance of each hit.
    hits: Mutex<Vec<(u32, u32, u32, f32)>>,
}

impl Asked {
    fn refusing(ray: u32) -> Self {
        Self { refused: ray, hits: Mutex::default() }
    }

    fn query(&self) -> ShimQuery {
        ShimQuery { user: (&raw const *self).cast(), accept: Some(accept) }
    }

    /// The rays whose hits were asked of, in order; each met the triangle at its distance of 2.
    fn rays(self) -> Vec<u32> {
        let mut hits = self.hits.into_inner().expect("no test has panicked in it");
        hits.sort_by_key(|hit| hit.0);
        for &(ray, geometry, primitive, t) in &hits {
            assert_eq!((geometry, primitive), (0, 0), "ray {ray}");
            // 16 roundings, as of the hits themselves.
            assert!((t / 2.0 - 1.0).abs() <= 16.0 * 0.5 * f32::EPSILON, "ray {ray}: {t}");
        }
        hits.into_iter().map(|hit| hit.0).collect()
    }
}

unsafe extern "C" fn accept(
    user: *const c_void,
    ray: u32,
    geometry: u32,
    primitive: u32,
    t: f32,
) -> bool {
    // SAFETY: the shim passes the pointer of `Asked::query`, and the test keeps that until the query has ended.
    let asked = unsafe { &*user.cast::<Asked>() };
    // Nothing may unwind into C.
    if let Ok(mut hits) = asked.hits.lock() {
        hits.push((ray, geometry, primitive, t));
    }
    ray != asked.refused
}

fn filtered_triangle() -> Scene {
    let device = device(c"");
    let geometry = triangle_geometry(device);
    // SAFETY: the geometry is live, and no scene has it yet.
    unsafe { telamon_filter_occlusion(geometry) };
    Scene::new(device, geometry)
}

#[test]
fn a_single_ray_is_stopped_by_hits_that_count() {
    let scene = filtered_triangle();
    for (id, x, asks, stopped) in
        [(7, 0.25, true, false), (8, 0.25, true, true), (8, 3.0, false, false)]
    {
        let asked = Asked::refusing(7);
        let mut ray = RTCRay { id, ..ray_at(x, 0.5) };
        // SAFETY: the scene is committed, the ray is aligned by its type, and `asked` outlives the query.
        unsafe { telamon_occluded1(scene.scene, &raw mut ray, &asked.query()) };
        assert_eq!(ray.tfar == f32::NEG_INFINITY, stopped, "ray {id} at {x}");
        assert_eq!(asked.rays(), if asks { vec![id] } else { vec![] });
    }
}

#[test]
fn without_a_query_all_hits_count() {
    let scene = filtered_triangle();
    assert!(scene.occluded1(ray_at(0.25, 0.5)));
    assert_eq!(scene.occluded8(&SOME, rays_at([0.25; 8]), false), SOME.map(|lane| lane == -1));
}

#[test]
fn closest_hits_are_not_asked_of() {
    let scene = filtered_triangle();
    let asked = Asked::refusing(0);
    let mut rayhit = RTCRayHit { ray: ray_at(0.25, 0.5), hit: no_hit() };
    // SAFETY: as in `a_single_ray_is_stopped_by_hits_that_count`.
    unsafe { telamon_intersect1(scene.scene, &raw mut rayhit, &asked.query()) };
    assert_eq!((rayhit.hit.geomID, asked.rays()), (0, vec![]));
}

#[test]
fn each_lane_of_a_packet_is_asked_of_by_its_own_id() {
    let scene = filtered_triangle();
    let x = [0.25, 0.25, 0.5, 3.0, 0.25, 0.125, 0.25, 0.25];
    let id = [10, 11, 12, 13, 14, 15, 16, 17];
    for coherent in [false, true] {
        let asked = Asked::refusing(12);
        let mut rays = RTCRay8 { id, ..rays_at(x) };
        let valid = Mask(SOME);
        // SAFETY: as above; `Mask` aligns the eight lanes as the manual demands.
        unsafe {
            telamon_occluded8(
                valid.0.as_ptr(),
                scene.scene,
                &raw mut rays,
                coherent,
                &asked.query(),
            );
        };
        let stopped = rays.tfar.map(|t| t == f32::NEG_INFINITY);
        // Lanes 1, 4, 6 and 7 are off, lane 2 is refused, lane 3 misses.
        assert_eq!(stopped, [true, false, false, false, false, true, false, false]);
        assert_eq!(asked.rays(), [10, 12, 15]);
    }
}
