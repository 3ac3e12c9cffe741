//! A family of points over any number of lanes, and how it becomes a [`Sampler`].

use std::fmt::Debug;

use super::{PathKey, Sampler};
use crate::math::real::{Level, Real, Rows, Simd, Task, Uint, f32x8};
use crate::math::vector::Vec2;

/// A [`Sampler`] that is written once for one path and for eight. Numbers are whole ones of 32 bits, the first binary digit
/// highest.
pub trait Sequence: Debug + Send + Sync {
    /// See [`Sampler::path`].
    fn path(&self, pixel: u32, sample: u32) -> PathKey;

    /// See [`Sampler::get_1d`].
    fn one<U: Uint>(&self, path: PathKeys<U>, dimension: U) -> U;

    /// See [`Sampler::get_2d`].
    fn two<U: Uint>(&self, path: PathKeys<U>, dimension: U) -> [U; 2];

    /// See [`Sampler::get_choice`]: the first number, what comes after its 32 bits, and the second one.
    fn choice<U: Uint>(&self, path: PathKeys<U>, dimension: U) -> [U; 3];
}

/// A [`PathKey`] in each lane.
#[derive(Clone, Copy, Debug)]
pub struct PathKeys<U> {
    /// Its upper half.
    pub high: U,
    /// Its lower half.
    pub low: U,
}

impl From<PathKey> for PathKeys<u32> {
    #[inline(always)]
    fn from(PathKey(key): PathKey) -> Self {
        Self { high: (key >> 32) as u32, low: key as u32 }
    }
}

impl From<PathKeys<u32>> for PathKey {
    #[inline(always)]
    fn from(PathKeys { high, low }: PathKeys<u32>) -> Self {
        Self(u64::from(high) << 32 | u64::from(low))
    }
}

/// What a sampler is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// [`Sampler::get_1d`].
    One,
    /// [`Sampler::get_2d`].
    Two,
    /// [`Sampler::get_choice`].
    Choice,
}

/// Two numbers in `[0, 1)` of what [`Sequence::choice`] has: the first with 40 bits.
#[inline(always)]
pub(super) fn choice<R: Real>([x, more, y]: [R::Uint; 3]) -> Vec2<R::Double> {
    const DIGITS: [f64; 3] =
        [1.0 / (1u64 << 16) as f64, 1.0 / (1u64 << 32) as f64, 1.0 / (1u64 << 40) as f64];
    // By 16 bits, since whole numbers become reals only where f32 has them.
    let (a, b, c) = ((x >> 16).to_real(), (x & 0xffff).to_real(), (more >> 24).to_real());
    let x = a.widen() * DIGITS[0] + b.widen() * DIGITS[1] + c.widen() * DIGITS[2];
    Vec2::new(x, y.to_unit().widen())
}

impl<T: Sequence> Sampler for T {
    fn path(&self, pixel: u32, sample: u32) -> PathKey {
        Sequence::path(self, pixel, sample)
    }

    fn bits(&self, asked: Asked, path: PathKey, dimension: u32) -> [u32; 3] {
        draw(self, asked, path.into(), dimension)
    }

    fn bits_of_eight(&self, level: Level, asked: Asked, paths: &Rows<3>) -> Rows<3> {
        level.run(Draw { sequence: self, asked, paths })
    }
}

/// What is asked for; the rest is 0.
#[inline(always)]
fn draw<U: Uint>(
    sequence: &impl Sequence,
    asked: Asked,
    path: PathKeys<U>,
    dimension: U,
) -> [U; 3] {
    let none = U::splat(dimension.token(), 0);
    match asked {
        Asked::One => [sequence.one(path, dimension), none, none],
        Asked::Two => {
            let [x, y] = sequence.two(path, dimension);
            [x, y, none]
        }
        Asked::Choice => sequence.choice(path, dimension),
    }
}

struct Draw<'a, T> {
    sequence: &'a T,
    asked: Asked,
    paths: &'a Rows<3>,
}

impl<T: Sequence> Task for Draw<'_, T> {
    type Output = Rows<3>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Rows<3> {
        let [high, low, dimension] = self.paths.load::<f32x8<S>>(simd);
        let path = PathKeys { high: high.to_bits(), low: low.to_bits() };
        let [x, y, z] = draw(self.sequence, self.asked, path, dimension.to_bits());
        Rows::of([f32x8::from_bits(x), f32x8::from_bits(y), f32x8::from_bits(z)])
    }
}
