//! Renders settings, and takes their time.

use std::fmt::Debug;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::image::Image;
use super::knobs::Setting;
use super::metrics::Metrics;
use super::plan::run_seed;
use crate::intersect::{self, Accel, BuildError, Intersector};
use crate::math::Rgb;
use crate::render::{Description, Ended, Progress, Statistics, render};

/// Why a setting cannot be rendered.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The engine refuses.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The system refuses threads.
    #[error(transparent)]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// How much memory the process has needed, where the system tells.
pub trait MemoryProbe: Debug {
    /// Forgets the peak so far.
    fn reset(&self);
    /// Bytes in use at the peak since then.
    fn peak(&self) -> Option<u64>;
}

/// A scene with all engines and thread pools that its settings need, built once each.
#[derive(Debug)]
pub struct Bench<'a> {
    description: Description,
    engines: Vec<Engine>,
    pools: Vec<rayon::ThreadPool>,
    memory: &'a dyn MemoryProbe,
}

#[derive(Debug)]
struct Engine {
    accel: Accel,
    built: Box<dyn Intersector>,
    build: Duration,
}

/// What one run gave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Label of the setting.
    pub setting: String,
    /// Which repetition of it.
    pub repeat: u32,
    /// Seed of its random numbers.
    pub seed: u64,
    /// Time to render, without loading, building or writing.
    pub seconds: f64,
    /// Time to build its engine, which is done once for all runs.
    pub build_seconds: f64,
    /// Rays traced.
    pub rays: u64,
    /// Samples taken.
    pub samples: u64,
    /// Samples that were not finite and are left out.
    pub non_finite_samples: u64,
    /// Largest memory of the process during the render, without engines of other settings.
    pub peak_bytes: Option<u64>,
    /// How good the picture is.
    pub metrics: Metrics,
}

/// A picture, how it came about, and the memory that it took.
type Rendered = (Image, Statistics, Option<u64>);

