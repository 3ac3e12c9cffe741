//! Debian's Embree as an engine.
//!
//! All `unsafe` of this crate is here; it leans on three facts. The handles are live from their creation
//! to [`Drop`], since nothing else can reach them. The buffers that Embree reads belong to shapes that
//! are held in an `Arc` for as long as the scene, and a shape behind an `Arc` does not change. Queries are
//! only possible on a committed scene: it is committed before [`Embree`] exists.

#![allow(unsafe_code, reason = "the only way to call Embree; each block says why it is sound")]

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr;
use std::sync::atomic::{AtomicIsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use embree_sys::*;

use super::{BuildError, Intersector, for_each_ray};
use crate::ray::{Hit, Ray};
use crate::shape::{Analytic, Geometry, Shape};

/// A committed Embree scene in robust mode, with all that it refers to.
///
/// Fast mode, which Embree would default to, loses up to half of all hits far from the origin.
#[derive(Debug)]
pub struct Embree {
    scene: RTCScene,
    device: Device,
    /// Read by Embree through the pointers that it was given.
    _shapes: Vec<Arc<dyn Shape>>,
    #[expect(clippy::vec_box, reason = "Embree keeps the address of each, and the list grows")]
    _user_shapes: Vec<Box<UserShape>>,
}

// SAFETY: the manual says of a committed scene: "Multiple threads are allowed to trace rays against it"
// (rtcCommitScene: "any ray query may be performed in parallel"), and handles may be used and released
// from any thread. Nothing else is reachable through `&Embree`; the state that Embree's callbacks
// write is atomic or behind a mutex.
unsafe impl Send for Embree {}
// SAFETY: as above.
unsafe impl Sync for Embree {}

#[derive(Debug)]
struct Device {
    handle: RTCDevice,
    /// Boxed, because Embree keeps its address.
    state: Box<DeviceState>,
}

/// What Embree reports through callbacks, from any thread.
#[derive(Debug, Default)]
struct DeviceState {
    bytes: AtomicIsize,
    first_error: Mutex<Option<String>>,
}

/// An analytic shape with the callbacks that answer for it. Boxed, because Embree keeps its address.
#[derive(Debug)]
struct UserShape {
    callbacks: ShimUserGeometry,
    shape: Arc<dyn Shape>,
}

impl Embree {
    /// Builds over `shapes`, with as many threads as the current thread pool has.
    ///
    /// # Errors
    /// What Embree says of it, such as that memory has run out.
    pub fn new(shapes: &[Arc<dyn Shape>]) -> Result<Self, BuildError> {
        let device = Device::new()?;
        // SAFETY: the device is live.
        let scene = unsafe { rtcNewScene(device.handle) };
        let mut embree = Self { scene, device, _shapes: shapes.to_vec(), _user_shapes: Vec::new() };
        embree.device.check()?;
        // SAFETY: the scene is live and not yet committed.
        unsafe { rtcSetSceneFlags(scene, RTCSceneFlags::RTC_SCENE_FLAG_ROBUST) };
        for (shape, id) in shapes.iter().zip(0..) {
            match shape.geometry() {
                // Embree has nothing to read in an empty buffer, and may not get its address.
                Geometry::Triangles { triangles: [], .. } => {}
                Geometry::Triangles { positions, triangles } => {
                    let geometry = embree.triangles(positions, triangles);
                    embree.attach(geometry, id);
                }
                Geometry::Analytic(_) => {
                    let geometry = embree.analytic(shape);
                    embree.attach(geometry, id);
                }
            }
        }
        // SAFETY: the scene is live and no other thread knows of it.
        unsafe { rtcCommitScene(scene) };
        embree.device.check()?;
        Ok(embree)
    }

    /// A geometry that shares the buffers of a mesh.
    fn triangles(&self, positions: &[glam::Vec3A], triangles: &[[u32; 3]]) -> RTCGeometry {
        // SAFETY: the device is live.
        let geometry = unsafe {
            rtcNewGeometry(self.device.handle, RTCGeometryType::RTC_GEOMETRY_TYPE_TRIANGLE)
        };
        // SAFETY: each vertex is a `Vec3A`, 16 readable bytes of which the first 12 are x, y, z, so the last
        // one too may be read as 16 bytes; the buffer outlives the scene (`_shapes`).
        unsafe {
            rtcSetSharedGeometryBuffer(
                geometry,
                RTCBufferType::RTC_BUFFER_TYPE_VERTEX,
                0,
                RTCFormat::RTC_FORMAT_FLOAT3,
                positions.as_ptr().cast(),
                0,
                size_of::<glam::Vec3A>(),
                positions.len(),
            );
        }
        // SAFETY: three indices of 4 bytes each, which `TriangleMesh` checked against the number of
        // vertices; the buffer outlives the scene (`_shapes`).
        unsafe {
            rtcSetSharedGeometryBuffer(
                geometry,
                RTCBufferType::RTC_BUFFER_TYPE_INDEX,
                0,
                RTCFormat::RTC_FORMAT_UINT3,
                triangles.as_ptr().cast(),
                0,
                size_of::<[u32; 3]>(),
                triangles.len(),
            );
        }
        geometry
    }

    /// A geometry of one primitive that the shape's own code intersects.
    fn analytic(&mut self, shape: &Arc<dyn Shape>) -> RTCGeometry {
        // SAFETY: the device is live.
        let geometry =
            unsafe { rtcNewGeometry(self.device.handle, RTCGeometryType::RTC_GEOMETRY_TYPE_USER) };
        let mut user = Box::new(UserShape {
            callbacks: ShimUserGeometry {
                user: ptr::null(),
                bounds: Some(bounds),
                intersect: Some(intersect),
                occluded: Some(occluded),
            },
            shape: Arc::clone(shape),
        });
        user.callbacks.user = (&raw const *user).cast();
        // SAFETY: the geometry is live and of type USER.
        unsafe { rtcSetGeometryUserPrimitiveCount(geometry, 1) };
        // SAFETY: the callbacks stay at their address until the scene is gone (`_user_shapes`).
        unsafe { telamon_set_user_geometry(geometry, &raw const user.callbacks) };
        self._user_shapes.push(user);
        geometry
    }

    fn attach(&self, geometry: RTCGeometry, id: u32) {
        // The default differs between Embree 3 and 4.
        // SAFETY: the geometry is live; its buffers or callbacks are set.
        unsafe { rtcSetGeometryMask(geometry, u32::MAX) };
        // SAFETY: as above.
        unsafe { rtcCommitGeometry(geometry) };
        // SAFETY: scene and geometry are live, and no two shapes have one index.
        unsafe { rtcAttachGeometryByID(self.scene, geometry, id) };
        // SAFETY: the scene has a reference of its own now, and this one is not used again.
        unsafe { rtcReleaseGeometry(geometry) };
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: the only reference to a live scene, or null, which Embree refuses without harm; the
        // shapes and the device are dropped after this.
        unsafe { rtcReleaseScene(self.scene) };
    }
}

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

    /// In packets of eight.
    fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        assert_eq!(rays.len(), hits.len(), "one answer for each ray");
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

    /// In packets of eight.
    fn occluded_many(&self, rays: &[Ray], occluded: &mut [bool]) {
        assert_eq!(rays.len(), occluded.len(), "one answer for each ray");
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
        usize::try_from(self.device.state.bytes.load(Ordering::Relaxed)).unwrap_or(0)
    }

    fn name(&self) -> String {
        format!("Embree {}, robust", RTC_VERSION_STRING.to_string_lossy())
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

impl Device {
    fn new() -> Result<Self, BuildError> {
        let config = format!("threads={}", rayon::current_num_threads());
        let config = CString::new(config).expect("no zero byte inside");
        // SAFETY: a C string that ends with its zero.
        let handle = unsafe { rtcNewDevice(config.as_ptr()) };
        if handle.is_null() {
            // SAFETY: null asks for the error of a device that could not be made.
            let code = unsafe { rtcGetDeviceError(handle) };
            // SAFETY: likewise.
            let message = unsafe { telamon_error_message(handle, code) };
            // SAFETY: a C string that is valid until the next failing call on this thread.
            let message = unsafe { CStr::from_ptr(message) };
            return Err(BuildError::Embree(message.to_string_lossy().into_owned()));
        }
        let state = Box::<DeviceState>::default();
        let user: *mut c_void = (&raw const *state).cast_mut().cast();
        // SAFETY: the device is live; the state stays at its address until the device is gone, and is
        // only read as `&DeviceState` by the callbacks.
        unsafe { rtcSetDeviceErrorFunction(handle, Some(on_error), user) };
        // SAFETY: likewise.
        unsafe { rtcSetDeviceMemoryMonitorFunction(handle, Some(on_memory), user) };
        Ok(Self { handle, state })
    }

    /// The first error since the last time, if there was one.
    fn check(&self) -> Result<(), BuildError> {
        let mut error = self.state.first_error.lock().unwrap_or_else(PoisonError::into_inner);
        error.take().map_or(Ok(()), |message| Err(BuildError::Embree(message)))
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: the only reference to a live device; its state is dropped after this.
        unsafe { rtcReleaseDevice(self.handle) };
    }
}

unsafe extern "C" fn on_error(user: *mut c_void, code: RTCError, message: *const c_char) {
    // SAFETY: the pointer that was registered with the device, which is live while it calls.
    let state = unsafe { &*user.cast_const().cast::<DeviceState>() };
    let text = if message.is_null() {
        format!("error {}", code.0)
    } else {
        // SAFETY: Embree passes a C string that is valid during the call.
        unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned()
    };
    state.first_error.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(text);
}

unsafe extern "C" fn on_memory(user: *mut c_void, bytes: isize, _after: bool) -> bool {
    // SAFETY: as in `on_error`.
    let state = unsafe { &*user.cast_const().cast::<DeviceState>() };
    state.bytes.fetch_add(bytes, Ordering::Relaxed);
    true
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
