//! What holds for the faces of an OBJ file that follow, until something else does: material and smoothing.

use std::collections::HashMap;

use super::polygons::Replaced;

/// A value for each triangle, by where it changes.
#[derive(Clone, Debug)]
pub(super) struct Runs<T> {
    /// The first triangle of each run, ascending, and its value.
    starts: Vec<(usize, T)>,
}

impl<T> Default for Runs<T> {
    fn default() -> Self {
        Self { starts: Vec::new() }
    }
}

impl<T> Runs<T> {
    /// From a triangle on, the value is this one.
    pub(super) fn begin(&mut self, triangle: usize, value: T) {
        if self.starts.last().is_some_and(|(start, _)| *start == triangle) {
            self.starts.pop();
        }
        self.starts.push((triangle, value));
    }

    /// Adds the runs of the next piece of a file, which has so many triangles before it.
    pub(super) fn append<U>(&mut self, before: usize, piece: Runs<U>, mut map: impl FnMut(U) -> T) {
        for (start, value) in piece.starts {
            self.begin(before + start, map(value));
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.starts.is_empty()
    }
}

impl<T: Copy> Runs<T> {
    /// The value of each of `count` triangles, `first` before the first run. Some fans have been replaced since by other
    /// numbers of triangles.
    pub(super) fn values(&self, count: usize, first: T, replaced: &[Replaced]) -> Vec<T> {
        let mut values = Vec::with_capacity(count);
        let (mut replaced, mut shift) = (replaced.iter().peekable(), 0_isize);
        let mut value = first;
        for &(start, next) in &self.starts {
            while let Some(r) = replaced.next_if(|r| r.at() < start.saturating_add_signed(shift)) {
                shift += r.growth();
            }
            values.resize(start.saturating_add_signed(shift).clamp(values.len(), count), value);
            value = next;
        }
        values.resize(count, value);
        values
    }
}

/// Names and their numbers, in the order in which they occur.
#[derive(Debug, Default)]
pub(super) struct Numbered {
    numbers: HashMap<String, u32>,
    names: Vec<String>,
}

impl Numbered {
    pub(super) fn number(&mut self, name: String) -> u32 {
        if let Some(&number) = self.numbers.get(&name) {
            return number;
        }
        let number = self.names.len() as u32;
        self.names.push(name.clone());
        self.numbers.insert(name, number);
        number
    }

    pub(super) fn into_names(self) -> Vec<String> {
        self.names
    }
}
