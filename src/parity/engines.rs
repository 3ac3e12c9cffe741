//! The engines of this build that take part unless others are asked for.

use super::Budget;
#[cfg(feature = "embree")]
use crate::intersect::accel::EmbreeModes;
use crate::intersect::accel::{Mode, RustModes, TriangleTest};
use crate::intersect::{Accel, Backend};

/// Each engine in its default modes, and with each value of each mode that is not the default in place of
/// it.
#[must_use]
pub fn every_mode() -> Vec<Accel> {
    let mut all = Vec::new();
    for &backend in Backend::AVAILABLE {
        let default = Accel::from(backend);
        all.push(default);
        for (key, values) in Accel::modes(backend) {
            all.extend(values.into_iter().filter_map(|value| {
                let mut accel = default;
                accel.set(&Mode { key: key.to_owned(), value: value.to_owned() }).ok()?;
                (accel != default).then_some(accel)
            }));
        }
    }
    all
}

/// The faults that an engine is allowed: none if it promises to be watertight.
#[must_use]
pub fn budget(accel: Accel) -> Budget {
    match accel {
        #[cfg(feature = "embree")]
        Accel::Embree(EmbreeModes { robust: true, .. }) => Budget::EMBREE_ROBUST,
        #[cfg(feature = "embree")]
        Accel::Embree(_) => Budget::FAST,
        Accel::Rust(RustModes { triangle: TriangleTest::Watertight, .. }) => Budget::NONE,
        Accel::Rust(_) => Budget::FAST,
    }
}
