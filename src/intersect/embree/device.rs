//! Embree's device: errors in its own words, and the memory that it holds.

use std::ffi::{CStr, CString, c_char, c_void};
use std::sync::atomic::{AtomicIsize, Ordering};
use std::sync::{Mutex, PoisonError};

use embree_sys::*;

use crate::intersect::BuildError;

#[derive(Debug)]
pub(super) struct Device {
    pub(super) handle: RTCDevice,
    /// Boxed, because Embree keeps its address.
    state: Box<DeviceState>,
}

// SAFETY: Embree lets a device be used and released from any thread. Nothing else is reachable through
// `&Device`; the state that Embree's callbacks write is atomic or behind a mutex.
unsafe impl Send for Device {}
// SAFETY: as above.
unsafe impl Sync for Device {}

/// What Embree reports through callbacks, from any thread.
#[derive(Debug, Default)]
struct DeviceState {
    bytes: AtomicIsize,
    first_error: Mutex<Option<String>>,
}

impl Device {
    pub(super) fn new() -> Result<Self, BuildError> {
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

    /// Bytes that Embree holds now.
    pub(super) fn bytes(&self) -> usize {
        usize::try_from(self.state.bytes.load(Ordering::Relaxed)).unwrap_or(0)
    }

    /// The first error since the last time, if there was one.
    pub(super) fn check(&self) -> Result<(), BuildError> {
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
