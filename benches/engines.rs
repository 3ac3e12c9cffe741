//! The Rust engine beside Embree: rays a second and build time.
//!
//! Records the rays that a render of a scene really traces, then traces them, closest hits and
//! occlusion apart, with the Rust engine in each of its modes and with bare Embree calls from C, one
//! ray at a time, on the same number of threads. All take turns.
//!
//! ```text
//! cargo bench --features bare --bench engines -- [SCENE.xml]... [--dragon MESH.ply]
//! ```
//!
//! Without a scene: the Cornell box, and the dragon if its mesh is given.

#![allow(clippy::print_stdout, reason = "a benchmark's result is what it prints")]

mod support;

use embree_sys::bare;
use rayon::prelude::*;
use telamon::intersect::accel::{RustModes, TriangleTest};
use telamon::intersect::{self, Accel, Backend, Intersector};
use telamon::ray::Ray;
use telamon::render::Description;

use support::recorder::record;
use support::{Arguments, Outcome, SceneFile, Spread, bare_meshes, buffers, seconds};

/// Interleaved runs of each side.
const RUNS: usize = 9;

/// Samples per pixel: all rays are kept.
const SAMPLES: u32 = 4;

/// Rays that a thread traces in one go.
const CHUNK: usize = 1 << 14;

const USAGE: &str = "engines [SCENE.xml]... [--dragon MESH.ply]";

fn main() -> Outcome {
    let arguments = Arguments::read(&["--dragon"], USAGE)?;
    let mut scenes: Vec<_> = arguments
        .paths
        .iter()
        .map(|path| SceneFile { path: path.clone(), defines: Vec::new() })
        .collect();
    if scenes.is_empty() {
        scenes = SceneFile::defaults(arguments.value("--dragon"));
    }
    for scene in &scenes {
        let mut description = scene.load()?;
        description.sampler.samples_per_pixel = SAMPLES;
        measure(&scene.name(), &description)?;
    }
    Ok(())
}

fn measure(name: &str, description: &Description) -> Outcome {
    let shapes = description.scene.shapes();
    let buffers = buffers(&shapes)?;
    let meshes = bare_meshes(&buffers);
    let threads = rayon::current_num_threads();
    let bare = |mode| bare::Scene::new(&meshes, mode, threads);
    let rust = |triangle| intersect::build(Accel::Rust(RustModes { triangle }), &shapes);

    let (robust, fast) = (bare(bare::Mode::Robust), bare(bare::Mode::Fast));
    let (watertight, plain) = (rust(TriangleTest::Watertight)?, rust(TriangleTest::Plain)?);
    // The first is what the others are compared with.
    let tracers = [
        ("Embree robust", Tracer::Embree(&robust)),
        ("Embree fast", Tracer::Embree(&fast)),
        ("Rust watertight", Tracer::Rust(watertight.as_ref())),
        ("Rust plain", Tracer::Rust(plain.as_ref())),
    ];

    let recorder = intersect::build(Backend::Embree, &shapes)?;
    let (_, queries) = record(description, recorder.as_ref())?;
    drop(recorder);
    let (occlusion, closest): (Vec<_>, Vec<_>) = queries.iter().partition(|q| q.occlusion != 0);
    drop(queries);
    for (kind, queries) in [("closest hit", closest), ("occlusion", occlusion)] {
        if !queries.is_empty() {
            compare(name, kind, &queries, &tracers);
        }
    }

    let builds = (0..=RUNS).map(|_| {
        let embree = seconds(|| bare(bare::Mode::Robust));
        (embree, seconds(|| rust(TriangleTest::Watertight).is_ok()))
    });
    // The first run warms the caches.
    let builds: Vec<_> = builds.skip(1).collect();
    println!(
        "{name}, build: Embree {:.3} s, Rust {:.3} s, ratio of times {}; {:.1} MiB",
        Spread::of(builds.iter().map(|b| b.0)).median,
        Spread::of(builds.iter().map(|b| b.1)).median,
        Spread::of(builds.iter().map(|(embree, ours)| ours / embree)),
        watertight.bytes() as f64 / f64::from(1 << 20),
    );
    Ok(())
}

/// One that traces the recorded rays.
enum Tracer<'a> {
    Embree(&'a bare::Scene<'a>),
    Rust(&'a dyn Intersector),
}

impl Tracer<'_> {
    /// How many rays hit.
    fn trace(&self, queries: &[bare::Query]) -> usize {
        let count = |chunk: &[bare::Query]| match self {
            Self::Embree(scene) => scene.trace(chunk),
            Self::Rust(engine) => chunk.iter().filter(|query| hits(*engine, query)).count(),
        };
        queries.par_chunks(CHUNK).map(count).sum()
    }
}

fn hits(engine: &dyn Intersector, query: &bare::Query) -> bool {
    let ray =
        Ray { t_min: query.t_min, t_max: query.t_max, ..Ray::new(query.origin, query.direction) };
    if query.occlusion != 0 { engine.occluded(&ray) } else { engine.closest_hit(&ray).is_some() }
}

/// Lets all trace the same rays in turn, and prints their rates over that of the first.
fn compare(name: &str, kind: &str, queries: &[bare::Query], tracers: &[(&str, Tracer)]) {
    let turn =
        |_| -> Vec<f64> { tracers.iter().map(|(_, t)| seconds(|| t.trace(queries))).collect() };
    // The first run warms the caches.
    let times: Vec<_> = (0..=RUNS).map(turn).skip(1).collect();
    println!(
        "{name}, {kind}: {:.2} M rays, {} threads, {RUNS} runs; medians (least to largest) of the rates",
        queries.len() as f64 / 1e6,
        rayon::current_num_threads(),
    );
    for (i, (label, tracer)) in tracers.iter().enumerate() {
        let rates = times.iter().map(|t| queries.len() as f64 / t[i] / 1e6);
        println!(
            "  {label:16} {} Mrays/s, {} of {}; {} hits",
            Spread::of(rates),
            Spread::of(times.iter().map(|t| t[0] / t[i])),
            tracers[0].0,
            tracer.trace(queries),
        );
    }
}
