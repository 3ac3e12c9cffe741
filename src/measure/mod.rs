//! What a second of rendering buys: experiments that vary how a scene is rendered, and the means to judge
//! pictures.
//!
//! A [`plan`] says which settings of which [`knobs`] are rendered, in which order; a [`mod@bench`] renders them
//! and measures each picture against a reference ([`metrics`], [`flip()`]); a [`summary`] says what all
//! runs show together ([`statistics`]); a [`store`] keeps the [`record`] of them, and a [`report`] shows it.
//!
//! Low-discrepancy samplers have error bars only across seeds, never from the spread within one picture;
//! that is why every setting is rendered several times.

pub mod bench;
pub mod bias;
pub mod crops;
mod curve;
pub mod efficiency;
pub mod false_color;
pub mod flip;
pub mod image;
pub mod knobs;
pub mod metrics;
pub mod plan;
pub mod reach;
pub mod record;
pub mod report;
pub mod search;
pub mod series;
pub mod statistics;
pub mod store;
pub mod summary;
pub mod z_test;

pub use flip::flip;
pub use image::Image;
pub use metrics::Metrics;
pub use z_test::ZTest;
