//! When a render ends, and how long its passes are.

use std::time::{Duration, Instant};

use super::{Description, Effort};
use crate::film::Film;
use crate::film::error::Estimate;

/// Samples that a pass adds to each pixel at most: early passes are short, so that there is a whole
/// picture soon, later ones long, so that a tile's rays stay in the cache.
const LONGEST_PASS: u32 = 64;
/// Samples per pixel before the error is looked at: the fewer there are, the less is known of what is
/// rare.
const FIRST_LOOK: u32 = 16;

/// Why a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// All samples are taken.
    Samples,
    /// The error or the noise level that was asked for is reached.
    Error,
    /// No further pass would fit in the time.
    Time,
    /// It was cancelled.
    Cancelled,
}

/// What is known of the picture's error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Its relMSE.
    pub rel_mse: Estimate,
    /// Its noise level.
    pub noise_level: Estimate,
}

/// Decides what the next pass is.
#[derive(Debug)]
pub(super) struct Schedule {
    effort: Effort,
    most: u32,
    start: Instant,
    /// Samples per pixel at the last look, and what was seen.
    last_look: Option<(u32, Errors)>,
    /// Factor that the number of samples at the last look lacks.
    lacking: f64,
    next_look: u32,
    /// Time of the last pass for one sample of each pixel.
    per_sample: Duration,
}

impl Schedule {
    pub(super) fn new(description: &Description) -> Self {
        Self {
            effort: description.effort,
            most: description.sampler.samples_per_pixel,
            start: Instant::now(),
            last_look: None,
            lacking: f64::INFINITY,
            next_look: FIRST_LOOK,
            per_sample: Duration::ZERO,
        }
    }

    /// How many samples a pixel has after the next pass, if it has `done`.
    pub(super) fn next(&self, done: u32) -> Result<u32, Ended> {
        if self.effort.needs_error() && self.lacking <= 1.0 {
            return Err(Ended::Error);
        }
        if done >= self.most {
            return Err(Ended::Samples);
        }
        let mut step = done.clamp(1, LONGEST_PASS).min(self.most - done);
        if self.effort.needs_error() && self.next_look > done {
            step = step.min(self.next_look - done);
        }
        if let Some(time) = self.effort.time.filter(|_| done > 0) {
            let left = time.saturating_sub(self.start.elapsed());
            let fitting = left.as_secs_f64() / self.per_sample.as_secs_f64().max(1e-9);
            // An allocation depends on the numbers of samples before it, which time must not change.
            let shortened =
                if self.effort.adaptive { step } else { step.min(fitting.max(1.0) as u32) };
            if f64::from(shortened) > fitting {
                return Err(Ended::Time);
            }
            step = shortened;
        }
        Ok(done + step)
    }

    /// Looks at the film after a pass of `samples` for each pixel that took `elapsed`.
    pub(super) fn look(&mut self, film: &Film, done: u32, samples: u32, elapsed: Duration) {
        self.per_sample = elapsed / samples.max(1);
        if !self.effort.needs_error() || done < self.next_look {
            return;
        }
        let Some(errors) = Errors::of(film) else { return };
        self.last_look = Some((done, errors));
        self.lacking = errors.lacking(&self.effort);
        // Where the target will be reached if the error falls as 1/n. Not much sooner, since each look is
        // one more chance to be wrong; not much later, since rare samples let the estimate jump.
        let sooner = f64::from(done) * 1.05 + 2.0;
        let expected = (f64::from(done) * self.lacking).min(f64::from(done) * 2.0).max(sooner);
        let expected = expected.ceil() as u32;
        // Even, so that both halves are alike.
        self.next_look = expected.saturating_add(expected % 2);
    }

    /// How many samples a pixel will have in the end, as far as can be told after `done`.
    pub(super) fn expected_total(&self, done: u32) -> f64 {
        let mut total = f64::from(self.most);
        if let Some((at, _)) = self.last_look.filter(|_| self.lacking.is_finite()) {
            total = total.min((f64::from(at) * self.lacking).max(f64::from(done)));
        }
        if let Some(time) = self.effort.time.filter(|_| done > 0) {
            let pace = f64::from(done) / self.start.elapsed().as_secs_f64().max(1e-9);
            total = total.min(pace * time.as_secs_f64());
        }
        total
    }

    /// What was seen at the last look.
    pub(super) fn errors(&self) -> Option<Errors> {
        self.last_look.map(|(_, errors)| errors)
    }

    /// Time since the beginning.
    pub(super) fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }
}

impl Errors {
    pub(super) fn of(film: &Film) -> Option<Self> {
        Some(Self { rel_mse: film.rel_mse()?, noise_level: film.noise_level()? })
    }

    /// By which factor there are too few samples, if the squared error falls as 1/n; 1 or less: there are
    /// enough.
    fn lacking(&self, effort: &Effort) -> f64 {
        let error = effort.error.map_or(0.0, |target| self.rel_mse.bound / target);
        let noise = effort.noise_level.map_or(0.0, |l| (self.noise_level.bound / l).powi(2));
        // A number that is none must not end the render.
        if error.is_nan() || noise.is_nan() { f64::INFINITY } else { error.max(noise) }
    }
}
