//! The command line: one file a subcommand, and what they share. [`EXIT_CODES`] says how it ends.

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Args, CommandFactory, Parser, Subcommand};
use telamon::intersect::accel::Mode;
use telamon::intersect::{Accel, Backend};
use telamon::load::mesh::MeshFormat;
use telamon::load::{LoadOptions, Loaded, NoriX, load_scene, load_text};
use telamon::memory::Limits;
use telamon::studio::Studio;

mod compare;
mod completions;
mod definitions;
mod effort;
mod excerpt;
mod finished;
mod inspect;
mod interrupt;
mod live;
mod machine;
mod man;
mod measure;
mod memory;
mod mesh;
mod message;
mod parity;
mod picture;
mod progress;
mod render;
mod scene;
mod table;
mod trace;
mod turntable;
mod values;

use message::Failure;
use values::Size;

const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), " (", env!("TELAMON_EMBREE"), ")");

/// For `--help` and the manual page.
const EXIT_CODES: &str = "\
Exit codes:
  0    Everything was done
  1    A failure; what was wrong is on standard error
  2    Bad usage
  3    A picture, or measurements, could not be written where they should go and are in another place, \
which standard error names
  129, 130, 143
       A hang-up (SIGHUP), Ctrl-C (SIGINT) or `kill` (SIGTERM) asked for an end, and what was there is \
written; of a second signal, which ends at once, nothing is. Signals that were ignored when telamon \
started, as by nohup, stay ignored

Example: telamon render scene.xml -o picture.exr -o picture.png --spp 64
\
Example: telamon render bust.ply -o bust.png";

/// A path tracer for large meshes: renders meshes, and Mitsuba 3 scene files, to OpenEXR and PNG.
#[derive(Debug, Parser)]
#[command(
    name = "telamon",
    version = VERSION,
    arg_required_else_help = true,
    after_help = EXIT_CODES
)]
pub(crate) struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Render(render::Arguments),
    Scene(scene::Arguments),
    Inspect(inspect::Arguments),
    Trace(trace::Arguments),
    Compare(compare::Arguments),
    Measure(measure::Arguments),
    Parity(parity::Arguments),
    Completions(completions::Arguments),
    Man(man::Arguments),
}

/// How a command that did not fail ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ending {
    Done,
    /// By a signal, with what there was written.
    Interrupted,
    /// With pictures in other places than they should be.
    Elsewhere,
}

impl From<Ending> for ExitCode {
    fn from(ending: Ending) -> Self {
        match ending {
            Ending::Done => Self::SUCCESS,
            Ending::Interrupted => Self::from(interrupt::exit_code()),
            Ending::Elsewhere => Self::from(3),
        }
    }
}

impl CommandLine {
    pub(crate) fn run(self) -> Result<Ending, Failure> {
        match self.command {
            Command::Render(arguments) => arguments.run(),
            Command::Scene(arguments) => arguments.run().map(|()| Ending::Done),
            Command::Inspect(arguments) => arguments.run().map(|()| Ending::Done),
            Command::Trace(arguments) => arguments.run().map(|()| Ending::Done),
            Command::Measure(arguments) => arguments.run(),
            Command::Parity(arguments) => arguments.run(),
            Command::Compare(arguments) => arguments.run(),
            Command::Completions(arguments) => arguments.run().map(|()| Ending::Done),
            Command::Man(arguments) => arguments.run().map(|()| Ending::Done),
        }
    }
}

/// What every command that reads a scene asks for.
#[derive(Args, Debug)]
struct Input {
    /// Scene file in Mitsuba 3's XML format, or a mesh (.obj, .ply, .stl, .serialized; also with .gz), of
    /// which a scene is made
    #[arg(value_name = "SCENE_OR_MESH")]
    scene: PathBuf,

    /// Replace $NAME in the scene file, in place of its <default>; may be repeated
    #[arg(
        short = 'D',
        long = "define",
        value_name = "NAME=VALUE",
        value_parser = values::define,
        help_heading = "Input"
    )]
    defines: Vec<(String, String)>,

    /// Where the camera's x axis points in a scene of Nori, whose versions differ: at this side of the
    /// picture [default: right, with a note]
    #[arg(long, value_name = "SIDE", value_parser = values::nori_x(), help_heading = "Input")]
    nori_x: Option<NoriX>,

    /// Engine that answers ray queries
    #[arg(
        long,
        value_name = "ENGINE",
        default_value_t = Backend::default(),
        value_parser = backends(),
        help_heading = "Input"
    )]
    backend: Backend,

    /// Set a mode of the engine; may be repeated
    #[arg(
        long,
        value_name = "KEY=VALUE",
        help_heading = "Input",
        long_help = modes_help()
    )]
    accel: Vec<Mode>,

    #[command(flatten)]
    resources: Resources,

    #[command(flatten)]
    mesh: mesh::Presentation,
}

