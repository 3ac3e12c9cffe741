//! `telamon parity`.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use clap::Args;
use telamon::film::output::{OutputError, check_writable};
use telamon::intersect::{self, Accel};
use telamon::load::mesh::{LoadedMesh, MeshFormat, MeshOptions};
use telamon::load::{LoadOptions, NoriX, load_scene};
use telamon::memory::Limits;
use telamon::parity::{
    self, Budget, Contender, Generated, MixedScales, Oracle, RaySource, RecordWriter, Recorded,
    View,
};
use telamon::render::MOST_THREADS;
use telamon::shape::Shape;

use super::message::{self, Failure, warn};
use super::progress::{Bar, rays_per_second};
use super::{Ending, Resources, interrupt, mesh, print, values};

/// Fire the same rays through all engines and settle where they disagree
#[derive(Args, Debug)]
#[command(
    after_help = "Exit status 1: an engine has more faults (leaks, false and wrong hits, wrong distances) than its \
                  budget. \
                  Ctrl-C ends the run and shows the table so far.\n\n\
                  Example: telamon parity mesh.ply --rays 1e7 --report disagreements.jsonl"
)]
pub(super) struct Arguments {
    /// Scene file (.xml) or mesh (.obj, .ply, .stl, .serialized; may be compressed with gzip)
    #[arg(value_name = "SCENE_OR_MESH")]
    input: PathBuf,

    /// Replace $NAME in the scene file, in place of its <default>; may be repeated
    #[arg(
        short = 'D',
        long = "define",
        value_name = "NAME=VALUE",
        value_parser = values::define,
        help_heading = "Input"
    )]
    defines: Vec<(String, String)>,

    #[command(flatten)]
    resources: Resources,

    /// Engine with its modes, such as rust,triangle=plain; may be repeated [default: each engine, and
    /// each of its modes in turn]
    #[arg(
        long = "engine",
        value_name = "ENGINE[,KEY=VALUE...]",
        value_parser = values::accel,
        help_heading = "Input"
    )]
    engines: Vec<Accel>,

    /// Number of rays
    #[arg(
        long,
        value_name = "N",
        default_value = "1e6",
        value_parser = values::count,
        help_heading = "Rays"
    )]
    rays: u64,

    /// Seed of the rays
    #[arg(long, value_name = "N", default_value = "0", help_heading = "Rays")]
    seed: u64,

    /// Fire the rays of a report instead
    #[arg(long, value_name = "FILE", conflicts_with_all = ["rays", "seed"], help_heading = "Rays")]
    replay: Option<PathBuf>,

    /// Threads; the counts do not depend on it [default: one for each processor]
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS.into()),
        help_heading = "Rays"
    )]
    threads: Option<u16>,

    /// Write every disagreement with its ray to a file of JSON lines
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    report: Option<PathBuf>,

    /// Shares of random and of aimed rays that each engine may get wrong [default: by its mode; the
    /// table shows it]
    #[arg(
        long,
        value_name = "RANDOM,AIMED",
        value_parser = values::budget,
        help_heading = "Output"
    )]
    budget: Option<Budget>,

    /// Show no progress
    #[arg(short, long, help_heading = "Output")]
    quiet: bool,
}

/// What is to be traced.
struct Subject {
    shapes: Vec<Arc<dyn Shape>>,
    view: Option<View>,
}

/// Engines that spoil their budget.
#[derive(Debug, thiserror::Error)]
#[error("more faults than the budget allows: {0}")]
struct OverBudget(String);

impl Arguments {
    pub(super) fn run(&self) -> Result<Ending, Failure> {
        if let Some(path) = &self.report {
            check_writable(path)?;
        }
        // 0 stands for one thread a processor.
        let threads = usize::from(self.threads.unwrap_or(0));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        pool.install(|| self.compare())
    }

