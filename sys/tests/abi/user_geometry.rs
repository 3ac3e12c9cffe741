//! A user geometry: unit spheres around (4i, 0, 0). `user` points to their radius.

use std::ffi::c_void;

use embree_sys::*;

use crate::scene::{SOME, Scene, device, geometry, ray_at, rays_at};

fn nearest(radius: f32, primitive: u32, ray: &ShimRay) -> Option<f32> {
    let x = ray.origin[0] - 4.0 * primitive as f32;
    let [_, y, z] = ray.origin;
    let [dx, dy, dz] = ray.direction;
    let a = dx * dx + dy * dy + dz * dz;
    let b = x * dx + y * dy + z * dz;
    let c = x * x + y * y + z * z - radius * radius;
    let root = (b * b - a * c).sqrt(); // NaN for a miss, which no range contains
    [(-b - root) / a, (-b + root) / a].into_iter().find(|t| (ray.t_min..=ray.t_max).contains(t))
}

unsafe extern "C" fn bounds(user: *const c_void, primitive: u32, _: u32, out: *mut RTCBounds) {
    // SAFETY: `user` is the radius that the geometry was given.
    let radius = unsafe { *user.cast::<f32>() };
    let x = 4.0 * primitive as f32;
    let bounds = RTCBounds {
        lower_x: x - radius,
        lower_y: -radius,
        lower_z: -radius,
        upper_x: x + radius,
        upper_y: radius,
        upper_z: radius,
        ..Default::default()
    };
    // SAFETY: Embree passes room for one box.
    unsafe { out.write(bounds) };
}

unsafe extern "C" fn intersect(
    user: *const c_void,
    primitive: u32,
    ray: *const ShimRay,
    hit: *mut ShimHit,
) -> bool {
    // SAFETY: `user` is the radius that the geometry was given.
    let radius = unsafe { *user.cast::<f32>() };
    // SAFETY: the shim passes a ray of its own, valid during the call.
    let ray = unsafe { &*ray };
    let Some(t) = nearest(radius, primitive, ray) else {
        return false;
    };
    let mut normal: [f32; 3] = std::array::from_fn(|i| ray.origin[i] + t * ray.direction[i]);
    normal[0] -= 4.0 * primitive as f32;
    let (u, v) = (0.25, 0.75);
    // SAFETY: the shim passes room for one hit.
    unsafe { hit.write(ShimHit { t, u, v, normal, primitive, instance: RTC_INVALID_GEOMETRY_ID }) };
    true
}

unsafe extern "C" fn occluded(user: *const c_void, primitive: u32, ray: *const ShimRay) -> bool {
    // SAFETY: `user` is the radius that the geometry was given.
    let radius = unsafe { *user.cast::<f32>() };
    // SAFETY: the shim passes a ray of its own, valid during the call.
    nearest(radius, primitive, unsafe { &*ray }).is_some()
}

static RADIUS: f32 = 1.0;

/// Shared by reference with threads that Embree starts; it holds nothing that changes.
struct Callbacks(ShimUserGeometry);
// SAFETY: the pointer inside is to `RADIUS`, which is never written.
unsafe impl Sync for Callbacks {}

static CALLBACKS: Callbacks = Callbacks(ShimUserGeometry {
    user: (&raw const RADIUS).cast(),
    bounds: Some(bounds),
    intersect: Some(intersect),
    occluded: Some(occluded),
});

fn two_spheres(device: RTCDevice) -> Scene {
    let shape = geometry(device, RTCGeometryType::RTC_GEOMETRY_TYPE_USER);
    // SAFETY: the geometry is live and of type USER.
    unsafe { rtcSetGeometryUserPrimitiveCount(shape, 2) };
    // SAFETY: likewise; the callbacks are static.
    unsafe { telamon_set_user_geometry(shape, &raw const CALLBACKS.0) };
    Scene::new(device, shape)
}