impl Input {
    /// The engine in the modes that are asked for.
    ///
    /// Ends the process, as bad usage does, if the engine does not have them: which modes there are depends
    /// on another option, so clap cannot tell by itself.
    fn accel(&self) -> Accel {
        let mut accel = Accel::from(self.backend);
        for mode in &self.accel {
            if let Err(error) = accel.set(mode) {
                usage(ErrorKind::ValueValidation, &error.to_string());
            }
        }
        accel
    }

    /// What makes another scene of the same file.
    fn defines_of_record(&self) -> Vec<(String, String)> {
        let side = self.nori_x.map(|x| ("--nori-x".to_owned(), x.to_string()));
        self.defines.iter().cloned().chain(side).chain(self.mesh.given()).collect()
    }

    /// What is made of a mesh, for so many pictures around it; `None` if the file is a scene.
    ///
    /// Ends the process, as bad usage does, if options for meshes are given beside a scene.
    fn studio(&self, size: Option<Size>, turntable: u32) -> Result<Option<Studio>, Failure> {
        mesh::refuse_foreign(&self.scene)?;
        if let Some(format) = MeshFormat::of(&self.scene) {
            // What it takes is given back before the scene is loaded.
            let limits = self.resources.limits();
            return self.mesh.studio(&self.scene, format, size, turntable, &limits).map(Some);
        }
        if let Some((option, _)) = self.mesh.given().first() {
            let scene = self.scene.display();
            let message = format!(
                "`{option}` is for meshes, and `{scene}` is a scene file, which says it itself"
            );
            usage(ErrorKind::ArgumentConflict, &message);
        }
        Ok(None)
    }

    /// Loads the scene within `limits`, or what is made of the mesh, for a picture of that size; shows the loader's
    /// warnings and, unless `quiet`, what was chosen for a mesh.
    fn load(&self, limits: &Limits, size: Option<Size>, quiet: bool) -> Result<Loaded, Failure> {
        if let Some(studio) = self.studio(size, 1)? {
            return self.load_studio(&studio, limits, quiet);
        }
        let loaded = load_scene(&self.scene, &self.load_options(limits));
        let mut loaded = loaded.map_err(|e| Failure::of_scene(&e))?;
        message::warn_of_scene(&loaded.warnings);
        if let Some(Size { width, height }) = size {
            loaded.description.resize(width, height)?;
        }
        Ok(loaded)
    }

    fn load_studio(
        &self,
        studio: &Studio,
        limits: &Limits,
        quiet: bool,
    ) -> Result<Loaded, Failure> {
        if !quiet {
            message::say(&studio.choices());
        }
        let loaded = load_text(&studio.scene(), &studio.name(), &self.load_options(limits));
        let loaded = loaded.map_err(|e| Failure::of_mesh(&self.scene, &e))?;
        message::warn_of_mesh(&self.scene, &loaded.warnings);
        Ok(loaded)
    }

    fn load_options(&self, limits: &Limits) -> LoadOptions {
        LoadOptions { defines: self.defines.clone(), nori_x: self.nori_x, limits: limits.clone() }
    }
}

/// Ends the process, as clap does where options make no sense.
fn usage(kind: ErrorKind, message: &str) -> ! {
    CommandLine::command().error(kind, message).exit()
}

/// What a command may take of the machine.
#[derive(Args, Debug)]
struct Resources {
    /// Refuse what needs more memory than this, such as 16G [default: what the machine, the control
    /// group or `ulimit -v` allows]
    #[arg(long, value_name = "SIZE", value_parser = values::bytes, help_heading = "Input")]
    memory: Option<u64>,

    /// Let a compressed file unpack to this, such as 4G [default: 64 times its size, or 256M if that
    /// is more]
    #[arg(long, value_name = "SIZE", value_parser = values::bytes, help_heading = "Input")]
    max_unpacked: Option<u64>,
}

impl Resources {
    /// Limits of which nothing has been claimed yet.
    fn limits(&self) -> Limits {
        Limits::new(self.memory.or_else(memory::there), self.max_unpacked)
    }
}

/// The engines that this build contains, for the help and for completions as well.
fn backends() -> impl TypedValueParser<Value = Backend> {
    let names = Backend::AVAILABLE.iter().map(|b| b.name());
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Backend>())
}

/// The modes of each engine, for the help.
fn modes_help() -> String {
    let mut help = "Set a mode of the engine; may be repeated. Modes and their values:".to_owned();
    for &backend in Backend::AVAILABLE {
        for (key, values) in Accel::modes(backend) {
            help += &format!("\n  {backend}: {key}={}", values.join("|"));
        }
    }
    help
}

/// Writes to standard output. That nobody reads on (`telamon man | head -1`) is no failure.
fn print(bytes: &[u8]) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn definitions_do_not_contradict_each_other() {
        super::CommandLine::command().debug_assert();
    }
}
