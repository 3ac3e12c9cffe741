//! Passes over tiles, in parallel, and one sample by itself.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use rayon::prelude::*;

use crate::film::picture::Picture;
use crate::film::{Content, Film, FilterSampler, Tile};
use crate::integrator::{self, Aov, Estimate, Integrator, RayCounts, Tracer};
use crate::intersect::Intersector;
use crate::math::Rgb;
use crate::ray::Ray;
use crate::sampler::{self, Sampler, SamplerSettings};

mod allocation;
mod beginning;
pub mod description;
pub mod effort;
pub mod requirements;
pub mod resize;
mod schedule;
mod trace;

pub use allocation::FIRST_ALLOCATION;
pub use description::Description;
pub use effort::Effort;
pub use requirements::Requirements;
use schedule::Schedule;
pub use schedule::{Ended, Errors};
pub use trace::{Edge, Trace, trace};

/// How far a render has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Samples taken.
    pub samples_done: u64,
    /// Samples to take in all; a guess that changes if time or error end the render.
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
    /// Smallest and largest number of samples that any pixel has; they differ if it was cancelled, or adaptive.
    pub samples_per_pixel: (u32, u32),
    /// Why it ended.
    pub ended: Ended,
    /// What is known of the picture's error, if an error was asked for.
    pub errors: Option<Errors>,
    /// Time in this function.
    pub elapsed: Duration,
}

/// One sample of one pixel: all that its path depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SampleId {
    /// Column on the whole film.
    pub x: u32,
    /// Row on the whole film.
    pub y: u32,
    /// Index of the sample.
    pub sample: u32,
    /// Seed of its numbers: the scene's, or that of the second half.
    pub seed: u64,
}

/// The most threads that can be asked for.
pub const MOST_THREADS: u16 = 1024;

/// Examples of non-finite samples to keep.
const EXAMPLES: usize = 8;

/// Told apart from the seed itself, so that both halves of a film have unrelated numbers.
const SECOND_HALF: u64 = 0x5851_f42d_4c95_7f2d;

/// Renders `description` with `engine`, which must have been built over its scene's shapes, in the
/// current thread pool.
///
/// The film does not depend on the number of threads, and but for the number of samples neither on time.
/// `on_progress` is called now and then, from any of them. Once `cancel` is true, tiles that have not
/// begun are left as they are.
///
/// If an error is to be reached, the samples of each pixel are drawn in two independent halves, and the
/// picture is another one than without.
pub fn render(
    description: &Description,
    engine: &dyn Intersector,
    on_progress: &(dyn Fn(Progress) + Sync),
    cancel: &AtomicBool,
) -> (Film, Statistics) {
    let mut schedule = Schedule::new(description);
    let renderer = Renderer::new(description, engine);
    let mut film = Film::new(&description.film, renderer.content.clone());
    let crop = description.film.crop;
    let pixels = u64::from(crop.width) * u64::from(crop.height);
    let (samples_done, rays) = (AtomicU64::new(0), AtomicU64::new(0));

    let mut tally = Tally::default();
    let mut done = 0;
    let ended = loop {
        let end = match schedule.next(done) {
            Ok(_) if cancel.load(Ordering::Relaxed) => break Ended::Cancelled,
            Ok(end) => end,
            Err(ended) => break ended,
        };
        let samples_total = (schedule.expected_total(done) * pixels as f64) as u64;
        let ends = renderer.ends(&film, done, end);
        let begin = schedule.elapsed();
        let pass = film
            .tiles_mut()
            .par_iter_mut()
            .zip(&ends)
            .with_max_len(1)
            .filter(|_| !cancel.load(Ordering::Relaxed))
            .map(|(tile, ends)| {
                let tally = renderer.add_samples(tile, ends);
                let samples_done =
                    samples_done.fetch_add(tally.samples, Ordering::Relaxed) + tally.samples;
                let traced = tally.rays.total();
                let rays = rays.fetch_add(traced, Ordering::Relaxed) + traced;
                let samples_total = samples_total.max(samples_done);
                on_progress(Progress { samples_done, samples_total, rays });
                tally
            })
            .reduce(Tally::default, Tally::merge);
        let whole = pass.tiles == ends.len();
        tally = tally.merge(pass);
        if !whole {
            break Ended::Cancelled;
        }
        let elapsed = schedule.elapsed() - begin;
        schedule.look(&film, end, end - done, elapsed);
        done = end;
    };

    let statistics = Statistics {
        samples: tally.samples,
        rays: tally.rays,
        non_finite: tally.non_finite,
        non_finite_examples: tally.examples,
        samples_per_pixel: film.samples_per_pixel(),
        ended,
        errors: Errors::of(&film),
        elapsed: schedule.elapsed(),
    };
    (film, statistics)
}

