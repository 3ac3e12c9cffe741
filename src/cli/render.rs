//! `telamon render`.

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use clap::Args;
use clap::error::ErrorKind;
use telamon::camera::Camera;
use telamon::film::exr::Metadata;
use telamon::film::output::{FileFormat, OutputError, check_writable};
use telamon::film::picture::Picture;
use telamon::film::{AovKind, AovLayer, Crop};
use telamon::intersect::{self, Intersector};
use telamon::load::mesh::MeshFormat;
use telamon::load::{LoadOptions, load_text};
use telamon::memory::Limits;
use telamon::render::{Description, Ended, MOST_THREADS, Preview, Progress, render};
use telamon::sampler::SamplerKind;

use super::finished::{Finished, samples_per_pixel};
use super::live::{Live, Viewer, Waiting};
use super::message::{Failure, say, warn};
use super::progress::Bar;
use super::values::{self, Output, Size};
use super::{Ending, Input, effort, interrupt, picture, turntable, usage};

/// Render a scene, or a mesh, to picture files
#[derive(Args, Debug)]
#[command(
    after_help = "Ctrl-C, SIGTERM and SIGHUP stop the render and write what is there; a second one ends it at \
                  once. A picture that cannot be written where it should go goes beside, or else into the \
                  folder for temporary files (TMPDIR); the exit code is 3 then.\n\n\
                  Example: telamon render scene.xml -o picture.exr -o picture.png --spp 64\n\
                  Example: telamon render bust.ply -o bust.png --view front --material marble"
)]
pub(super) struct Arguments {
    #[command(flatten)]
    input: Input,