    fn compare(&self) -> Result<Ending, Failure> {
        let limits = self.resources.limits();
        let Subject { shapes, view } = self.load(&limits)?;
        if let Some(mixed) = MixedScales::of(&shapes) {
            warn(format!("{}: {mixed}", self.input.display()));
        }
        let rays: Box<dyn RaySource> = match &self.replay {
            Some(path) => Box::new(Recorded::read(path)?),
            None => Box::new(Generated::new(&shapes, view, self.seed, self.rays)),
        };
        let accels =
            if self.engines.is_empty() { parity::every_mode() } else { self.engines.clone() };
        accels.iter().try_for_each(|accel| limits.claim(accel.estimated_bytes(&shapes)))?;
        let build = |&accel: &Accel| intersect::build(accel, &shapes);
        let engines = accels.iter().map(build).collect::<Result<Vec<_>, _>>()?;
        let contenders: Vec<_> = engines
            .iter()
            .zip(&accels)
            .map(|(engine, &accel)| Contender {
                budget: self.budget.unwrap_or(parity::budget(accel)),
                ..Contender::new(engine.as_ref())
            })
            .collect();
        let oracle = Oracle::new(&shapes);

        // Until here there is nothing to be kept, and a signal ends the process at once.
        let cancel = interrupt::watch()?;
        let mut recorder =
            self.report.as_deref().map(|p| RecordWriter::create(p, &contenders)).transpose()?;
        let mut failure: Option<OutputError> = None;
        let bar = Bar::new(self.quiet);
        let total = rays.count();
        let mut on_progress = |progress: parity::Progress| {
            bar.show(progress.done, progress.total, |elapsed| {
                rays_per_second(progress.done, elapsed)
            });
            if let Some(recorder) = &mut recorder {
                let written = progress.disagreements.iter().try_for_each(|d| recorder.write(d));
                failure = written.err();
            }
            if failure.is_some() {
                cancel.store(true, Ordering::Relaxed);
            }
        };
        let report = parity::run(&oracle, &contenders, rays.as_ref(), &mut on_progress, &cancel);
        bar.finish();
        if let Some(failure) = failure {
            return Err(failure.into());
        }
        recorder.map_or(Ok(()), RecordWriter::finish)?;
        print(report.to_string().as_bytes())?;
        let is_complete = report.rays == total;
        if !is_complete {
            warn(format!("interrupted: the table is about {} of {total} rays", report.rays));
        }
        let mut over: Vec<_> = report.over_budget().map(|row| row.name.as_str()).collect();
        over.dedup();
        let over = (!over.is_empty()).then(|| OverBudget(over.join("; ")));
        match over {
            Some(over) if is_complete => Err(over.into()),
            over => {
                over.iter().for_each(|over| warn(over.to_string()));
                Ok(if is_complete { Ending::Done } else { Ending::Interrupted })
            }
        }
    }

    /// Which reader a file wants is said by its name, a last `.gz` aside.
    fn load(&self, limits: &Limits) -> Result<Subject, Failure> {
        mesh::refuse_foreign(&self.input)?;
        let format = MeshFormat::of(&self.input);
        if format.is_some() && !self.defines.is_empty() {
            warn("`--define` changes nothing: it is for scene files, and this is a mesh");
        }
        if let Some(format) = format {
            let options = MeshOptions { limits: limits.clone(), ..MeshOptions::default() };
            Ok(self.mesh(format.load(&self.input, &options)?))
        } else {
            // Rays come from the camera's place, whichever side of the picture its axes point to.
            let nori_x = Some(NoriX::default());
            let (defines, limits) = (self.defines.clone(), limits.clone());
            let options = LoadOptions { defines, nori_x, limits };
            let loaded = load_scene(&self.input, &options).map_err(|e| Failure::of_scene(&e))?;
            message::warn_of_scene(&loaded.warnings);
            let description = loaded.description;
            let view = (description.camera, description.camera_motion);
            Ok(Subject { shapes: description.scene.shapes(), view: Some(view) })
        }
    }

    fn mesh(&self, loaded: LoadedMesh) -> Subject {
        for warning in loaded.warnings() {
            warn(format!("{}: {warning}", self.input.display()));
        }
        Subject { shapes: vec![Arc::new(loaded.mesh)], view: None }
    }
}
