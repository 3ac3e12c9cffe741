//! Random numbers as pure functions of (seed, pixel, sample index, dimension).
//!
//! A path is one point of a cube with as many dimensions as it asks numbers for. Because no state is
//! carried from one sample to the next, an image is the same to the last bit for any number of
//! threads, any order of tiles and any split of the samples.

use std::fmt::Debug;

use glam::{DVec2, Vec2};

mod bits;
pub mod independent;
pub mod settings;
pub mod sobol;

pub use independent::Independent;
pub use settings::{About, SamplerKind, SamplerSettings, UnknownSampler};
pub use sobol::Sobol;

/// A family of points in the unit cube.
pub trait Sampler: Debug + Send + Sync {
    /// What identifies a path: computed once, handed back for each of its numbers.
    fn path(&self, pixel: u32, sample: u32) -> PathKey;

    /// One number in `[0, 1)`.
    fn get_1d(&self, path: PathKey, dimension: u32) -> f32;

    /// Two numbers in `[0, 1)`, for `dimension` and the one after it.
    fn get_2d(&self, path: PathKey, dimension: u32) -> Vec2;

    /// The same for a point that is chosen among many surfaces: the first number has more bits than an f32, as
    /// a choice among a million takes 20 and what is left of it is one of the point's coordinates.
    fn get_choice(&self, path: PathKey, dimension: u32) -> DVec2;
}

/// A path's identity, in a form that its sampler chose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathKey(pub u64);

/// The numbers of one path, one after the other.
#[derive(Debug)]
pub struct PathSampler<'a> {
    sampler: &'a dyn Sampler,
    key: PathKey,
    dimension: u32,
}

impl<'a> PathSampler<'a> {
    /// The numbers of sample `sample` of pixel `pixel` (its index in the whole film, row by row).
    #[must_use]
    pub fn new(sampler: &'a dyn Sampler, pixel: u32, sample: u32) -> Self {
        Self { sampler, key: sampler.path(pixel, sample), dimension: 0 }
    }

    /// The next number, in `[0, 1)`.
    pub fn next_1d(&mut self) -> f32 {
        let dimension = self.dimension;
        self.dimension += 1;
        self.sampler.get_1d(self.key, dimension)
    }

    /// The next two numbers, in `[0, 1)`.
    pub fn next_2d(&mut self) -> Vec2 {
        let dimension = self.dimension;
        self.dimension += 2;
        self.sampler.get_2d(self.key, dimension)
    }

    /// The same as [`Sampler::get_choice`] gives them.
    pub fn next_choice(&mut self) -> DVec2 {
        let dimension = self.dimension;
        self.dimension += 2;
        self.sampler.get_choice(self.key, dimension)
    }
}

/// The sampler that the settings ask for.
#[must_use]
pub fn build(settings: &SamplerSettings) -> Box<dyn Sampler> {
    (settings.kind.about().build)(settings.seed)
}
