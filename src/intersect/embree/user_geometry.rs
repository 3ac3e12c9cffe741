//! Shapes that are intersected by their own Rust code, as Embree's user geometries.

use std::ffi::c_void;
use std::ptr;
use std::sync::Arc;

use embree_sys::*;

use super::device::Device;
use crate::ray::Ray;
use crate::shape::{Analytic, Geometry, Shape};

/// An analytic shape with the callbacks that answer for it. Boxed, because Embree keeps its address.
#[derive(Debug)]
pub(super) struct UserShape {
    callbacks: ShimUserGeometry,
    shape: Arc<dyn Shape>,
}

impl UserShape {
    pub(super) fn new(shape: Arc<dyn Shape>) -> Box<Self> {
        let callbacks = ShimUserGeometry {
            user: ptr::null(),
            bounds: Some(bounds),
            intersect: Some(intersect),
            occluded: Some(occluded),
        };
        let mut user = Box::new(Self { callbacks, shape });
        user.callbacks.user = (&raw const *user).cast();
        user
    }

    /// A geometry of one primitive. The caller keeps `self` for as long as the scene that it is attached to.
    pub(super) fn geometry(&self, device: &Device) -> RTCGeometry {
        // SAFETY: the device is live.
        let geometry =
            unsafe { rtcNewGeometry(device.handle, RTCGeometryType::RTC_GEOMETRY_TYPE_USER) };
        // SAFETY: the geometry is live and of type USER.
        unsafe { rtcSetGeometryUserPrimitiveCount(geometry, 1) };
        // SAFETY: the callbacks stay at their address, in a box, until the scene is gone (`_user_shapes`).
        unsafe { telamon_set_user_geometry(geometry, &raw const self.callbacks) };
        geometry
    }
}

/// The shape behind a callback's user pointer.
///
/// # Safety
/// `user` points to a live [`UserShape`].
unsafe fn analytic<'a>(user: *const c_void) -> &'a dyn Analytic {
    // SAFETY: the caller's promise.
    let user = unsafe { &*user.cast::<UserShape>() };
    match user.shape.geometry() {
        Geometry::Analytic(analytic) => analytic,
        Geometry::Triangles { .. } => unreachable!("registered for analytic shapes only"),
    }
}

fn from_shim(ray: &ShimRay) -> Ray {
    Ray {
        origin: ray.origin.into(),
        direction: ray.direction.into(),
        t_min: ray.t_min,
        t_max: ray.t_max,
        time: ray.time,
    }
}

unsafe extern "C" fn bounds(user: *const c_void, _: u32, _: u32, out: *mut RTCBounds) {
    // SAFETY: the pointer that was registered, whose box outlives the scene.
    let bounds = unsafe { analytic(user) }.bounds();
    let ([lower_x, lower_y, lower_z], [upper_x, upper_y, upper_z]) =
        (bounds.min.to_array(), bounds.max.to_array());
    let bounds =
        RTCBounds { lower_x, lower_y, lower_z, upper_x, upper_y, upper_z, ..Default::default() };
    // SAFETY: Embree passes room for one box.
    unsafe { out.write(bounds) };
}

unsafe extern "C" fn intersect(
    user: *const c_void,
    _: u32,
    ray: *const ShimRay,
    hit: *mut ShimHit,
) -> bool {
    // SAFETY: the shim passes a ray of its own, valid during the call.
    let ray = from_shim(unsafe { &*ray });
    // SAFETY: as in `bounds`.
    let Some((t, u, v)) = unsafe { analytic(user) }.intersect(&ray) else {
        return false;
    };
    // The normal is rebuilt by the shape; nobody reads this one.
    let found = ShimHit { t, u, v, normal: [0.0, 0.0, 1.0] };
    // SAFETY: the shim passes room for one hit.
    unsafe { hit.write(found) };
    true
}

unsafe extern "C" fn occluded(user: *const c_void, _: u32, ray: *const ShimRay) -> bool {
    // SAFETY: as in `intersect`.
    let ray = from_shim(unsafe { &*ray });
    // SAFETY: as in `bounds`.
    unsafe { analytic(user) }.intersect(&ray).is_some()
}
