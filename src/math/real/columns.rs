//! Tables of numbers, each column together.

use super::{Lanes, Mask};

/// Rows of `N` numbers, stored by column: lanes are appended to it and gathered from it.
#[derive(Clone, Debug)]
pub struct Columns<T, const N: usize> {
    len: usize,
    /// Longer than the rows, so that all lanes can be written where some count.
    columns: [Vec<T>; N],
}

/// The most lanes that are appended at once.
const LANES: usize = 8;

/// Rows that there is room for at first: those of a pool of paths.
const FIRST: usize = 256;

/// A column beside a table, of as many rows, that not every table needs.
#[derive(Clone, Debug)]
pub struct Column<T> {
    /// One for each row, or none.
    rows: Option<Columns<T, 1>>,
    /// That of all rows, where there are none.
    same: T,
}

impl<T: Copy + Default, const N: usize> Default for Columns<T, N> {
    fn default() -> Self {
        Self { len: 0, columns: std::array::from_fn(|_| Vec::new()) }
    }
}

impl<T: Copy + Default, const N: usize> Columns<T, N> {
    /// How many rows there are.
    #[inline(always)]
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no rows.
    #[inline(always)]
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Takes all rows out.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Makes room for all lanes after the last row.
    #[inline(always)]
    fn make_room(&mut self) {
        if self.columns[0].len() < self.len + LANES {
            self.grow();
        }
    }

    #[cold]
    fn grow(&mut self) {
        let size = (2 * self.len).max(FIRST) + LANES;
        for column in &mut self.columns {
            column.resize(size, T::default());
        }
    }

    /// A row at the end.
    #[inline(always)]
    pub fn push(&mut self, row: [T; N]) {
        self.make_room();
        for (column, number) in self.columns.iter_mut().zip(row) {
            column[self.len] = number;
        }
        self.len += 1;
    }

    /// At the end, a row of each lane that is set, in their order.
    #[inline(always)]
    pub fn append<L: Lanes<Lane = T>>(&mut self, mask: L::Mask, lanes: [L; N]) {
        self.make_room();
        // By reference, and below not by `array::from_fn`, for what `Rows` says.
        for (column, lanes) in self.columns.iter_mut().zip(&lanes) {
            lanes.compress(mask).store(&mut column[self.len..self.len + L::LANES]);
        }
        self.len += mask.count() as usize;
    }

    /// Those of some rows, one for each lane.
    ///
    /// # Panics
    /// There is no such row.
    #[inline(always)]
    #[must_use]
    pub fn gather<L: Lanes<Lane = T>>(&self, token: L::Token, rows: &[usize]) -> [L; N] {
        assert!(rows.len() == L::LANES && rows.iter().all(|&row| row < self.len));
        let mut numbers = [L::splat(token, L::Lane::default()); N];
        for (number, column) in numbers.iter_mut().zip(&self.columns) {
            let column = &column[..self.len];
            *number = L::from_fn(token, |lane| column[rows[lane]]);
        }
        numbers
    }

    /// One row.
    ///
    /// # Panics
    /// There is no such row.
    #[inline(always)]
    #[must_use]
    pub fn row(&self, row: usize) -> [T; N] {
        assert!(row < self.len);
        std::array::from_fn(|column| self.columns[column][row])
    }

    /// Its columns.
    #[inline(always)]
    #[must_use]
    pub fn columns(&self) -> [&[T]; N] {
        let mut columns: [&[T]; N] = [&[]; N];
        for (slice, column) in columns.iter_mut().zip(&self.columns) {
            *slice = &column[..self.len];
        }
        columns
    }
}

impl<T: Copy + Default> Column<T> {
    /// One that is `kept`, or else has the same number in all rows.
    #[must_use]
    pub fn new(kept: bool, same: T) -> Self {
        Self { rows: kept.then(Columns::default), same }
    }

    /// All rows, if it is kept.
    #[inline(always)]
    #[must_use]
    pub fn all(&self) -> Option<&[T]> {
        self.rows.as_ref().map(|rows| rows.columns()[0])
    }

    /// Takes all rows out.
    #[inline(always)]
    pub fn clear(&mut self) {
        if let Some(rows) = &mut self.rows {
            rows.clear();
        }
    }

    /// A row at the end.
    #[inline(always)]
    pub fn push(&mut self, number: T) {
        if let Some(rows) = &mut self.rows {
            rows.push([number]);
        }
    }

    /// [`Columns::append`].
    #[inline(always)]
    pub fn append<L: Lanes<Lane = T>>(&mut self, mask: L::Mask, lanes: L) {
        if let Some(rows) = &mut self.rows {
            rows.append(mask, [lanes]);
        }
    }

    /// [`Columns::gather`].
    ///
    /// # Panics
    /// There is no such row, and the column is kept.
    #[inline(always)]
    #[must_use]
    pub fn gather<L: Lanes<Lane = T>>(&self, token: L::Token, rows: &[usize]) -> L {
        match &self.rows {
            Some(kept) => kept.gather::<L>(token, rows)[0],
            None => L::splat(token, self.same),
        }
    }

    /// One row.
    ///
    /// # Panics
    /// There is no such row, and the column is kept.
    #[inline(always)]
    #[must_use]
    pub fn row(&self, row: usize) -> T {
        self.rows.as_ref().map_or(self.same, |kept| kept.row(row)[0])
    }
}
