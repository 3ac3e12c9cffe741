//! Telamon beside a renderer that we did not write: Mitsuba 3 renders the same scene files. It runs in
//! Python, behind a pipe.
//!
//! ```text
//! ./setup.sh --peers
//! cargo test --features peers --test peers
//! ```

mod judge;
mod mitsuba;
mod pictures;
#[path = "../support/mod.rs"]
mod support;
