//! The limit: what the path tracer adds to bare Embree.
//!
//! Records the rays that a render of a scene really traces, then traces the recorded rays with bare
//! Embree calls from C on the same number of threads, and compares the two, interleaved: in the order and the packets of the
//! render (eight for closest hits, shadow rays by themselves), and one ray at a time.
//!
//! ```text
//! cargo bench --features bare --bench limit -- [SCENE.xml]... [-D NAME=VALUE]... [--dragon MESH.ply]
//! ```
//!
//! Without a scene: the Cornell box, and the dragon if its mesh is given.

#![allow(clippy::print_stdout, reason = "a benchmark's result is what it prints")]

mod support;

use embree_sys::bare;
use rayon::prelude::*;
use telamon::intersect::{self, Backend};
use telamon::render::Description;

use support::recorder::{record, trace};
use support::{Arguments, Outcome, SceneFile, Spread, bare_meshes, buffers, seconds};

/// Interleaved runs of each side.
const RUNS: usize = 9;

/// Samples per pixel: all rays are kept, a gigabyte for 9 million of them.
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

fn measure(name: &str, description: &Description) -> Outcome {
    let shapes = description.scene.shapes();
    let buffers = buffers(&shapes)?;
    let meshes = bare_meshes(&buffers);
    let engine = intersect::build(Backend::Embree, &shapes)?;
    let (statistics, queries) = record(description, engine.as_ref())?;

    let threads = rayon::current_num_threads();
    let scene = bare::Scene::new(&meshes, bare::Mode::Robust, threads);
    let bare = |in_packets: bool| {
        let trace = |chunk: &[bare::Query]| {
            if in_packets { scene.trace_in_packets(chunk) } else { scene.trace(chunk) }
        };
        seconds(|| queries.par_chunks(1 << 14).map(trace).sum::<usize>())
    };
    let mut times: Vec<_> = (0..=RUNS)
        .map(|_| {
            let ours = seconds(|| trace(description, engine.as_ref()));
            [ours, bare(true), bare(false)]
        })
        .collect();
    // The first run warms the caches.
    times.remove(0);

    let paths = statistics.samples as f64;
    let rate = |i: usize| paths / Spread::of(times.iter().map(|t| t[i])).median / 1e6;
    println!(
        "{name}: {:.2} + {:.2} rays a path, {threads} threads, {RUNS} runs; medians: ours {:.2} Mpaths/s",
        statistics.rays.closest as f64 / paths,
        statistics.rays.occlusion as f64 / paths,
        rate(0),
    );
    for (way, i) in [("bare, in packets", 1), ("bare, ray by ray", 2)] {
        let ratio = Spread::of(times.iter().map(|t| t[0] / t[i]));
        println!("  {way} {:.2} Mpaths/s, ratio of times {ratio}", rate(i));
    }
    let builds = (0..RUNS).map(|_| {
        seconds(|| intersect::build(Backend::Embree, &shapes).is_ok())
            / seconds(|| bare::Scene::new(&meshes, bare::Mode::Robust, threads))
    });
    println!("{name}: build through our wrapper over a bare one: {}", Spread::of(builds));
    Ok(())
}
