//! Do the engines agree, and who is right where they do not? Fires the same rays through any number of
//! engines, settles every disagreement by a referee with exact predicates ([`oracle`]), and counts the
//! [`Class`] of each engine's answers.
//!
//! ```
//! use std::sync::Arc;
//! use std::sync::atomic::AtomicBool;
//!
//! use glam::DAffine3;
//! use telamon::intersect::{self, Backend};
//! use telamon::parity::{self, Contender, Generated, Oracle};
//! use telamon::shape::{Shape, primitives};
//!
//! let cube: Arc<dyn Shape> = Arc::new(primitives::cube(DAffine3::IDENTITY, false).0);
//! let shapes = [cube];
//! let engine = intersect::build(Backend::Rust, &shapes)?;
//! let rays = Generated::new(&shapes, None, 0, 1000);
//! let contenders = [Contender::new(engine.as_ref())];
//! let oracle = Oracle::new(&shapes);
//! let report = parity::run(&oracle, &contenders, &rays, &mut |_| (), &AtomicBool::new(false));
//! assert_eq!(report.rays, 1000);
//! println!("{report}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod class;
mod engines;
mod families;
mod generate;
mod hex_float;
pub mod oracle;
mod record;
mod report;
mod run;
mod scales;

pub use class::{Answer, Class, Query};
pub use engines::{budget, every_mode};
pub use families::{Family, RaySource};
pub use generate::{Generated, View};
pub use oracle::Oracle;
pub use record::{RecordError, RecordWriter, Recorded};
pub use report::{Budget, Report, Row, Tally};
pub use run::{Contender, Disagreement, Judged, Progress, run};
pub use scales::MixedScales;
