//! Records the rays that a render really traces.

use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

use embree_sys::bare;
use telamon::intersect::Intersector;
use telamon::ray::{Hit, Ray};
use telamon::render::{Statistics, render};
use telamon::scene::Description;

use super::Outcome;

/// Passes rays on to an engine and keeps them.
#[derive(Debug)]
struct Recorder<'a> {
    engine: &'a dyn Intersector,
    queries: Mutex<Vec<bare::Query>>,
}

impl Recorder<'_> {
    fn record(&self, ray: &Ray, occlusion: bool) {
        let query = bare::Query {
            origin: ray.origin.into(),
            t_min: ray.t_min,
            direction: ray.direction.into(),
            t_max: ray.t_max,
            occlusion: occlusion.into(),
        };
        self.queries.lock().unwrap_or_else(PoisonError::into_inner).push(query);
    }
}

impl Intersector for Recorder<'_> {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.record(ray, false);
        self.engine.closest_hit(ray)
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.record(ray, true);
        self.engine.occluded(ray)
    }

    fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        rays.iter().for_each(|ray| self.record(ray, false));
        self.engine.closest_hits(rays, hits);
    }

    fn occluded_many(&self, rays: &[Ray], occluded: &mut [bool]) {
        rays.iter().for_each(|ray| self.record(ray, true));
        self.engine.occluded_many(rays, occluded);
    }

    fn bytes(&self) -> usize {
        self.engine.bytes()
    }

    fn name(&self) -> String {
        self.engine.name()
    }
}

/// Renders once, keeping the rays.
pub(crate) fn record(
    description: &Description,
    engine: &dyn Intersector,
) -> Outcome<(Statistics, Vec<bare::Query>)> {
    let recorder = Recorder { engine, queries: Mutex::default() };
    // One thread, so that they are in the order in which a thread traces them.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let statistics = pool.install(|| trace(description, &recorder));
    Ok((statistics, recorder.queries.into_inner().unwrap_or_else(PoisonError::into_inner)))
}

/// Renders once.
pub(crate) fn trace(description: &Description, engine: &dyn Intersector) -> Statistics {
    render(description, engine, &|_| (), &AtomicBool::new(false)).1
}
