//! Moving primitives to their side of a split.

use rayon::prelude::*;

use super::reference::{Bounds, Reference};
use super::split::Split;

/// References that a thread moves in one go.
const CHUNK: usize = 1 << 13;

/// Boxes around the boxes of primitives and around their centres.
#[derive(Clone, Copy)]
pub(super) struct Around {
    pub(super) bounds: Bounds,
    pub(super) centers: Bounds,
}

impl Around {
    const NOTHING: Self = Self { bounds: Bounds::EMPTY, centers: Bounds::EMPTY };

    fn union(self, other: &Self) -> Self {
        Self {
            bounds: self.bounds.union(&other.bounds),
            centers: self.centers.union(&other.centers),
        }
    }

    pub(super) fn all(references: &[Reference]) -> Self {
        let around = |chunk: &[Reference]| {
            let mut around = Self::NOTHING;
            for reference in chunk {
                around.bounds.extend(reference.lower(), reference.upper());
                around.centers.extend(reference.center(), reference.center());
            }
            around
        };
        if references.len() <= CHUNK {
            return around(references);
        }
        let chunks = references.par_chunks(CHUNK).map(around);
        chunks.reduce(|| Self::NOTHING, |a, b| a.union(&b))
    }
}

/// How primitives were divided.
pub(super) struct Divided {
    /// How many went left.
    pub(super) left: usize,
    /// Around the centres on both sides.
    pub(super) centers: [Bounds; 2],
    /// Whether they are in the scratch space now.
    pub(super) moved: bool,
}

/// Moves the left side to the front: in place if there are few, else by several threads, into
/// `scratch`.
pub(super) fn partition(
    references: &mut [Reference],
    scratch: &mut [Reference],
    split: &Split,
) -> Divided {
    if references.len() < 2 * CHUNK {
        return partition_in_place(references, split);
    }
    let count = |chunk: &[Reference]| chunk.iter().filter(|r| split.is_left(r)).count();
    let counts: Vec<_> = references.par_chunks(CHUNK).map(count).collect();
    let left = counts.iter().sum();
    // The part of the left and of the right side that each chunk fills.
    let (mut lefts, mut rights) = scratch.split_at_mut(left);
    let mut targets = Vec::with_capacity(counts.len());
    for (chunk, &count) in references.chunks(CHUNK).zip(&counts) {
        let (a, b);
        (a, lefts) = lefts.split_at_mut(count);
        (b, rights) = rights.split_at_mut(chunk.len() - count);
        targets.push((chunk, [a, b]));
    }
    let fill = |(chunk, [left, right]): (&[Reference], [&mut [Reference]; 2])| {
        let mut centers = [Bounds::EMPTY; 2];
        let mut sides = [left.iter_mut(), right.iter_mut()];
        for reference in chunk {
            let side = usize::from(!split.is_left(reference));
            centers[side].extend(reference.center(), reference.center());
            if let Some(slot) = sides[side].next() {
                *slot = *reference;
            }
        }
        centers
    };
    let merge = |[a, b]: [Bounds; 2], [c, d]: [Bounds; 2]| [a.union(&c), b.union(&d)];
    let centers = targets.into_par_iter().map(fill).reduce(|| [Bounds::EMPTY; 2], merge);
    Divided { left, centers, moved: true }
}

fn partition_in_place(references: &mut [Reference], split: &Split) -> Divided {
    let mut centers = [Bounds::EMPTY; 2];
    let (mut left, mut right) = (0, references.len());
    while left < right {
        let reference = references[left];
        let side = usize::from(!split.is_left(&reference));
        centers[side].extend(reference.center(), reference.center());
        if side == 0 {
            left += 1;
        } else {
            right -= 1;
            references.swap(left, right);
        }
    }
    Divided { left, centers, moved: false }
}
