//! Which of the surfaces near a ray cover its surroundings, so that it must hit them.

use glam::Vec3A;

use super::span::Line;
use super::triangle::Triangle;
use super::{Span, bound};

/// A triangle near the ray, with the part of the ray that is near it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    pub(super) triangle: Triangle,
    pub(super) span: Span,
    pub(super) crossed: bool,
}

/// A position that compares as bits; −0 is 0.
type Key = [u32; 3];

fn key(p: Vec3A) -> Key {
    (p + 0.0).to_array().map(f32::to_bits)
}

/// A patch at an edge, and on which side of it the ray sees it: 1, −1, or 0 if it is seen from the side
/// and covers nothing.
struct Side {
    edge: [Key; 2],
    patch: usize,
    side: i8,
}

/// The parts of the ray in which it cannot but hit something: one for each group of patches that hang
/// together by edges near the ray, that the ray crosses, and that has no bare edge there.
pub(super) fn barriers(line: &Line, patches: &[Patch]) -> Vec<Span> {
    let mut sides = Vec::new();
    for (index, patch) in patches.iter().enumerate() {
        let facing = patch.triangle.facing(line);
        for (corners, seen) in patch.triangle.edges() {
            let reach = seen[0].length().max(seen[1].length());
            if line.distance_to_segment(seen[0], seen[1]) > bound(reach) {
                continue;
            }
            let [p, q] = corners.map(key);
            let side = i8::from(facing > 0.0) - i8::from(facing < 0.0);
            let (edge, side) = if p < q { ([p, q], side) } else { ([q, p], -side) };
            sides.push(Side { edge, patch: index, side });
        }
    }
    sides.sort_unstable_by_key(|s| s.edge);

    let mut groups = Groups::new(patches.len());
    let edges = || sides.chunk_by(|a, b| a.edge == b.edge);
    for edge in edges() {
        edge.windows(2).for_each(|pair| groups.join(pair[0].patch, pair[1].patch));
    }
    let mut bare = vec![false; patches.len()];
    for edge in edges() {
        if !(edge.iter().any(|s| s.side > 0) && edge.iter().any(|s| s.side < 0)) {
            bare[groups.of(edge[0].patch)] = true;
        }
    }
    let mut spans: Vec<Option<Span>> = vec![None; patches.len()];
    let mut crossed = vec![false; patches.len()];
    for (index, patch) in patches.iter().enumerate() {
        let group = groups.of(index);
        spans[group] = Some(spans[group].map_or(patch.span, |s| s.union(patch.span)));
        crossed[group] |= patch.crossed;
    }
    let whole = spans.into_iter().zip(bare).zip(crossed);
    whole
        .filter(|((_, bare), crossed)| *crossed && !bare)
        .filter_map(|((span, _), _)| span)
        .collect()
}

/// Union-find.
struct Groups(Vec<usize>);

impl Groups {
    fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    fn of(&mut self, mut index: usize) -> usize {
        while self.0[index] != index {
            self.0[index] = self.0[self.0[index]];
            index = self.0[index];
        }
        index
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a.max(b)] = a.min(b);
    }
}