#[test]
fn user_geometry_is_traced_one_ray_at_a_time() {
    let scene = two_spheres(device(c""));

    let RTCRayHit { ray, hit } = scene.intersect1(ray_at(4.0, 0.0));
    assert_eq!((hit.geomID, hit.primID, hit.instID[0]), (0, 1, RTC_INVALID_GEOMETRY_ID));
    assert_eq!((ray.tfar, hit.u, hit.v), (1.0, 0.25, 0.75));
    assert_eq!((hit.Ng_x, hit.Ng_y, hit.Ng_z), (0.0, 0.0, -1.0));
    assert!(scene.occluded1(ray_at(4.0, 0.0)));

    // From inside the first sphere, and up to just before its far side.
    let inside = RTCRay { tnear: 2.0, ..ray_at(0.0, 0.0) };
    assert_eq!(scene.intersect1(inside).ray.tfar, 3.0);
    let short = RTCRay { tfar: 2.5, ..inside };
    assert_eq!(scene.intersect1(short).hit.geomID, RTC_INVALID_GEOMETRY_ID);
    assert!(!scene.occluded1(short));

    assert_eq!(scene.intersect1(ray_at(2.0, 0.0)).hit.geomID, RTC_INVALID_GEOMETRY_ID);
    assert!(!scene.occluded1(ray_at(2.0, 0.0)));
}

#[test]
fn user_geometry_is_traced_in_packets_on_the_lanes_asked_for() {
    let scene = two_spheres(device(c""));
    let x = [0.0, 0.5, 4.5, 2.0, 4.0, -0.5, 3.5, 9.0];
    for valid in [SOME, SOME.map(|lane| -1 - lane), [-1; 8]] {
        let packet = scene.intersect8(&valid, rays_at(x), false);
        let shadows = scene.occluded8(&valid, rays_at(x), false);
        for lane in 0..8 {
            let single = scene.intersect1(ray_at(x[lane], 0.1));
            let hit = single.hit.geomID == 0 && valid[lane] == -1;
            assert_eq!(packet.hit.geomID[lane] == 0, hit, "lane {lane}");
            assert_eq!(shadows[lane], hit, "lane {lane}");
            if hit {
                let RTCRayHit8 { ray, hit } = &packet;
                assert_eq!(ray.tfar[lane], single.ray.tfar, "lane {lane}");
                assert_eq!(hit.primID[lane], single.hit.primID, "lane {lane}");
                assert_eq!(hit.Ng_x[lane], single.hit.Ng_x, "lane {lane}");
                assert_eq!(hit.Ng_z[lane], single.hit.Ng_z, "lane {lane}");
                assert_eq!((hit.u[lane], hit.v[lane]), (0.25, 0.75), "lane {lane}");
            } else {
                assert_eq!(packet.ray.tfar[lane], f32::INFINITY, "lane {lane}");
            }
        }
    }
}

#[test]
fn user_geometry_knows_the_instance_that_it_is_hit_in() {
    let inner = two_spheres(device(c""));
    let instance = geometry(inner.device, RTCGeometryType::RTC_GEOMETRY_TYPE_INSTANCE);
    // SAFETY: both handles are live and of one device; the instance takes a reference.
    unsafe { rtcSetGeometryInstancedScene(instance, inner.scene) };
    // Twice as large, so that directions in the spheres' space are not unit vectors.
    let twice: [f32; 12] = [2.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0];
    let format = RTCFormat::RTC_FORMAT_FLOAT3X4_ROW_MAJOR;
    // SAFETY: the instance is live, and the format says what `twice` holds.
    unsafe { rtcSetGeometryTransform(instance, 0, format, twice.as_ptr().cast()) };
    // SAFETY: the device is live; the outer scene releases this reference.
    unsafe { rtcRetainDevice(inner.device) };
    let outer = Scene::new(inner.device, instance);

    let RTCRayHit { ray, hit } = outer.intersect1(RTCRay { org_z: -5.0, ..ray_at(8.0, 0.0) });
    assert_eq!((hit.geomID, hit.primID, hit.instID[0]), (0, 1, 0));
    assert_eq!(ray.tfar, 3.0);
    assert!(outer.occluded1(RTCRay { org_z: -5.0, ..ray_at(8.0, 0.0) }));
    let packet = outer.intersect8(&SOME, rays_at([9.5; 8]), true);
    assert_eq!(packet.hit.instID[0], SOME.map(|lane| if lane == -1 { 0 } else { u32::MAX }));
}