impl<'a> Bench<'a> {
    /// Prepares what `settings` need.
    ///
    /// # Errors
    /// What an engine or the system refuses.
    pub fn new<'s>(
        description: Description,
        settings: impl IntoIterator<Item = &'s Setting>,
        memory: &'a dyn MemoryProbe,
    ) -> Result<Self, BenchError> {
        let mut bench = Self { description, engines: Vec::new(), pools: Vec::new(), memory };
        for setting in settings {
            bench.prepare(setting)?;
        }
        Ok(bench)
    }

    fn prepare(&mut self, setting: &Setting) -> Result<(), BenchError> {
        if !self.pools.iter().any(|p| p.current_num_threads() == setting.threads) {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(setting.threads).build()?;
            self.pools.push(pool);
        }
        if !self.engines.iter().any(|e| e.accel == setting.accel) {
            let shapes = self.description.scene.shapes();
            let start = Instant::now();
            // By as many threads as a plain render would use.
            let pool = self.pool(setting);
            let built = pool.install(|| intersect::build(setting.accel, &shapes))?;
            let build = start.elapsed();
            self.engines.push(Engine { accel: setting.accel, built, build });
        }
        Ok(())
    }

    fn pool(&self, setting: &Setting) -> &rayon::ThreadPool {
        let found = self.pools.iter().find(|p| p.current_num_threads() == setting.threads);
        found.expect("settings are prepared before they are rendered")
    }

    fn engine(&self, setting: &Setting) -> &Engine {
        let found = self.engines.iter().find(|e| e.accel == setting.accel);
        found.expect("settings are prepared before they are rendered")
    }

    /// The scene.
    #[must_use]
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The scene, of which the film may be changed.
    pub fn description_mut(&mut self) -> &mut Description {
        &mut self.description
    }

    /// Names and versions of the engines.
    #[must_use]
    pub fn engines(&self) -> Vec<String> {
        self.engines.iter().map(|e| e.built.name()).collect()
    }

    /// The picture of a setting; `None` if `cancel` became true before it was complete.
    ///
    /// # Panics
    /// If the setting was not among those that the bench was made for.
    pub fn picture(
        &mut self,
        setting: &Setting,
        seed: u64,
        on_progress: &(dyn Fn(Progress<'_>) + Sync),
        cancel: &AtomicBool,
    ) -> Option<Rendered> {
        setting.apply(&mut self.description, seed);
        let engine = self.engine(setting);
        self.memory.reset();
        let (film, statistics) = self
            .pool(setting)
            .install(|| render(&self.description, engine.built.as_ref(), on_progress, cancel));
        let others = self.engines.iter().filter(|e| e.accel != setting.accel);
        let idle: usize = others.map(|e| e.built.bytes()).sum();
        let peak = self.memory.peak().map(|bytes| bytes.saturating_sub(idle as u64));
        let complete = statistics.ended != Ended::Cancelled;
        complete.then(|| (Image::from_film(&film), statistics, peak))
    }

    /// One run of a setting, measured against `reference`; `None` if it was cancelled, or if no pixel is
    /// finite in both pictures.
    pub fn run(
        &mut self,
        (label, setting): (&str, &Setting),
        repeat: u32,
        experiment_seed: u64,
        reference: &Image,
        cancel: &AtomicBool,
    ) -> Option<Run> {
        let seed = run_seed(experiment_seed, label, repeat);
        let (image, statistics, peak_bytes) = self.picture(setting, seed, &|_| (), cancel)?;
        Some(Run {
            setting: label.to_owned(),
            repeat,
            seed,
            seconds: statistics.elapsed.as_secs_f64(),
            build_seconds: self.engine(setting).build.as_secs_f64(),
            rays: statistics.rays.total(),
            samples: statistics.samples,
            non_finite_samples: statistics.non_finite,
            peak_bytes,
            metrics: Metrics::of(&image, reference)?,
        })
    }
}

/// Independent renders that a reference is the mean of: enough for the spread between them to say how
/// far it can be trusted, with any sampler.
pub const REFERENCE_PARTS: u32 = 16;

/// Renders a reference: the mean of [`REFERENCE_PARTS`] renders of `setting` with seeds of their own, whose spread
/// gives the variance of its pixels. Each has the setting's samples divided by their number, rounded up.
/// `None` if it was cancelled. `on_progress` is told the fraction that is done.
pub fn render_reference(
    bench: &mut Bench<'_>,
    setting: &Setting,
    seed: u64,
    on_progress: &(dyn Fn(f64) + Sync),
    cancel: &AtomicBool,
) -> Option<Image> {
    let samples_per_pixel = setting.samples_per_pixel.div_ceil(REFERENCE_PARTS);
    let part = Setting { samples_per_pixel, ..setting.clone() };
    let mut sums: Vec<(DVec3, DVec3)> = Vec::new();
    let mut image = None;
    for k in 0..REFERENCE_PARTS {
        let progress = |p: Progress<'_>| {
            let done = p.samples_done as f64 / p.samples_total as f64;
            on_progress((f64::from(k) + done) / f64::from(REFERENCE_PARTS));
        };
        let seed = run_seed(seed, "reference", k);
        let (picture, ..) = bench.picture(&part, seed, &progress, cancel)?;
        sums.resize(picture.pixels.len(), Default::default());
        // Welford 1962.
        for ((mean, squares), rgb) in sums.iter_mut().zip(&picture.pixels) {
            let deviation = rgb.as_dvec3() - *mean;
            *mean += deviation / f64::from(k + 1);
            *squares += deviation * (rgb.as_dvec3() - *mean);
        }
        image = Some(picture);
    }
    let parts = f64::from(REFERENCE_PARTS);
    let of_mean = 1.0 / (parts * (parts - 1.0));
    let mut image = image?;
    image.pixels = sums.iter().map(|(mean, _)| mean.as_vec3a()).collect();
    image.variance = Some(sums.iter().map(|(_, s)| (*s * of_mean).as_vec3a()).collect());
    Some(image)
}

/// Standard error of an image's mean over pixels and channels, from the variances of its pixels; 0 where
/// they are not known. Channels of a pixel share their paths, so their errors count as one.
#[must_use]
pub fn mean_error(image: &Image) -> f64 {
    image.variance.as_ref().map_or(0.0, |variance| {
        let pixel = |v: &Rgb| {
            let deviations = v.to_array().map(|c| f64::from(c).sqrt());
            (deviations.iter().sum::<f64>() / 3.0).powi(2)
        };
        let finite: Vec<f64> = variance.iter().filter(|v| v.is_finite()).map(pixel).collect();
        finite.iter().sum::<f64>().sqrt() / finite.len() as f64
    })
}