/// Bytes of memory that a render of `description` takes at least, its scene and engine aside: its film, and
/// the picture that is made of it.
#[must_use]
pub fn bytes(description: &Description) -> u64 {
    let content = content(description);
    let film = Film::bytes(&description.film, &content);
    film.saturating_add(Picture::bytes(&description.film, &content))
}

/// What is kept of the samples.
fn content(description: &Description) -> Content {
    let Description { film, effort, integrator, .. } = description;
    let picture = integrator.picture().is_some();
    Content {
        picture,
        variance: picture && (film.variance || effort.adaptive),
        halves: picture && effort.needs_halves(),
        layers: integrator.layers().to_vec(),
    }
}

/// What a tile's samples need.
struct Renderer<'a> {
    description: &'a Description,
    engine: &'a dyn Intersector,
    /// Seed and numbers of each half of the samples.
    samplers: Vec<(u64, Box<dyn Sampler>)>,
    filter: FilterSampler,
    /// Whether samples have a time.
    moves: bool,
    content: Content,
    picture: Option<Box<dyn Integrator>>,
    aov: Option<Aov<'a>>,
}

impl<'a> Renderer<'a> {
    fn new(description: &'a Description, engine: &'a dyn Intersector) -> Self {
        let (picture, aov) = integrator::build(&description.integrator, &description.scene);
        let content = content(description);
        let seed = description.sampler.seed;
        let seeds = if content.halves { vec![seed, seed ^ SECOND_HALF] } else { vec![seed] };
        let sampler =
            |seed| (seed, sampler::build(&SamplerSettings { seed, ..description.sampler }));
        Self {
            description,
            engine,
            samplers: seeds.into_iter().map(sampler).collect(),
            filter: FilterSampler::new(description.film.filter),
            moves: description.moves(),
            content,
            picture,
            aov,
        }
    }

    /// For each tile the samples that each half of its pixels has after the next pass, which brings the mean
    /// of both together from `done` to `mean`. The first half has one more of an odd number.
    fn ends(&self, film: &Film, done: u32, mean: u32) -> Vec<[u32; 2]> {
        if self.adaptive() {
            allocation::allocate(film, done, mean)
        } else if self.content.halves {
            vec![[mean.div_ceil(2), mean / 2]; film.tiles().len()]
        } else {
            vec![[mean, 0]; film.tiles().len()]
        }
    }

    fn adaptive(&self) -> bool {
        self.content.halves && self.description.effort.adaptive
    }

    /// Adds samples to a tile until each half of its pixels has as many as `ends` says.
    fn add_samples(&self, tile: &mut Tile, ends: &[u32; 2]) -> Tally {
        let mut tally = Tally { tiles: 1, ..Tally::default() };
        let mut tracer = Tracer::new(&self.description.scene, self.engine);
        for (half, (numbers, &end)) in self.samplers.iter().zip(ends).enumerate() {
            let mut done = tile.count(tile.cell(0, half));
            while done < end {
                let record = self.adaptive().then(|| allocation::next_record(done));
                done = record.map_or(end, |record| record.min(end));
                self.add_to_half(tile, half, numbers, done, &mut tracer, &mut tally);
                if record == Some(done) {
                    tile.record_noise(half);
                }
            }
        }
        tally.rays = tracer.counts;
        tally
    }

