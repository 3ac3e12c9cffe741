//! Passes over tiles, in parallel, and one sample by itself.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use rayon::prelude::*;

use crate::film::picture::Picture;
use crate::film::{Content, Film, Tile};
use crate::integrator::RayCounts;
use crate::intersect::Intersector;

mod allocation;
mod beginning;
pub mod description;
pub mod effort;
pub mod preview;
pub mod requirements;
pub mod resize;
mod schedule;
mod tiles;
mod trace;

pub use allocation::FIRST_ALLOCATION;
pub use description::Description;
pub use effort::Effort;
pub use preview::Preview;
pub use requirements::Requirements;
use schedule::Schedule;
pub use schedule::{Ended, Errors};
use tiles::{Part, Renderer, Tally};
pub use trace::{Edge, Trace, trace};

/// How far a render has come.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// Samples taken.
    pub samples_done: u64,
    /// Samples to take in all; a guess that changes if time or error end the render.
    pub samples_total: u64,
    /// Rays traced.
    pub rays: u64,
    /// What was known of the picture's error when it was looked at last, if an error was asked for.
    pub errors: Option<Errors>,
    /// The tile that has new samples. A [`Preview`] keeps what it shows.
    pub tile: &'a Tile,
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
/// The first pass over all tiles takes one sample of each pixel, and later ones take more and more.
/// `on_progress` is called after each tile of a pass, from the thread that has rendered it and now waits for
/// the return. Once `cancel` is true, tiles that have not begun are left as they are.
///
/// If an error is to be reached, the samples of each pixel are drawn in two independent halves, and the
/// picture is another one than without.
pub fn render(
    description: &Description,
    engine: &dyn Intersector,
    on_progress: &(dyn Fn(Progress<'_>) + Sync),
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
        let errors = schedule.errors();
        let mut add_samples = |part| {
            film.tiles_mut()
                .par_iter_mut()
                .zip(&ends)
                .with_max_len(1)
                .filter(|_| !cancel.load(Ordering::Relaxed))
                .map(|(tile, ends)| {
                    let tally = renderer.add_samples(tile, ends, part);
                    let samples_done =
                        samples_done.fetch_add(tally.samples, Ordering::Relaxed) + tally.samples;
                    let traced = tally.rays.total();
                    let rays = rays.fetch_add(traced, Ordering::Relaxed) + traced;
                    let samples_total = samples_total.max(samples_done);
                    on_progress(Progress { samples_done, samples_total, rays, errors, tile });
                    tally
                })
                .reduce(Tally::default, Tally::merge)
        };
        let begin = schedule.elapsed();
        if done == 0 && description.effort.coarse_first {
            tally = tally.merge(add_samples(Part::Coarse));
        }
        let pass = add_samples(Part::Whole);
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
