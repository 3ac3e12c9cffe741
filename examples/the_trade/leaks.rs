//! Rays for which an engine is wrong, as the referee of `telamon parity` finds them.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde::{Deserialize, Serialize};
use telamon::intersect::{self, Accel, BuildError};
use telamon::parity::{self, Contender, Family, Generated, Oracle, Query};
use telamon::shape::Shape;

/// What one engine gets wrong.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Leaks {
    /// Label of the setting.
    pub(crate) setting: String,
    /// Rays that are aimed at nothing, and those of them that it gets wrong.
    pub(crate) random: (u64, u64),
    /// Rays at corners, sides and along axes or surfaces, likewise.
    pub(crate) aimed: (u64, u64),
}

const RAYS: u64 = 400_000;

/// Fires the same rays through all engines.
pub(crate) fn count_leaks(
    settings: &[(String, Accel)],
    shapes: &[Arc<dyn Shape>],
) -> Result<Vec<Leaks>, BuildError> {
    let engines: Vec<_> = settings
        .iter()
        .map(|&(_, accel)| intersect::build(accel, shapes))
        .collect::<Result<_, _>>()?;
    let contenders: Vec<_> = engines
        .iter()
        .map(|e| Contender { queries: &[Query::Closest], ..Contender::new(e.as_ref()) })
        .collect();
    let rays = Generated::new(shapes, None, 0, RAYS);
    let (oracle, never) = (Oracle::new(shapes), AtomicBool::new(false));
    let report = parity::run(&oracle, &contenders, &rays, &mut |_| (), &never);
    let leaks = settings.iter().zip(&report.rows).map(|((setting, _), row)| {
        let count = |aimed: bool| {
            let families = || Family::ALL.into_iter().filter(|f| f.is_aimed() == aimed);
            let total = families().flat_map(|f| row.tally.by_family[f as usize]).sum();
            (total, families().map(|f| row.tally.faults_of(f)).sum())
        };
        Leaks { setting: setting.clone(), random: count(false), aimed: count(true) }
    });
    Ok(leaks.collect())
}