    /// Adds samples to one half of a tile until each of its pixels has `end`.
    fn add_to_half(
        &self,
        tile: &mut Tile,
        half: usize,
        (seed, sampler): &(u64, Box<dyn Sampler>),
        end: u32,
        tracer: &mut Tracer<'_>,
        tally: &mut Tally,
    ) {
        let begun: Vec<_> = tile
            .pixels()
            .enumerate()
            .map(|(pixel, (x, y))| {
                let cell = tile.cell(pixel, half);
                (cell, x, y, tile.count(cell))
            })
            .collect();
        let ids = || {
            begun.iter().flat_map(|&(cell, x, y, first)| {
                (first..end).map(move |sample| (cell, SampleId { x, y, sample, seed: *seed }))
            })
        };
        let mut next = ids();
        let mut add = |estimate: Option<Estimate>, tracer: &mut Tracer<'_>| {
            let (cell, id) = next.next().expect("one estimate for each sample");
            let finite = estimate.is_none_or(|estimate| self.add_picture(tile, cell, estimate));
            if !finite {
                tally.non_finite += 1;
                if tally.examples.len() < EXAMPLES {
                    tally.examples.push(id);
                }
            }
            if let Some(aov) = &self.aov {
                // Once more: by now the path is far from the camera.
                let ray = self.begin(sampler.as_ref(), id).ray;
                self.add_layers(tile, cell, id, aov, &ray, tracer);
            }
            tile.count_sample(cell);
            tally.samples += 1;
        };
        let Some(integrator) = &self.picture else {
            ids().for_each(|_| add(None, tracer));
            return;
        };
        let mut samples = self.begin_all(sampler.as_ref(), ids().map(|(_, id)| id));
        integrator.estimates(tracer, &mut samples, &mut |estimate, tracer| {
            add(Some(estimate), tracer);
        });
    }

    /// Adds one sample to the picture; whether its value was finite. If not, it counts as black, so that the numbers of
    /// samples stay alike.
    fn add_picture(&self, tile: &mut Tile, cell: usize, estimate: Estimate) -> bool {
        let finite = estimate.radiance.is_finite();
        let Estimate { radiance, alpha } = if finite { estimate } else { Estimate::default() };
        tile.add_picture(cell, clamped(radiance, self.description.film.clamp), alpha);
        finite
    }

    /// Adds one sample to the layers.
    fn add_layers(
        &self,
        tile: &mut Tile,
        cell: usize,
        id: SampleId,
        aov: &Aov<'_>,
        ray: &Ray,
        tracer: &mut Tracer<'_>,
    ) {
        let (numbers, indices) = tile.layers_mut(cell);
        let (mut numbers, mut indices) = (numbers.iter_mut(), indices.iter_mut());
        aov.evaluate(
            tracer,
            ray,
            |value| *numbers.next().expect("as many as components") += f64::from(value),
            |value| {
                let slot = indices.next().expect("as many as layers");
                if id.sample == 0 && id.seed == self.description.sampler.seed {
                    *slot = value;
                }
            },
        );
    }
}

/// A sample whose components are `most` at most, of the same hue (as pbrt-v4's `maxcomponentvalue`).
fn clamped(radiance: Rgb, most: Option<f32>) -> Rgb {
    let largest = radiance.max_element();
    match most {
        Some(most) if largest > most => radiance * (most / largest),
        _ => radiance,
    }
}

/// Counts of one or more tiles.
#[derive(Default)]
struct Tally {
    tiles: usize,
    samples: u64,
    rays: RayCounts,
    non_finite: u64,
    examples: Vec<SampleId>,
}

impl Tally {
    fn merge(mut self, other: Self) -> Self {
        self.tiles += other.tiles;
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
