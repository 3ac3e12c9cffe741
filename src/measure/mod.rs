//! How good a picture is: [metrics], the perceptual [`flip()`], and the [statistics] that decide what
//! they show.

pub mod false_color;
pub mod flip;
pub mod image;
pub mod metrics;
pub mod statistics;

pub use flip::flip;
pub use image::Image;
pub use metrics::{Metrics, ZTest};
