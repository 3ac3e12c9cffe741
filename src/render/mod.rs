//! Passes over tiles, in parallel, and one sample by itself.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use glam::DVec2;
use rayon::prelude::*;

use crate::film::{Content, Film, FilterSampler, Tile};
use crate::integrator::{self, Aov, Integrator, RayCounts, Tracer};
use crate::intersect::Intersector;
use crate::math::Rgb;
use crate::ray::Ray;
use crate::sampler::{self, PathSampler, Sampler};
use crate::scene::Description;
use crate::scene::settings::IntegratorSettings;

mod trace;

pub use trace::{Edge, Trace, trace};

/// Samples that a pass adds to each pixel at most: early passes are short, so that there is a whole
/// picture soon, later ones long, so that a tile's rays stay in the cache.
const LONGEST_PASS: u32 = 64;

/// How far a render has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Samples taken.
    pub samples_done: u64,
    /// Samples to take in all.
    pub samples_total: u64,
    /// Rays traced.
    pub rays: u64,
}

/// What a render did.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    /// Samples (paths from the camera) taken.
    pub samples: u64,
    /// Rays traced.
    pub rays: RayCounts,
    /// Samples whose value was not a finite number. They are left out of the picture: a number above
    /// 0 in a scene of finite values is a bug.
    pub non_finite: u64,
    /// The first of them, with which each can be traced again.
    pub non_finite_examples: Vec<SampleId>,
    /// Smallest and largest number of samples that any pixel has; they differ if it was cancelled.
    pub samples_per_pixel: (u32, u32),
    /// Time in this function.
    pub elapsed: Duration,
}

/// One sample of one pixel: together with the seed all that its path depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SampleId {
    /// Column on the whole film.
    pub x: u32,
    /// Row on the whole film.
    pub y: u32,
    /// Index of the sample.
    pub sample: u32,
}

/// Examples of non-finite samples to keep.
const EXAMPLES: usize = 8;

/// Renders `description` with `engine`, which must have been built over its scene's shapes, in the
/// current thread pool.
///
/// The film does not depend on the number of threads. `on_progress` is called now and then, from any
/// of them. Once `cancel` is true, tiles that have not begun are left as they are.
pub fn render(
    description: &Description,
    engine: &dyn Intersector,
    on_progress: &(dyn Fn(Progress) + Sync),
    cancel: &AtomicBool,
) -> (Film, Statistics) {
    let start = Instant::now();
    let renderer = Renderer::new(description, engine);
    let mut film = Film::new(&description.film, renderer.content.clone());
    let samples_per_pixel = description.sampler.samples_per_pixel;
    let crop = description.film.crop;
    let samples_total =
        u64::from(crop.width) * u64::from(crop.height) * u64::from(samples_per_pixel);
    let (samples_done, rays) = (AtomicU64::new(0), AtomicU64::new(0));

    let mut tally = Tally::default();
    let mut done = 0;
    while done < samples_per_pixel && !cancel.load(Ordering::Relaxed) {
        let end = done + done.clamp(1, LONGEST_PASS).min(samples_per_pixel - done);
        let pass = film
            .tiles_mut()
            .par_iter_mut()
            .with_max_len(1)
            .filter(|_| !cancel.load(Ordering::Relaxed))
            .map(|tile| {
                let tally = renderer.add_samples(tile, end);
                let samples_done =
                    samples_done.fetch_add(tally.samples, Ordering::Relaxed) + tally.samples;
                let traced = tally.rays.total();
                let rays = rays.fetch_add(traced, Ordering::Relaxed) + traced;
                on_progress(Progress { samples_done, samples_total, rays });
                tally
            })
            .reduce(Tally::default, Tally::merge);
        tally = tally.merge(pass);
        done = end;
    }

    let statistics = Statistics {
        samples: tally.samples,
        rays: tally.rays,
        non_finite: tally.non_finite,
        non_finite_examples: tally.examples,
        samples_per_pixel: film.samples_per_pixel(),
        elapsed: start.elapsed(),
    };
    (film, statistics)
}

