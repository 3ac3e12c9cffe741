//! Embree as a C program would use it: build over meshes, trace a list of rays. Exists for benchmarks
//! (feature `bare`), which measure what a renderer adds on top.

use std::ffi::CString;

use crate::{
    RTCDevice, RTCScene, rtcCommitScene, rtcGetDeviceError, rtcNewDevice, rtcReleaseDevice,
    rtcReleaseScene,
};

/// A recorded ray.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Query {
    /// Where the ray starts.
    pub origin: [f32; 3],
    /// Start of its segment, at least 0.
    pub t_min: f32,
    /// Its direction.
    pub direction: [f32; 3],
    /// End of its segment.
    pub t_max: f32,
    /// 1 to ask whether anything is in the way, 0 to ask for the nearest hit.
    pub occlusion: u32,
}

/// Buffers of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Mesh<'a> {
    /// x, y, z and four bytes of padding for each vertex.
    pub positions: &'a [[f32; 4]],
    /// Three vertex indices for each triangle, all in range.
    pub triangles: &'a [[u32; 3]],
}

/// How a scene tests boxes and triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Watertight, and boxes widened by their rounding errors.
    Robust,
    /// Embree's own default: faster, and it misses some hits.
    Fast,
}

/// A committed scene over borrowed meshes.
#[derive(Debug)]
pub struct Scene<'a> {
    device: RTCDevice,
    scene: RTCScene,
    meshes: std::marker::PhantomData<Mesh<'a>>,
}

// SAFETY: a committed scene may be traced by any number of threads (manual, rtcCommitScene), and nothing
// else is done through a shared reference.
unsafe impl Sync for Scene<'_> {}

mod c {
    use super::Query;
    use crate::{RTCDevice, RTCScene};

    unsafe extern "C" {
        pub(super) fn bare_new_scene(device: RTCDevice, robust: bool) -> RTCScene;
        pub(super) fn bare_add_triangles(
            device: RTCDevice,
            scene: RTCScene,
            positions: *const f32,
            vertices: usize,
            indices: *const u32,
            triangles: usize,
        );
        pub(super) fn bare_trace(
            scene: RTCScene,
            queries: *const Query,
            count: usize,
            packets: bool,
        ) -> usize;
    }
}

impl<'a> Scene<'a> {
    /// Builds over `meshes` with `threads` threads.
    ///
    /// # Panics
    /// If an index is out of range, or Embree reports an error.
    #[must_use]
    pub fn new(meshes: &[Mesh<'a>], mode: Mode, threads: usize) -> Self {
        let config = CString::new(format!("threads={threads}")).expect("no zero byte inside");
        // SAFETY: a C string that ends with its zero.
        let device = unsafe { rtcNewDevice(config.as_ptr()) };
        assert!(!device.is_null(), "no Embree device");
        // SAFETY: the device is live.
        let scene = unsafe { c::bare_new_scene(device, mode == Mode::Robust) };
        for mesh in meshes {
            let vertices = mesh.positions.len();
            let in_range = |t: &[u32; 3]| t.iter().all(|&i| (i as usize) < vertices);
            assert!(mesh.triangles.iter().all(in_range), "an index is out of range");
            // SAFETY: device and scene are live; each vertex is 16 readable bytes, each index is in range, and
            // the buffers are borrowed for as long as the scene.
            unsafe {
                c::bare_add_triangles(
                    device,
                    scene,
                    mesh.positions.as_ptr().cast(),
                    vertices,
                    mesh.triangles.as_ptr().cast(),
                    mesh.triangles.len(),
                );
            }
        }
        // SAFETY: the scene is live and no other thread knows of it.
        unsafe { rtcCommitScene(scene) };
        // SAFETY: the device is live.
        let error = unsafe { rtcGetDeviceError(device) };
        assert_eq!(error.0, 0, "Embree reports an error");
        Self { device, scene, meshes: std::marker::PhantomData }
    }

    /// Traces all queries one after the other; returns how many hit something. Rays must be finite: they
    /// are not validated here.
    #[must_use]
    pub fn trace(&self, queries: &[Query]) -> usize {
        self.trace_in(queries, false)
    }

    /// The same, but neighbours that ask for the nearest hit go in packets of eight.
    #[must_use]
    pub fn trace_in_packets(&self, queries: &[Query]) -> usize {
        self.trace_in(queries, true)
    }

    fn trace_in(&self, queries: &[Query], packets: bool) -> usize {
        // SAFETY: the scene is committed, and the queries have the layout that C expects.
        unsafe { c::bare_trace(self.scene, queries.as_ptr(), queries.len(), packets) }
    }
}

impl Drop for Scene<'_> {
    fn drop(&mut self) {
        // SAFETY: the only reference to a live scene.
        unsafe { rtcReleaseScene(self.scene) };
        // SAFETY: the only reference to a live device.
        unsafe { rtcReleaseDevice(self.device) };
    }
}
