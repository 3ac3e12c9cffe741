//! One triangle, traced by single rays and by packets.

use embree_sys::*;

use crate::scene::{SOME, device, ray_at, rays_at, triangle};

#[test]
fn one_triangle_is_hit_and_missed() {
    let scene = triangle(device(c""));

    let RTCRayHit { ray, hit } = scene.intersect1(ray_at(0.25, 0.5));
    assert_eq!((hit.geomID, hit.primID, hit.instID[0]), (0, 0, RTC_INVALID_GEOMETRY_ID));
    // Embree divides by a refined reciprocal, whose last bits differ between processors: its own tests allow 16 roundings.
    for (found, expected) in [(ray.tfar, 2.0), (hit.u, 0.25), (hit.v, 0.5)] {
        let roundings = 16.0 * 0.5 * f32::EPSILON;
        assert!((found / expected - 1.0f32).abs() <= roundings, "{found}, not {expected}");
    }
    assert_eq!((hit.Ng_x, hit.Ng_y, hit.Ng_z.abs()), (0.0, 0.0, 1.0));
    assert!(scene.occluded1(ray_at(0.25, 0.5)));

    assert_eq!(scene.intersect1(ray_at(0.75, 0.75)).hit.geomID, RTC_INVALID_GEOMETRY_ID);
    assert!(!scene.occluded1(ray_at(0.75, 0.75)));
}

#[test]
fn packets_answer_as_single_rays_do_on_the_lanes_asked_for() {
    let scene = triangle(device(c""));
    let x = [0.0, 0.1, 0.2, -0.3, 0.4, 0.5, 0.6, 2.0].map(|x| x + 0.03125);
    for coherent in [false, true] {
        let packet = scene.intersect8(&SOME, rays_at(x), coherent);
        let shadows = scene.occluded8(&SOME, rays_at(x), coherent);
        for lane in 0..8 {
            let single = scene.intersect1(ray_at(x[lane], 0.1));
            let hit = single.hit.geomID == 0 && SOME[lane] == -1;
            assert_eq!(packet.hit.geomID[lane] == 0, hit, "lane {lane}");
            assert_eq!(shadows[lane], hit, "lane {lane}");
            if hit {
                assert!((packet.ray.tfar[lane] - single.ray.tfar).abs() < 1e-6, "lane {lane}");
                assert!((packet.hit.u[lane] - single.hit.u).abs() < 1e-6, "lane {lane}");
                assert!((packet.hit.v[lane] - single.hit.v).abs() < 1e-6, "lane {lane}");
            }
        }
    }
}
