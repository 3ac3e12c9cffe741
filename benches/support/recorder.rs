//! The rays that a render really traces.

use std::sync::atomic::AtomicBool;

use embree_sys::bare;
use telamon::intersect::recorder::{Answer, Query};
use telamon::intersect::{Intersector, Recorder};
use telamon::render::{Description, Statistics, render};

use super::Outcome;

/// Renders once, keeping the rays.
pub(crate) fn record(
    description: &Description,
    engine: &dyn Intersector,
) -> Outcome<(Statistics, Vec<bare::Query>)> {
    let recorder = Recorder::new(engine);
    // One thread, so that they are in the order in which a thread traces them.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let statistics = pool.install(|| trace(description, &recorder));
    Ok((statistics, recorder.take().iter().map(bare_query).collect()))
}

fn bare_query(query: &Query) -> bare::Query {
    let Query { ray, answer } = query;
    bare::Query {
        origin: ray.origin.into(),
        t_min: ray.t_min,
        direction: ray.direction.into(),
        t_max: ray.t_max,
        occlusion: matches!(answer, Answer::Occluded(_)).into(),
    }
}

/// Renders once.
pub(crate) fn trace(description: &Description, engine: &dyn Intersector) -> Statistics {
    render(description, engine, &|_| (), &AtomicBool::new(false)).1
}
