//! Numbers in lanes as they lie in memory.

use super::Lanes;

/// `N` numbers in eight lanes, of any level: what passes between code that was compiled for one level and a trait
/// object, whose methods cannot be generic over levels.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct Rows<const N: usize, T = f32>(pub [[T; 8]; N]);

impl<const N: usize> Rows<N> {
    /// For what is written next.
    pub const ZERO: Self = Self([[0.0; 8]; N]);
}

impl<const N: usize, T: Copy + Default> Rows<N, T> {
    /// Numbers in eight lanes into memory.
    ///
    /// # Panics
    /// There are not eight lanes.
    #[inline(always)]
    #[must_use]
    pub fn of<L: Lanes<Lane = T>>(numbers: [L; N]) -> Self {
        let mut rows = Self([[T::default(); 8]; N]);
        rows.store(numbers);
        rows
    }

    /// As [`Rows::of`], into these.
    ///
    /// # Panics
    /// There are not eight lanes.
    #[inline(always)]
    pub fn store<L: Lanes<Lane = T>>(&mut self, numbers: [L; N]) {
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
    pub fn load<L: Lanes<Lane = T>>(&self, token: L::Token) -> [L; N] {
        // Not by `array::from_fn`, which is not always inlined.
        let mut numbers = [L::splat(token, T::default()); N];
        for (number, row) in numbers.iter_mut().zip(&self.0) {
            *number = L::load(token, row);
        }
        numbers
    }

    /// Those of one lane.
    ///
    /// # Panics
    /// There is no such lane.
    #[must_use]
    pub fn lane(&self, lane: usize) -> [T; N] {
        self.0.map(|row| row[lane])
    }

    /// Writes those of one lane.
    ///
    /// # Panics
    /// There is no such lane.
    pub fn set_lane(&mut self, lane: usize, numbers: [T; N]) {
        for (row, number) in self.0.iter_mut().zip(numbers) {
            row[lane] = number;
        }
    }
}