    /// Picture to write, .exr or .png; may be repeated [default: the scene's name with .exr, or the
    /// mesh's with .png, in the current folder]
    #[arg(
        short,
        long = "output",
        value_name = "FILE",
        value_parser = values::output,
        help_heading = "Output"
    )]
    outputs: Vec<Output>,

    /// Brighten PNG files by this many powers of 2
    #[arg(
        long,
        value_name = "STOPS",
        default_value = "0",
        allow_hyphen_values = true,
        value_parser = values::stops,
        help_heading = "Output"
    )]
    exposure: f32,

    /// Add layers to EXR files that say how much the samples of each pixel vary: variance.R, .G and
    /// .B, and samples.N
    #[arg(
        long,
        help_heading = "Output",
        long_help = "Add layers to EXR files that say how much the samples of each pixel vary: \
                     variance.R, .G and .B, the sample variance of one sample (infinite for a single \
                     one), and samples.N, their number. Their quotient is the variance of the pixel's \
                     mean if the samples are independent; those of a low-discrepancy sampler vary as \
                     much one by one, but their mean varies less than that."
    )]
    variance: bool,

    /// Show the picture while it is rendered: in tev, on a page of this machine for a browser, or in the
    /// terminal; may be repeated
    #[arg(
        long,
        value_name = "VIEWER",
        help_heading = "Output",
        long_help = "Show the picture while it is rendered; may be repeated. `tev` or `tev:HOST:PORT` sends it to \
                     the viewer tev, by default at 127.0.0.1:14158; it may be started later, and again. `web` or \
                     `web:PORT` serves a page on 127.0.0.1 for a browser; its address, which nobody can guess, is \
                     said at the beginning. The page stays when the render has ended. `terminal` draws it where \
                     the program runs, with kitty's graphics protocol in kitty, WezTerm and Ghostty and as half \
                     blocks of 24-bit colour elsewhere. With --turntable one picture after the other is shown. A \
                     viewer changes nothing of the picture, and none can hold the render up."
    )]
    live: Vec<Viewer>,

    /// Say nothing but warnings and errors, and where `--live web` is
    #[arg(short, long, help_heading = "Output")]
    quiet: bool,

    /// Columns and rows of the whole picture; a crop scales with it, and the field of view across
    /// the width stays [default: the scene's; 800x600 for a mesh]
    #[arg(long, value_name = "WxH", value_parser = values::size, help_heading = "Picture")]
    size: Option<Size>,

    /// Render only this part: first column and row, columns and rows [default: the scene's]
    #[arg(long, value_name = "X,Y,W,H", value_parser = values::crop, help_heading = "Picture")]
    crop: Option<Crop>,

    /// Go around the mesh in so many pictures; names need a place for their numbers, such as -o
    /// 'bust_%03d.png'
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(2..=100_000),
        help_heading = "Picture"
    )]
    turntable: Option<u32>,

    #[command(flatten)]
    effort: effort::Options,

    /// Scale samples down whose largest component exceeds this: less noise, and a picture that is too
    /// dark by what `telamon measure --vary clamp=none,RADIANCE` says
    #[arg(
        long,
        value_name = "RADIANCE",
        value_parser = values::radiance,
        help_heading = "Sampling"
    )]
    clamp: Option<f32>,

    /// Random numbers: unrelated ones, or such as are spread evenly [default: the scene's]
    #[arg(
        long,
        value_name = "KIND",
        value_parser = values::samplers(),
        help_heading = "Sampling"
    )]
    sampler: Option<SamplerKind>,

    /// Seed of the random numbers [default: the scene's]
    #[arg(long, value_name = "N", help_heading = "Sampling")]
    seed: Option<u64>,

    /// Threads; the picture does not depend on it [default: one for each processor]
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS.into()),
        help_heading = "Sampling"
    )]
    threads: Option<u16>,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<Ending, Failure> {
        let outputs = self.outputs();
        if self.turntable.is_some() && turntable::outputs(&outputs, 0).is_none() {
            let message = "`--turntable` needs a place for the number in the name of each picture, such as -o \
                           'bust_%03d.png'";
            usage(ErrorKind::ArgumentConflict, message);
        }
        // All that can be known before an hour of rendering is said before.
        Failure::all(outputs.iter().filter_map(|o| check_writable(&o.path).err()).map(Into::into))
            .map_or(Ok(()), Err)?;
        if self.exposure != 0.0 && outputs.iter().all(|o| o.format != FileFormat::Png) {
            warn("`--exposure` changes nothing: it is for PNG files, and none is asked for");
        }
        if self.variance && outputs.iter().all(|o| o.format != FileFormat::Exr) {
            warn("`--variance` changes nothing: it is for EXR files, and none is asked for");
        }
        let viewers = Waiting::open(&self.live)?;
        // 0 stands for one thread a processor.
        let threads = usize::from(self.threads.unwrap_or(0));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        pool.install(|| self.load_and_render(&outputs, viewers))
    }

    fn outputs(&self) -> Vec<Output> {
        if !self.outputs.is_empty() {
            return self.outputs.clone();
        }
        let scene = &self.input.scene;
        let is_mesh = MeshFormat::of(scene).is_some();
        let name = scene.file_stem().unwrap_or("picture".as_ref());
        let packed = scene.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
        let name = if packed { Path::new(name).file_stem().unwrap_or(name) } else { name };
        let format = if is_mesh { FileFormat::Png } else { FileFormat::Exr };
        let mut name = name.to_owned();
        if self.turntable.is_some() {
            name.push("_%03d");
        }
        // Appended, and not set as the extension: a scene `box.v2.xml` makes `box.v2.exr`.
        name.push(if is_mesh { ".png" } else { ".exr" });
        vec![Output { path: name.into(), format }]
    }

    fn load_and_render(&self, outputs: &[Output], viewers: Waiting) -> Result<Ending, Failure> {
        let accel = self.input.accel();
        let start = Instant::now();
        let limits = self.input.resources.limits();
        let (mut description, cameras) = self.load(&limits)?;
        self.adjust(&mut description)?;
        limits.claim(telamon::render::bytes(&description))?;
        if !viewers.is_empty() {
            description.effort.coarse_first = true;
            limits.claim(Preview::bytes(&description))?;
        }
        let layers_alone = description.integrator.picture().is_none();
        if self.variance && layers_alone {
            warn("`--variance` changes nothing: the scene makes layers alone");
        }
        check_formats(&description, outputs)?;
        let load = start.elapsed();

        let start = Instant::now();
        let shapes = description.scene.shapes();
        limits.claim(accel.estimated_bytes(&shapes))?;
        let engine = intersect::build(accel, &shapes)?;
        let build = start.elapsed();

        let cancel = interrupt::watch()?;
        let bar = Bar::new(self.quiet);
        let beside = bar.clone();
        let aside = move |write: &dyn Fn()| beside.suspend(write);
        let live = viewers.start(&description, self.input.scene.display().to_string(), aside)?;
        let watched = Watched { bar, live };
        let timings = [load, build];
        if cameras.is_empty() {
            let finished = self.render(&description, engine.as_ref(), timings, &cancel, &watched);
            watched.live.end(&finished.statistics);
            return watched.live.say(|| self.conclude(&finished, outputs));
        }
        let mut ending = Ending::Done;
        let last = cameras.len() - 1;
        for (number, camera) in cameras.into_iter().enumerate() {
            description.camera = camera;
            watched.live.begin();
            let finished = self.render(&description, engine.as_ref(), timings, &cancel, &watched);
            if number == last || finished.statistics.ended == Ended::Cancelled {
                watched.live.end(&finished.statistics);
            }
            let outputs = turntable::outputs(outputs, number as u32).unwrap_or_default();
            match watched.live.say(|| self.conclude(&finished, &outputs))? {
                Ending::Interrupted => return Ok(Ending::Interrupted),
                Ending::Elsewhere => ending = Ending::Elsewhere,
                Ending::Done => {}
            }
        }
        Ok(ending)
    }

    /// The scene, and the cameras of a turntable.
    fn load(&self, limits: &Limits) -> Result<(Description, Vec<Camera>), Failure> {
        let Some(turntable) = self.turntable else {
            let loaded = self.input.load(limits, self.size, self.quiet)?;
            return Ok((loaded.description, Vec::new()));
        };
        let Some(studio) = self.input.studio(self.size, turntable)? else {
            let scene = self.input.scene.display();
            let message = format!("`--turntable` is for meshes, and `{scene}` is a scene file");
            usage(ErrorKind::ArgumentConflict, &message);
        };
        let mut cameras = Vec::new();
        for text in studio.cameras() {
            let loaded = load_text(&text, &studio.name(), &LoadOptions::default());
            cameras.push(loaded.map_err(|e| Failure::of_scene(&e))?.description.camera);
        }
        let loaded = self.input.load_studio(&studio, limits, self.quiet)?;
        Ok((loaded.description, cameras))
    }

    fn render(
        &self,
        description: &Description,
        engine: &dyn Intersector,
        [load, build]: [Duration; 2],
        cancel: &AtomicBool,
        Watched { bar, live }: &Watched,
    ) -> Finished {
        bar.begin();
        let on_progress = |progress: Progress<'_>| {
            live.update(&progress);
            bar.update(&progress);
        };
        let (film, statistics) = render(description, engine, &on_progress, cancel);
        bar.finish();
        let metadata = Metadata {
            scene: self.input.scene.display().to_string(),
            sampler: description.sampler.kind.to_string(),
            seed: description.sampler.seed,
            samples_per_pixel: statistics.samples_per_pixel,
            load,
            build,
            render: statistics.elapsed,
            backend: engine.name(),
            rel_mse: statistics.errors.map(|e| e.rel_mse),
            noise_level: statistics.errors.map(|e| e.noise_level),
        };
        Finished {
            picture: Picture::from_film(&film),
            metadata,
            statistics,
            asked: description.sampler.samples_per_pixel,
            effort: description.effort,
            threads: rayon::current_num_threads(),
        }
    }

    /// Puts options in the place of the scene's own settings.
    fn adjust(&self, description: &mut Description) -> Result<(), Failure> {
        if let Some(crop) = self.crop {
            description.crop_to(crop)?;
        }
        let sampler = &mut description.sampler;
        sampler.seed = self.seed.unwrap_or(sampler.seed);
        sampler.kind = self.sampler.unwrap_or(sampler.kind);
        description.film.variance = self.variance;
        description.film.clamp = self.clamp;
        self.effort.adjust(description)?;
        Ok(())
    }

    /// Writes the files and says what was done.
    fn conclude(&self, finished: &Finished, outputs: &[Output]) -> Result<Ending, Failure> {
        let Finished { statistics, asked, effort, .. } = finished;
        if statistics.samples == 0 {
            warn("interrupted before the first sample; nothing is written");
            return Ok(Ending::Interrupted);
        }
        finished.warn();
        let mut failures = Vec::new();
        let mut places = Vec::new();
        for output in outputs {
            match picture::write(output, &finished.picture, &finished.metadata, self.exposure) {
                Ok(place) => places.push(place),
                Err(failure) => failures.push(failure),
            }
        }
        Failure::all(failures).map_or(Ok(()), Err)?;
        let elsewhere = outputs.iter().zip(&places).any(|(o, place)| o.path != *place);

        let names: Vec<_> = places.iter().map(|path| path.display().to_string()).collect();
        let names = names.join(" and ");
        let interrupted = statistics.ended == Ended::Cancelled;
        if interrupted {
            let samples = samples_per_pixel(statistics.samples_per_pixel);
            warn(format!("interrupted: {samples} of {asked} samples per pixel are in {names}"));
        }
        if let Some(shortfall) = effort::shortfall(effort, statistics.ended, statistics.errors) {
            warn(shortfall);
        }
        if !self.quiet {
            say(&finished.summary(&names));
        }
        Ok(match (elsewhere, interrupted) {
            (true, _) => Ending::Elsewhere,
            (false, true) => Ending::Interrupted,
            (false, false) => Ending::Done,
        })
    }
}

/// What shows how far a render has come.
struct Watched {
    bar: Bar,
    live: Live,
}

/// Refuses files that cannot hold what the scene makes: PNG files of layers alone, and a variance beside
/// a layer of the same name.
fn check_formats(description: &Description, outputs: &[Output]) -> Result<(), OutputError> {
    let (picture, layers) = (description.integrator.picture(), description.integrator.layers());
    let first = |format| outputs.iter().find(|o| o.format == format).map(|o| o.path.clone());
    if let Some(path) = first(FileFormat::Png).filter(|_| picture.is_none()) {
        return Err(OutputError::NoColors(path));
    }
    let taken = |l: &AovLayer| l.name == "variance" && l.kind == AovKind::Albedo;
    match first(FileFormat::Exr) {
        Some(path)
            if description.film.variance && picture.is_some() && layers.iter().any(taken) =>
        {
            let reason = "there are two channels `variance.R`".to_owned();
            Err(OutputError::Unfit { path, reason })
        }
        _ => Ok(()),
    }
}