/// What a tile's samples need.
struct Renderer<'a> {
    description: &'a Description,
    engine: &'a dyn Intersector,
    sampler: Box<dyn Sampler>,
    filter: FilterSampler,
    content: Content,
    picture: Option<Box<dyn Integrator>>,
    aov: Option<Aov<'a>>,
}

impl<'a> Renderer<'a> {
    fn new(description: &'a Description, engine: &'a dyn Intersector) -> Self {
        let (picture, aov) = integrator::build(&description.integrator, &description.scene);
        let layers = match &description.integrator {
            IntegratorSettings::Aov { layers, .. } => layers.clone(),
            _ => Vec::new(),
        };
        Self {
            description,
            engine,
            sampler: sampler::build(&description.sampler),
            filter: FilterSampler::new(description.film.filter),
            content: Content {
                picture: picture.is_some(),
                variance: picture.is_some() && description.film.variance,
                layers,
            },
            picture,
            aov,
        }
    }

    /// Adds samples to a tile until each of its pixels has `end`.
    fn add_samples(&self, tile: &mut Tile, end: u32) -> Tally {
        let mut tally = Tally::default();
        let mut tracer = Tracer::new(&self.description.scene, self.engine);
        for (pixel, (x, y)) in tile.pixels().enumerate() {
            for sample in tile.samples(pixel)..end {
                let id = SampleId { x, y, sample };
                if !self.add_sample(tile, pixel, id, &mut tracer) {
                    tally.non_finite += 1;
                    if tally.examples.len() < EXAMPLES {
                        tally.examples.push(id);
                    }
                }
                tile.count(pixel);
                tally.samples += 1;
            }
        }
        tally.rays = tracer.counts;
        tally
    }

    /// The camera ray of a sample, and the numbers of the rest of its path.
    fn begin(&self, id: SampleId) -> (Ray, PathSampler<'_>) {
        let film = &self.description.film;
        let mut sampler =
            PathSampler::new(self.sampler.as_ref(), id.y * film.width + id.x, id.sample);
        let offset = self.filter.sample(sampler.next_2d());
        // In f64: an f32 would put what lies at the end of pixel 1000 on the next one.
        let center = DVec2::new(f64::from(id.x) + 0.5, f64::from(id.y) + 0.5);
        let size = DVec2::new(film.width.into(), film.height.into());
        (self.description.camera.ray((center + offset.as_dvec2()) / size), sampler)
    }

    /// Adds one sample; whether its value was finite.
    fn add_sample(
        &self,
        tile: &mut Tile,
        pixel: usize,
        id: SampleId,
        tracer: &mut Tracer<'_>,
    ) -> bool {
        let (ray, mut sampler) = self.begin(id);
        let mut finite = true;
        if let Some(integrator) = &self.picture {
            let estimate = integrator.estimate(tracer, &ray, &mut sampler);
            finite = estimate.radiance.is_finite();
            if finite {
                tile.add_picture(pixel, estimate.radiance, estimate.alpha);
            } else {
                // It counts as a sample, so that the numbers of samples stay alike.
                tile.add_picture(pixel, Rgb::ZERO, 0.0);
            }
        }
        if let Some(aov) = &self.aov {
            let (numbers, indices) = tile.layers_mut(pixel);
            let (mut numbers, mut indices) = (numbers.iter_mut(), indices.iter_mut());
            aov.evaluate(
                tracer,
                &ray,
                |value| *numbers.next().expect("as many as components") += f64::from(value),
                |value| {
                    let slot = indices.next().expect("as many as layers");
                    if id.sample == 0 {
                        *slot = value;
                    }
                },
            );
        }
        finite
    }
}

/// Counts of one or more tiles.
#[derive(Default)]
struct Tally {
    samples: u64,
    rays: RayCounts,
    non_finite: u64,
    examples: Vec<SampleId>,
}

impl Tally {
    fn merge(mut self, other: Self) -> Self {
        self.samples += other.samples;
        self.rays += other.rays;
        self.non_finite += other.non_finite;
        self.examples.extend(other.examples);
        // The smallest, so that they do not depend on which tile came first.
        self.examples.sort_unstable();
        self.examples.truncate(EXAMPLES);
        self
    }
}
