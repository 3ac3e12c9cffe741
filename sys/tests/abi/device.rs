//! Versions, layouts, configurations, errors, the memory monitor.

use std::ffi::{CStr, c_char, c_void};
use std::mem::{align_of, size_of};
use std::ptr;
use std::sync::Mutex;
use std::sync::atomic::{AtomicIsize, Ordering};

use embree_sys::*;

use crate::scene::{device, triangle};

#[test]
fn header_and_library_are_of_one_version() {
    let device = device(c"");
    for (property, expected) in [
        (RTCDeviceProperty::RTC_DEVICE_PROPERTY_VERSION, RTC_VERSION),
        (RTCDeviceProperty::RTC_DEVICE_PROPERTY_VERSION_MAJOR, RTC_VERSION_MAJOR),
        (RTCDeviceProperty::RTC_DEVICE_PROPERTY_VERSION_MINOR, RTC_VERSION_MINOR),
        (RTCDeviceProperty::RTC_DEVICE_PROPERTY_VERSION_PATCH, RTC_VERSION_PATCH),
        // What the crate's documentation says about masks.
        (RTCDeviceProperty::RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED, 1),
    ] {
        // SAFETY: the device is live.
        let value = unsafe { rtcGetDeviceProperty(device, property) };
        assert_eq!(value, expected as isize, "{property:?}");
    }
    // SAFETY: the only reference; it is not used again.
    unsafe { rtcReleaseDevice(device) };
}

#[test]
fn c_and_rust_agree_on_layouts() {
    // SAFETY: it has no arguments and returns a plain record.
    let c = unsafe { telamon_layout() };
    assert_eq!(c.ray, size_of::<RTCRay>());
    assert_eq!(c.ray_align, align_of::<RTCRay>());
    assert_eq!(c.hit, size_of::<RTCHit>());
    assert_eq!(c.ray_hit, size_of::<RTCRayHit>());
    assert_eq!(c.ray_hit_align, align_of::<RTCRayHit>());
    assert_eq!(c.ray8, size_of::<RTCRay8>());
    assert_eq!(c.ray_hit8, size_of::<RTCRayHit8>());
    assert_eq!(c.ray_hit8_align, align_of::<RTCRayHit8>());
    assert_eq!(c.bounds, size_of::<RTCBounds>());
    assert_eq!(c.shim_ray, size_of::<ShimRay>());
    assert_eq!(c.shim_hit, size_of::<ShimHit>());
    assert_eq!(c.shim_query, size_of::<ShimQuery>());
    assert_eq!(c.shim_user_geometry, size_of::<ShimUserGeometry>());
}

#[test]
fn a_device_opens_without_configuration() {
    // SAFETY: the manual allows null for "no configuration".
    let device = unsafe { rtcNewDevice(ptr::null()) };
    assert!(!device.is_null());
    // SAFETY: the device is live.
    let error = unsafe { rtcGetDeviceError(device) };
    assert_eq!(error, RTCError::RTC_ERROR_NONE);
    // SAFETY: the only reference; it is not used again.
    unsafe { rtcReleaseDevice(device) };
}

#[test]
fn a_configuration_that_does_not_parse_makes_no_device() {
    assert!(device(c"threads=many").is_null());
    // SAFETY: null asks for the error of the device that this thread could not make.
    let error = unsafe { rtcGetDeviceError(ptr::null_mut()) };
    assert_eq!(error, RTCError::RTC_ERROR_UNKNOWN);
    // SAFETY: null as above.
    let message = unsafe { telamon_error_message(ptr::null_mut(), error) };
    assert!(!message.is_null());
    // SAFETY: a C string that stays until the next error on this thread.
    let message = unsafe { CStr::from_ptr(message) }.to_string_lossy();
    // Embree 3 keeps no text for a device that does not exist.
    let expected = if RTC_VERSION_MAJOR == 3 { "unknown error" } else { "integer expected" };
    assert!(message.contains(expected), "{message}");
}

#[test]
fn a_configuration_that_cannot_be_met_fails_with_embrees_message() {
    unsafe extern "C" fn note(log: *mut c_void, code: RTCError, message: *const c_char) {
        // SAFETY: `log` is the mutex that was registered together with this function.
        let log = unsafe { &*log.cast::<Mutex<Vec<(RTCError, String)>>>() };
        // SAFETY: Embree passes a C string that lives during the call.
        let message = unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned();
        log.lock().expect("no thread panics while it holds this").push((code, message));
    }
    // Outlives the device, which is dropped with the scene at the end of the block.
    let log: Mutex<Vec<(RTCError, String)>> = Mutex::default();
    {
        let device = device(c"tri_accel=nonsense");
        assert!(!device.is_null());
        let log = (&raw const log).cast_mut().cast();
        // SAFETY: the device is live; `log` outlives it and is shared through a mutex only.
        unsafe { rtcSetDeviceErrorFunction(device, Some(note), log) };
        drop(triangle(device));
    }
    let log = log.into_inner().expect("nobody panicked");
    let (code, message) = log.first().expect("the commit failed");
    assert_eq!(*code, RTCError::RTC_ERROR_INVALID_ARGUMENT);
    assert!(message.contains("nonsense"), "{message}");
}

#[test]
fn the_memory_monitor_counts_up_and_back_to_zero() {
    unsafe extern "C" fn count(total: *mut c_void, bytes: isize, _post: bool) -> bool {
        // SAFETY: `total` is the counter that was registered together with this function.
        unsafe { &*total.cast::<AtomicIsize>() }.fetch_add(bytes, Ordering::Relaxed);
        true
    }
    let total = AtomicIsize::new(0);
    let device = device(c"");
    // SAFETY: the device is live; `total` outlives it and is atomic.
    unsafe {
        rtcSetDeviceMemoryMonitorFunction(
            device,
            Some(count),
            (&raw const total).cast_mut().cast(),
        );
    };
    let scene = triangle(device);
    assert!(total.load(Ordering::Relaxed) >= 48, "vertices and indices alone take 48 bytes");
    drop(scene);
    assert_eq!(total.load(Ordering::Relaxed), 0);
}
