//! Numbers in lanes as they lie in memory.

use super::Real;

/// `N` numbers in eight lanes, of any level: what passes between code that was compiled for one level and a trait
/// object, whose methods cannot be generic over levels.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct Rows<const N: usize>(pub [[f32; 8]; N]);

impl<const N: usize> Rows<N> {
    /// For what is written next.
    pub const ZERO: Self = Self([[0.0; 8]; N]);

    /// Numbers in eight lanes into memory.
    ///
    /// # Panics
    /// There are not eight lanes.
    #[inline(always)]
    #[must_use]
    pub fn of<R: Real>(numbers: [R; N]) -> Self {
        let mut rows = Self::ZERO;
        rows.store(numbers);
        rows
    }

    /// As [`Rows::of`], into these.
    ///
    /// # Panics
    /// There are not eight lanes.
    #[inline(always)]
    pub fn store<R: Real>(&mut self, numbers: [R; N]) {
        // By reference: an array that is taken apart goes through memory, at 30 ns a lane.
        for (row, number) in self.0.iter_mut().zip(&numbers) {
            number.store(row);
        }
    }

    /// The numbers.
    ///
    /// # Panics
    /// There are not eight lanes.
    #[inline(always)]
    #[must_use]
    pub fn load<R: Real>(&self, token: R::Token) -> [R; N] {
        // Not by `array::from_fn`, which is not always inlined.
        let mut numbers = [R::splat(token, 0.0); N];
        for (number, row) in numbers.iter_mut().zip(&self.0) {
            *number = R::load(token, row);
        }
        numbers
    }

    /// Those of one lane.
    ///
    /// # Panics
    /// There is no such lane.
    #[must_use]
    pub fn lane(&self, lane: usize) -> [f32; N] {
        self.0.map(|row| row[lane])
    }

    /// Writes those of one lane.
    ///
    /// # Panics
    /// There is no such lane.
    pub fn set_lane(&mut self, lane: usize, numbers: [f32; N]) {
        for (row, number) in self.0.iter_mut().zip(numbers) {
            row[lane] = number;
        }
    }
}
