//! The paths that have met the same material.

use std::mem;
use std::num::NonZeroU32;

/// One list of paths for each material.
pub(super) struct Groups {
    /// Of each material the first path.
    first: Vec<Option<Number>>,
    /// Of each path the one after it.
    next: Vec<Option<Number>>,
    /// Materials that have been met.
    met: Vec<usize>,
}

/// The number of a path in the pool, more 1.
type Number = NonZeroU32;

impl Groups {
    /// Bytes for each path.
    pub(super) const BYTES: usize = size_of::<Option<Number>>();

    pub(super) fn new(materials: usize, paths: usize) -> Self {
        Self { first: vec![None; materials], next: vec![None; paths], met: Vec::new() }
    }

    pub(super) fn clear(&mut self) {
        for material in self.met.drain(..) {
            self.first[material] = None;
        }
    }

    pub(super) fn add(&mut self, material: usize, path: usize) {
        if self.first[material].is_none() {
            self.met.push(material);
        }
        let number = Number::new(path as u32 + 1);
        self.next[path] = mem::replace(&mut self.first[material], number);
    }

    /// How many materials have been met.
    pub(super) fn len(&self) -> usize {
        self.met.len()
    }

    /// The first path of one of these.
    pub(super) fn first(&self, group: usize) -> Option<usize> {
        path_of(self.first[self.met[group]])
    }

    /// The path after this one.
    pub(super) fn after(&self, path: usize) -> Option<usize> {
        path_of(self.next[path])
    }
}

fn path_of(number: Option<Number>) -> Option<usize> {
    number.map(|number| number.get() as usize - 1)
}
