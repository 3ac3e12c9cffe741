//! A scene of one geometry and the rays that the tests send into it.

use std::ffi::CStr;
use std::ptr;

use embree_sys::*;

/// A scene with one geometry, whose id is 0, and the device that it lives in.
pub(crate) struct Scene {
    pub(crate) device: RTCDevice,
    pub(crate) scene: RTCScene,
}

impl Scene {
    pub(crate) fn new(device: RTCDevice, geometry: RTCGeometry) -> Self {
        assert!(!device.is_null() && !geometry.is_null());
        // SAFETY: `device` is a live handle; the callers just made it.
        let scene = unsafe { rtcNewScene(device) };
        // SAFETY: `geometry` is live and all its buffers and callbacks are set.
        unsafe { rtcCommitGeometry(geometry) };
        // SAFETY: both handles are live and of one device.
        let id = unsafe { rtcAttachGeometry(scene, geometry) };
        assert_eq!(id, 0);
        // SAFETY: the scene took a reference of its own, and this one is not used again.
        unsafe { rtcReleaseGeometry(geometry) };
        // SAFETY: `scene` is live, and no other thread knows it.
        unsafe { rtcCommitScene(scene) };
        Self { device, scene }
    }

    pub(crate) fn intersect1(&self, ray: RTCRay) -> RTCRayHit {
        let mut rayhit = RTCRayHit { ray, hit: no_hit() };
        // SAFETY: the scene is committed, and `rayhit` has the type, hence the alignment, asked for.
        unsafe { telamon_intersect1(self.scene, &raw mut rayhit, ptr::null()) };
        rayhit
    }

    pub(crate) fn occluded1(&self, mut ray: RTCRay) -> bool {
        // SAFETY: as in `intersect1`.
        unsafe { telamon_occluded1(self.scene, &raw mut ray, ptr::null()) };
        ray.tfar == f32::NEG_INFINITY
    }

    pub(crate) fn intersect8(&self, valid: &[i32; 8], ray: RTCRay8, coherent: bool) -> RTCRayHit8 {
        let hit = RTCHit8 {
            geomID: [RTC_INVALID_GEOMETRY_ID; 8],
            instID: [[RTC_INVALID_GEOMETRY_ID; 8]; 1],
            ..Default::default()
        };
        let mut rayhit = RTCRayHit8 { ray, hit };
        let valid = Mask(*valid);
        // SAFETY: as in `intersect1`; `Mask` aligns the eight lanes as the manual demands.
        unsafe {
            telamon_intersect8(
                valid.0.as_ptr(),
                self.scene,
                &raw mut rayhit,
                coherent,
                ptr::null(),
            );
        };
        rayhit
    }

    pub(crate) fn occluded8(
        &self,
        valid: &[i32; 8],
        mut ray: RTCRay8,
        coherent: bool,
    ) -> [bool; 8] {
        let valid = Mask(*valid);
        // SAFETY: as in `intersect8`.
        unsafe {
            telamon_occluded8(valid.0.as_ptr(), self.scene, &raw mut ray, coherent, ptr::null());
        };
        ray.tfar.map(|t| t == f32::NEG_INFINITY)
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        // SAFETY: the only reference that this test holds; it is not used again.
        unsafe { rtcReleaseScene(self.scene) };
        // SAFETY: likewise.
        unsafe { rtcReleaseDevice(self.device) };
    }
}

#[repr(align(32))]
pub(crate) struct Mask(pub(crate) [i32; 8]);

/// Some lanes on, some off, neither half whole.
pub(crate) const SOME: [i32; 8] = [-1, 0, -1, -1, 0, -1, 0, 0];

pub(crate) fn device(config: &CStr) -> RTCDevice {
    // SAFETY: a C string that ends with its zero.
    unsafe { rtcNewDevice(config.as_ptr()) }
}

pub(crate) fn geometry(device: RTCDevice, kind: RTCGeometryType) -> RTCGeometry {
    assert!(!device.is_null());
    // SAFETY: the device is live.
    unsafe { rtcNewGeometry(device, kind) }
}

pub(crate) fn no_hit() -> RTCHit {
    RTCHit {
        geomID: RTC_INVALID_GEOMETRY_ID,
        instID: [RTC_INVALID_GEOMETRY_ID],
        ..Default::default()
    }
}

/// From (x, y, -2) along +z.
pub(crate) fn ray_at(x: f32, y: f32) -> RTCRay {
    RTCRay {
        org_x: x,
        org_y: y,
        org_z: -2.0,
        dir_z: 1.0,
        tfar: f32::INFINITY,
        mask: u32::MAX,
        ..Default::default()
    }
}

/// Eight times [`ray_at`], at the given x and y = 0.1.
pub(crate) fn rays_at(x: [f32; 8]) -> RTCRay8 {
    RTCRay8 {
        org_x: x,
        org_y: [0.1; 8],
        org_z: [-2.0; 8],
        dir_z: [1.0; 8],
        tfar: [f32::INFINITY; 8],
        mask: [u32::MAX; 8],
        ..Default::default()
    }
}

/// A scene of the triangle (0,0,0) (1,0,0) (0,1,0).
pub(crate) fn triangle(device: RTCDevice) -> Scene {
    Scene::new(device, triangle_geometry(device))
}

/// The triangle of [`triangle`], which no scene has yet.
pub(crate) fn triangle_geometry(device: RTCDevice) -> RTCGeometry {
    let mesh = geometry(device, RTCGeometryType::RTC_GEOMETRY_TYPE_TRIANGLE);
    let corners: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    // SAFETY: the geometry is live; Embree allocates the buffer, padding included.
    let vertices = unsafe {
        rtcSetNewGeometryBuffer(
            mesh,
            RTCBufferType::RTC_BUFFER_TYPE_VERTEX,
            0,
            RTCFormat::RTC_FORMAT_FLOAT3,
            12,
            3,
        )
    };
    assert!(!vertices.is_null());
    // SAFETY: the buffer holds 3 vertices of 12 bytes, and nobody else uses it yet.
    unsafe { ptr::copy_nonoverlapping(corners.as_ptr(), vertices.cast(), corners.len()) };
    // SAFETY: as for the vertices.
    let indices = unsafe {
        rtcSetNewGeometryBuffer(
            mesh,
            RTCBufferType::RTC_BUFFER_TYPE_INDEX,
            0,
            RTCFormat::RTC_FORMAT_UINT3,
            12,
            1,
        )
    };
    assert!(!indices.is_null());
    // SAFETY: the buffer holds one triangle of 12 bytes, and nobody else uses it yet.
    unsafe { ptr::copy_nonoverlapping([0_u32, 1, 2].as_ptr(), indices.cast(), 3) };
    mesh
}
