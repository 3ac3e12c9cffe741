//! The limit: what the path tracer adds to bare Embree.
//!
//! Records the rays that a render of a scene really traces, then traces the recorded rays with bare
//! Embree calls from C on the same number of threads, and compares the two, interleaved.
//!
//! ```text
//! cargo bench --features bare --bench limit -- [SCENE.xml]... [-D NAME=VALUE]... [--dragon MESH.ply]
//! ```
//!
//! Without a scene: the Cornell box, and the dragon if its mesh is given.

#![allow(clippy::print_stdout, reason = "a benchmark's result is what it prints")]

mod support;

use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

use embree_sys::bare;
use rayon::prelude::*;
use telamon::intersect::{self, Backend, Intersector};
use telamon::ray::{Hit, Ray};
use telamon::render::{Statistics, render};
use telamon::scene::Description;

use support::{Arguments, Outcome, SceneFile, Spread, buffers, seconds};

/// Interleaved runs of each side.
const RUNS: usize = 9;

/// Samples per pixel: all rays are kept, a gigabyte for 25 million of them.
const SAMPLES: u32 = 4;

const USAGE: &str = "limit [SCENE.xml]... [-D NAME=VALUE]... [--dragon MESH.ply]";

fn main() -> Outcome {
    let arguments = Arguments::read(&["-D", "--dragon"], USAGE)?;
    let define = |text: &str| match text.split_once('=') {
        Some((name, value)) => Ok((name.to_owned(), value.to_owned())),
        None => Err(format!("-D needs NAME=VALUE, not {text}")),
    };
    let defines = arguments.values("-D").map(define).collect::<Result<Vec<_>, _>>()?;
    let mut scenes: Vec<_> = arguments
        .paths
        .iter()
        .map(|path| SceneFile { path: path.clone(), defines: Vec::new() })
        .collect();
    if scenes.is_empty() {
        scenes = SceneFile::defaults(arguments.value("--dragon"));
    }
    for scene in &mut scenes {
        scene.defines.extend_from_slice(&defines);
        let mut description = scene.load()?;
        description.sampler.samples_per_pixel = SAMPLES;
        measure(&scene.name(), &description)?;
    }
    Ok(())
}

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
fn record(
    description: &Description,
    engine: &dyn Intersector,
) -> Outcome<(Statistics, Vec<bare::Query>)> {
    let recorder = Recorder { engine, queries: Mutex::default() };
    // One thread, so that they are in the order in which a thread traces them.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let statistics = pool.install(|| trace(description, &recorder));
    Ok((statistics, recorder.queries.into_inner().unwrap_or_else(PoisonError::into_inner)))
}

fn trace(description: &Description, engine: &dyn Intersector) -> Statistics {
    render(description, engine, &|_| (), &AtomicBool::new(false)).1
}

fn measure(name: &str, description: &Description) -> Outcome {
    let shapes = description.scene.shapes();
    let buffers = buffers(&shapes)?;
    let meshes: Vec<_> =
        buffers.iter().map(|(positions, triangles)| bare::Mesh { positions, triangles }).collect();
    let engine = intersect::build(Backend::Embree, &shapes)?;
    let (statistics, queries) = record(description, engine.as_ref())?;

    let threads = rayon::current_num_threads();
    let scene = bare::Scene::new(&meshes, threads);
    let bare = || queries.par_chunks(1 << 14).map(|chunk| scene.trace(chunk)).sum::<usize>();
    let mut times: Vec<_> = (0..=RUNS)
        .map(|_| (seconds(|| trace(description, engine.as_ref())), seconds(bare)))
        .collect();
    // The first run warms the caches.
    times.remove(0);

    let paths = statistics.samples as f64;
    println!(
        "{name}: {:.2} + {:.2} rays a path, {threads} threads, {RUNS} runs; medians: ours {:.2} Mpaths/s, \
         bare {:.2} Mpaths/s, ratio of times {}",
        statistics.rays.closest as f64 / paths,
        statistics.rays.occlusion as f64 / paths,
        paths / Spread::of(times.iter().map(|t| t.0)).median / 1e6,
        paths / Spread::of(times.iter().map(|t| t.1)).median / 1e6,
        Spread::of(times.iter().map(|(ours, bare)| ours / bare)),
    );
    let builds = (0..RUNS).map(|_| {
        seconds(|| intersect::build(Backend::Embree, &shapes).is_ok())
            / seconds(|| bare::Scene::new(&meshes, threads))
    });
    println!("{name}: build through our wrapper over a bare one: {}", Spread::of(builds));
    Ok(())
}
