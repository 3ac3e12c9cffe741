//! Random numbers as pure functions of (seed, pixel, sample index, dimension).
//!
//! A path is one point of a cube with as many dimensions as it asks numbers for. Because no state is
//! carried from one sample to the next, an image is the same to the last bit for any number of
//! threads, any order of tiles and any split of the samples.

use std::fmt::Debug;

use glam::{DVec2, Vec2};

mod bits;
pub mod independent;
pub mod path;
pub mod sequence;
pub mod settings;
pub mod sobol;

pub use independent::Independent;
pub use path::{PathSampler, PathSamplers};
pub use sequence::{Asked, PathKeys, Sequence};
pub use settings::{About, SamplerKind, SamplerSettings, UnknownSampler};
pub use sobol::Sobol;

use crate::math::real::{Level, Rows, Uint};

/// A family of points in the unit cube.
pub trait Sampler: Debug + Send + Sync {
    /// What identifies a path: computed once, handed back for each of its numbers.
    fn path(&self, pixel: u32, sample: u32) -> PathKey;

    /// The bits of what is asked for, as a [`Sequence`] has them; a type that is one is a sampler.
    fn bits(&self, asked: Asked, path: PathKey, dimension: u32) -> [u32; 3];

    /// The same in eight lanes: from the bits of both halves of keys, the upper first, and of dimensions.
    fn bits_of_eight(&self, level: Level, asked: Asked, paths: &Rows<3>) -> Rows<3>;

    /// One number in `[0, 1)`.
    fn get_1d(&self, path: PathKey, dimension: u32) -> f32 {
        let [x, ..] = self.bits(Asked::One, path, dimension);
        x.to_unit()
    }

    /// Two numbers in `[0, 1)`, for `dimension` and the one after it.
    fn get_2d(&self, path: PathKey, dimension: u32) -> Vec2 {
        let [x, y, _] = self.bits(Asked::Two, path, dimension);
        Vec2::new(x.to_unit(), y.to_unit())
    }

    /// The same for a point that is chosen among many surfaces: the first number has 40 bits, as
    /// a choice among a million takes 20 and what is left of it is one of the point's coordinates.
    fn get_choice(&self, path: PathKey, dimension: u32) -> DVec2 {
        sequence::choice::<f32>(self.bits(Asked::Choice, path, dimension)).into()
    }
}

/// A path's identity, in a form that its sampler chose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PathKey(pub u64);

/// The sampler that the settings ask for.
#[must_use]
pub fn build(settings: &SamplerSettings) -> Box<dyn Sampler> {
    (settings.kind.about().build)(settings.seed)
}
