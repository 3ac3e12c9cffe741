//! Telamon beside an engine and a renderer that we did not write: the package `embreex` (Embree 4) traces
//! the same rays, Mitsuba 3 renders the same scene files. Both run in Python, behind pipes.
//!
//! ```text
//! ./setup.sh --peers
//! cargo test --features peers --test peers
//! ```
//!
//! Empty without that feature, since nothing else installs what it needs.

#![cfg(feature = "peers")]

mod embreex;
mod engines;
mod judge;
mod made_up;
mod mitsuba;
mod pictures;

// The meshes of the parity test, and the sculpture that is one of them.
#[allow(dead_code)]
#[path = "../../examples/sculpt/figure.rs"]
mod figure;
#[path = "../../examples/sculpt/lattice.rs"]
mod lattice;
#[allow(dead_code)]
#[path = "../../examples/sculpt/mesh.rs"]
mod mesh;
#[allow(dead_code)]
#[path = "../parity/meshes.rs"]
mod meshes;
#[path = "../support/mod.rs"]
mod support;
