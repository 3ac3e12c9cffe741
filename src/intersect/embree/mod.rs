//! Debian's Embree as an engine.
//!
//! All `unsafe` of this crate is here; it leans on three facts. The handles are live from their creation
//! to [`Drop`], since nothing else can reach them. The buffers that Embree reads belong to shapes that
//! are held in an `Arc` for as long as the scene, and a shape behind an `Arc` does not change. Queries are
//! only possible on a committed scene: it is committed before [`Embree`] exists.

#![allow(unsafe_code, reason = "the only way to call Embree; each block says why it is sound")]

use std::sync::Arc;

use embree_sys::*;

use super::accel::{BuildQuality, EmbreeModes};
use super::groups::build_groups;
use super::{BuildError, reach};
use crate::shape::{Geometry, Shape};

mod asked;
mod device;
mod query;
mod user_geometry;

use device::Device;
use user_geometry::UserShape;

/// A committed Embree scene, with all that it refers to.
#[derive(Debug)]
pub struct Embree {
    scene: RTCScene,
    device: Arc<Device>,
    modes: EmbreeModes,
    /// See [`reach`].
    reach: f32,
    /// Read by Embree through the pointers that it was given.
    shapes: Vec<Arc<dyn Shape>>,
    #[expect(clippy::vec_box, reason = "Embree keeps the address of each, and the list grows")]
    user_shapes: Vec<Box<UserShape>>,
}

// SAFETY: the manual says of a committed scene: "Multiple threads are allowed to trace rays against it"
// (rtcCommitScene: "any ray query may be performed in parallel"), and handles may be used and released
// from any thread. Nothing else is reachable through `&Embree`; the state that Embree's callbacks
// write is atomic or behind a mutex.
unsafe impl Send for Embree {}
// SAFETY: as above.
unsafe impl Sync for Embree {}

impl Embree {
    /// Builds over `shapes`, with as many threads as the current thread pool has.
    ///
    /// # Errors
    /// What Embree says of it, such as that memory has run out.
    pub fn new(modes: EmbreeModes, shapes: &[Arc<dyn Shape>]) -> Result<Self, BuildError> {
        Self::on_device(&Arc::new(Device::new()?), modes, shapes)
    }

    fn on_device(
        device: &Arc<Device>,
        modes: EmbreeModes,
        shapes: &[Arc<dyn Shape>],
    ) -> Result<Self, BuildError> {
        let groups = build_groups(shapes, |members| Self::on_device(device, modes, members))?;
        // SAFETY: the device is live.
        let scene = unsafe { rtcNewScene(device.handle) };
        let mut embree = Self {
            scene,
            device: Arc::clone(device),
            modes,
            reach: reach(shapes),
            shapes: shapes.to_vec(),
            user_shapes: Vec::new(),
        };
        embree.device.check()?;
        // SAFETY: the scene is live and not yet committed.
        unsafe { rtcSetSceneFlags(scene, scene_flags(modes)) };
        // SAFETY: as above.
        unsafe { rtcSetSceneBuildQuality(scene, build_quality(modes)) };
        for (shape, id) in shapes.iter().zip(0..) {
            match shape.geometry() {
                // Embree has nothing to read in an empty buffer, and may not get its address.
                Geometry::Triangles { triangles: [], .. } => {}
                Geometry::Triangles { positions, triangles } => {
                    let geometry = embree.triangles(positions, triangles);
                    // SAFETY: the geometry is live, and all queries come with what the filter asks.
                    unsafe { telamon_filter_occlusion(geometry) };
                    embree.attach(geometry, id);
                }
                Geometry::Deforming(_) | Geometry::Analytic(_) | Geometry::Instance(_) => {
                    let group = groups.get(id as usize).cloned().flatten();
                    let user = UserShape::new(Arc::clone(shape), group);
                    let geometry = user.geometry(&embree.device);
                    embree.user_shapes.push(user);
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
        // one too may be read as 16 bytes; the buffer outlives the scene (`shapes`).
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
        // vertices; the buffer outlives the scene (`shapes`).
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

fn scene_flags(modes: EmbreeModes) -> RTCSceneFlags {
    let mut flags = RTCSceneFlags::RTC_SCENE_FLAG_NONE;
    if modes.robust {
        flags |= RTCSceneFlags::RTC_SCENE_FLAG_ROBUST;
    }
    if modes.compact {
        flags |= RTCSceneFlags::RTC_SCENE_FLAG_COMPACT;
    }
    flags
}

fn build_quality(modes: EmbreeModes) -> RTCBuildQuality {
    match modes.quality {
        BuildQuality::Low => RTCBuildQuality::RTC_BUILD_QUALITY_LOW,
        BuildQuality::Medium => RTCBuildQuality::RTC_BUILD_QUALITY_MEDIUM,
        BuildQuality::High => RTCBuildQuality::RTC_BUILD_QUALITY_HIGH,
    }
}
