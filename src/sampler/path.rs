//! The numbers of a path, one after the other.

use glam::{DVec2, Vec2 as GlamVec2};

use super::sequence::{Asked, choice};
use super::{PathKey, PathKeys, Sampler};
use crate::math::real::{Lanes, Real, Rows, Uint};
use crate::math::vector::Vec2;

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

    /// What is left of the numbers of a lane's path.
    #[inline(always)]
    #[must_use]
    pub fn resume<R: Real>(paths: &PathSamplers<'a, R>, lane: usize) -> Self {
        let PathSamplers { sampler, keys, dimension } = *paths;
        let key = PathKeys { high: keys.high.lane(lane), low: keys.low.lane(lane) };
        Self { sampler, key: key.into(), dimension: dimension.lane(lane) }
    }

    /// The next number, in `[0, 1)`.
    pub fn next_1d(&mut self) -> f32 {
        let dimension = self.dimension;
        self.dimension += 1;
        self.sampler.get_1d(self.key, dimension)
    }

    /// The next two numbers, in `[0, 1)`.
    pub fn next_2d(&mut self) -> GlamVec2 {
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

    /// The sampler, the key of the path, and how many numbers have been drawn.
    #[must_use]
    pub fn parts(&self) -> (&'a dyn Sampler, PathKeys<u32>, u32) {
        (self.sampler, self.key.into(), self.dimension)
    }

    /// Goes on after so many numbers.
    pub fn go_to(&mut self, dimension: u32) {
        self.dimension = dimension;
    }
}

/// Tells what is beside the numbers of paths from them: none asks for so many.
const ASIDE: u32 = 1 << 30;

/// The numbers of a path in each lane, all of one sampler.
#[derive(Clone, Copy, Debug)]
pub struct PathSamplers<'a, R: Real> {
    sampler: &'a dyn Sampler,
    keys: PathKeys<R::Uint>,
    /// How many numbers have been drawn.
    pub dimension: R::Uint,
}

impl<'a> PathSamplers<'a, f32> {
    /// One path's.
    #[must_use]
    pub fn one(path: &PathSampler<'a>) -> Self {
        Self { sampler: path.sampler, keys: path.key.into(), dimension: path.dimension }
    }
}

impl<'a, R: Real> PathSamplers<'a, R> {
    /// The numbers of the paths with these keys from these dimensions on.
    #[inline(always)]
    #[must_use]
    pub fn new(sampler: &'a dyn Sampler, keys: PathKeys<R::Uint>, dimension: R::Uint) -> Self {
        Self { sampler, keys, dimension }
    }

    /// The next number, in `[0, 1)`, where it is `used`; elsewhere it stays the next one.
    #[inline(always)]
    pub fn next_1d(&mut self, used: R::Mask) -> R {
        let [x, ..] = self.draw(Asked::One);
        self.advance(used, 1);
        x.to_unit()
    }

    /// The next two numbers, likewise.
    #[inline(always)]
    pub fn next_2d(&mut self, used: R::Mask) -> Vec2<R> {
        let [x, y, _] = self.draw(Asked::Two);
        self.advance(used, 2);
        Vec2::new(x.to_unit(), y.to_unit())
    }

    /// The same as [`Sampler::get_choice`] gives them.
    #[inline(always)]
    pub fn next_choice(&mut self, used: R::Mask) -> Vec2<R::Double> {
        let numbers = self.draw(Asked::Choice);
        self.advance(used, 2);
        choice::<R>(numbers)
    }

    /// A number in `[0, 1)` beside the next ones, which stay those: unrelated to them, and to what is beside others.
    #[inline(always)]
    #[must_use]
    pub fn aside(&self) -> R {
        let mut beside = *self;
        beside.dimension = self.dimension | ASIDE;
        let [x, ..] = beside.draw(Asked::One);
        x.to_unit()
    }

    #[inline(always)]
    fn advance(&mut self, used: R::Mask, by: u32) {
        let next = self.dimension.wrapping_add(by);
        self.dimension = R::Uint::select(used, next, self.dimension);
    }

    #[inline(always)]
    fn draw(&self, asked: Asked) -> [R::Uint; 3] {
        let token = self.dimension.token();
        let PathKeys { high, low } = self.keys;
        if R::LANES == 1 {
            let key = PathKeys { high: high.lane(0), low: low.lane(0) };
            let bits = self.sampler.bits(asked, key.into(), self.dimension.lane(0));
            return bits.map(|bits| R::Uint::splat(token, bits));
        }
        let paths = Rows::of([R::from_bits(high), R::from_bits(low), R::from_bits(self.dimension)]);
        let bits = self.sampler.bits_of_eight(R::level(token), asked, &paths);
        let [x, y, z] = bits.load::<R>(token);
        [x.to_bits(), y.to_bits(), z.to_bits()]
    }
}
