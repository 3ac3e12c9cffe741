//! Shapes that are intersected by their own Rust code, as Embree's user geometries.
//!
//! Instances are among them: Embree's own would transform rays in f32, by a matrix that it inverts in f32,
//! and so see other rays than the Rust engine does; far from the origin they lose the instance.

use std::ffi::c_void;
use std::ptr;
use std::sync::Arc;

use embree_sys::*;

use super::Embree;
use super::asked::Asked;
use super::device::Device;
use crate::intersect::Intersector;
use crate::intersect::bvh::MovingTree;
use crate::intersect::spurious::{Doubt, intersect_analytic};
use crate::ray::{Hit, Ray};
use crate::shape::{Geometry, Shape};

/// A shape with the callbacks that answer for it. Boxed, because Embree keeps its address.
#[derive(Debug)]
pub(super) struct UserShape {
    callbacks: ShimUserGeometry,
    shape: Arc<dyn Shape>,
    /// The scene of an instance's group.
    group: Option<Arc<Embree>>,
    /// The tree of a mesh that deforms.
    moving: Option<MovingTree>,
}

impl UserShape {
    pub(super) fn new(shape: Arc<dyn Shape>, group: Option<Arc<Embree>>) -> Box<Self> {
        let callbacks = ShimUserGeometry {
            user: ptr::null(),
            bounds: Some(bounds),
            intersect: Some(intersect),
            occluded: Some(occluded),
        };
        let moving = MovingTree::new(&shape);
        let mut user = Box::new(Self { callbacks, shape, group, moving });
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
        // SAFETY: the callbacks stay at their address, in a box, until the scene is gone (`user_shapes`).
        unsafe { telamon_set_user_geometry(geometry, &raw const self.callbacks) };
        geometry
    }
}

impl UserShape {
    /// Bytes of the tree of a mesh that deforms.
    pub(super) fn bytes(&self) -> usize {
        self.moving.as_ref().map_or(0, MovingTree::bytes)
    }

    /// The nearest hit within the ray's segment, as a hit of the only shape.
    fn closest_hit(&self, ray: &Ray, doubt: Doubt) -> Option<Hit> {
        match (self.shape.geometry(), &self.group) {
            (Geometry::Analytic(analytic), _) => {
                let (t, u, v) = intersect_analytic(ray, analytic, doubt)?;
                Some(Hit { t, u, v, shape: 0, primitive: 0, member: 0 })
            }
            (Geometry::Deforming(_), _) => self.moving.as_ref()?.hit::<false>(ray, doubt),
            (Geometry::Instance(instance), Some(group)) => {
                instance.nearest(ray, |local| group.closest_hit(local))
            }
            _ => None,
        }
    }

    /// Whether anything lies within the ray's segment.
    fn occluded(&self, ray: &Ray, doubt: Doubt) -> bool {
        match (self.shape.geometry(), &self.group) {
            (Geometry::Analytic(analytic), _) => intersect_analytic(ray, analytic, doubt).is_some(),
            (Geometry::Deforming(_), _) => {
                self.moving.as_ref().is_some_and(|tree| tree.hit::<true>(ray, doubt).is_some())
            }
            (Geometry::Instance(instance), Some(group)) => group.occluded(&instance.local(ray).ray),
            _ => false,
        }
    }
}

/// The shape behind a callback's user pointer.
///
/// # Safety
/// `user` points to a live [`UserShape`].
unsafe fn user_shape<'a>(user: *const c_void) -> &'a UserShape {
    // SAFETY: the caller's promise.
    unsafe { &*user.cast::<UserShape>() }
}

/// The ray that was asked about, up to what was found so far.
///
/// # Safety
/// `ray` is the shim's, during a query of [`Embree`].
unsafe fn asked(ray: *const ShimRay) -> (Ray, Doubt) {
    // SAFETY: the shim passes a ray of its own, valid during the call.
    let ShimRay { t_min, t_max, id, user, .. } = unsafe { *ray };
    // SAFETY: every query comes with what was asked.
    let asked = unsafe { Asked::from_user(user) };
    (Ray { t_min, t_max, ..asked.ray(id as usize) }, asked.doubt(id as usize))
}

unsafe extern "C" fn bounds(user: *const c_void, _: u32, _: u32, out: *mut RTCBounds) {
    // SAFETY: the pointer that was registered, whose box outlives the scene.
    let bounds = unsafe { user_shape(user) }.shape.bounds();
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
    // SAFETY: called by the shim in a query.
    let (ray, doubt) = unsafe { asked(ray) };
    // SAFETY: as in `bounds`.
    let Some(found) = unsafe { user_shape(user) }.closest_hit(&ray, doubt) else {
        return false;
    };
    // The normal is rebuilt by the shape; nobody reads this one.
    let Hit { t, u, v, primitive, member, .. } = found;
    let found = ShimHit { t, u, v, normal: [0.0, 0.0, 1.0], primitive, instance: member };
    // SAFETY: the shim passes room for one hit.
    unsafe { hit.write(found) };
    true
}

unsafe extern "C" fn occluded(user: *const c_void, _: u32, ray: *const ShimRay) -> bool {
    // SAFETY: as in `intersect`.
    let (ray, doubt) = unsafe { asked(ray) };
    // SAFETY: as in `bounds`.
    unsafe { user_shape(user) }.occluded(&ray, doubt)
}
