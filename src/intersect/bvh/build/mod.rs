//! Top-down construction: a node's children come from dividing its primitives again and again, always
//! the part with the largest surface, until there are eight (as in Embree; Wald et al., "Embree: A
//! Kernel Framework for Efficient CPU Ray Tracing", 2014).

use std::ops::Range;

use arrayvec::ArrayVec;
use rayon::prelude::*;

use super::node::{Child, ChildKind, Node};
use super::traverse::MAX_DEPTH;
use crate::intersect::bvh::LANES;

mod partition;
mod reference;
mod split;

pub(super) use reference::{Reference, finite, outward, references};

use partition::{Around, partition};
use split::{Measure, best_split};

/// Subtrees over more primitives than this are built as tasks of their own.
const TASK: usize = 1 << 12;

/// The primitives of one pack, in the tree's order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    first: u32,
    count: u32,
}

impl Leaf {
    pub(super) fn range(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// Nodes, the root first, and leaves of triangles, which they refer to.
#[derive(Debug, Default)]
pub(super) struct Tree {
    pub(super) nodes: Vec<Node>,
    pub(super) leaves: Vec<Leaf>,
    /// Indices of the primitives, leaf by leaf.
    pub(super) order: Vec<u32>,
}

pub(super) fn build(mut references: Vec<Reference>) -> Tree {
    let mut order = vec![0; references.len()];
    let mut subtree = Subtree::default();
    if !references.is_empty() {
        let mut scratch = references.clone();
        let around = Around::all(&references);
        let part = Part {
            references: &mut references,
            scratch: &mut scratch,
            order: &mut order,
            first: 0,
            around,
        };
        part.node(0, &mut subtree);
    }
    Tree { nodes: subtree.nodes, leaves: subtree.leaves, order }
}

/// Primitives that become a child.
struct Part<'a> {
    references: &'a mut [Reference],
    /// As much space again.
    scratch: &'a mut [Reference],
    /// Where their indices go.
    order: &'a mut [u32],
    /// Place of the first in the order of the whole tree.
    first: u32,
    around: Around,
}

/// Nodes and leaves, numbered from 0.
#[derive(Default)]
struct Subtree {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
}

impl Subtree {
    /// Appends another; returns what the child that is in it is called now.
    fn append(&mut self, mut other: Self, child: Child) -> Child {
        let (nodes, leaves) = (self.nodes.len(), self.leaves.len());
        other.nodes.iter_mut().for_each(|node| node.shift(nodes, leaves));
        self.nodes.append(&mut other.nodes);
        self.leaves.append(&mut other.leaves);
        child.shifted(nodes, leaves)
    }
}

impl<'a> Part<'a> {
    /// One shape, or as many triangles as fit in a pack.
    fn is_leaf(&self) -> bool {
        let n = self.references.len();
        n == 1 || n <= LANES && self.references.iter().all(|r| r.shape().is_none())
    }

    /// Appends a leaf, or a node with all below it.
    fn child(self, depth: usize, tree: &mut Subtree) -> Child {
        if !self.is_leaf() {
            let index = tree.nodes.len();
            self.node(depth, tree);
            return Child::new(ChildKind::Node(index));
        }
        for (reference, slot) in self.references.iter().zip(self.order) {
            *slot = reference.id();
        }
        if let Some(shape) = self.references[0].shape() {
            return Child::new(ChildKind::Shape(shape));
        }
        tree.leaves.push(Leaf { first: self.first, count: self.references.len() as u32 });
        Child::new(ChildKind::Triangles(tree.leaves.len() - 1))
    }

    /// Appends a node with all below it. `depth` is the number of nodes above.
    fn node(self, depth: usize, tree: &mut Subtree) {
        let is_large = self.references.len() > TASK;
        let parts = self.parts(depth);
        let place = tree.nodes.len();
        tree.nodes.push(Node::EMPTY);
        if is_large {
            let build = |part: Self| {
                let bounds = part.around.bounds.aabb();
                let mut subtree = Subtree::default();
                let child = part.child(depth + 1, &mut subtree);
                (bounds, child, subtree)
            };
            let parts: Vec<_> = parts.into_iter().collect();
            let built: Vec<_> = parts.into_par_iter().map(build).collect();
            for (i, (bounds, child, subtree)) in built.into_iter().enumerate() {
                let child = tree.append(subtree, child);
                tree.nodes[place].set(i, &bounds, child);
            }
        } else {
            for (i, part) in parts.into_iter().enumerate() {
                let bounds = part.around.bounds.aabb();
                let child = part.child(depth + 1, tree);
                tree.nodes[place].set(i, &bounds, child);
            }
        }
    }

    /// The children of a node.
    fn parts(self, depth: usize) -> ArrayVec<Self, LANES> {
        // Halves, when a tree of halves below this node is as deep as may be.
        let balanced = depth + 1 + levels(self.references.len()) > MAX_DEPTH;
        let measure = Measure::new(&self.around.bounds);
        let size = |part: &Self| {
            if balanced {
                part.references.len() as f32
            } else {
                measure.half_area(&part.around.bounds)
            }
        };
        let mut parts = ArrayVec::<Self, LANES>::new();
        parts.push(self);
        while !parts.is_full() {
            let divisible = parts.iter().enumerate().filter(|(_, part)| !part.is_leaf());
            let largest = divisible.max_by(|(_, a), (_, b)| size(a).total_cmp(&size(b)));
            let Some((i, _)) = largest else { break };
            let [left, right] = parts.swap_remove(i).divide(balanced);
            parts.push(left);
            parts.push(right);
        }
        parts
    }

    fn divide(self, balanced: bool) -> [Self; 2] {
        let Self { mut references, mut scratch, order, first, around } = self;
        let split = (!balanced).then(|| best_split(references, &around)).flatten();
        let (left, around) = if let Some(split) = split {
            let divided = partition(references, scratch, &split);
            if divided.moved {
                std::mem::swap(&mut references, &mut scratch);
            }
            let [(a, b), (c, d)] = std::array::from_fn(|i| (split.bounds[i], divided.centers[i]));
            let around = [(a, b), (c, d)].map(|(bounds, centers)| Around { bounds, centers });
            (divided.left, around)
        } else {
            // All centres coincide, or the tree is deep: any division is as good.
            let left = references.len() / 2;
            (left, [Around::all(&references[..left]), Around::all(&references[left..])])
        };
        let (references, scratch, order) =
            (references.split_at_mut(left), scratch.split_at_mut(left), order.split_at_mut(left));
        let second = first + left as u32;
        [
            Part {
                references: references.0,
                scratch: scratch.0,
                order: order.0,
                first,
                around: around[0],
            },
            Part {
                references: references.1,
                scratch: scratch.1,
                order: order.1,
                first: second,
                around: around[1],
            },
        ]
    }
}

/// Nodes on the way to a leaf in a tree of halves, each leaf with one primitive.
fn levels(primitives: usize) -> usize {
    primitives.next_power_of_two().trailing_zeros().div_ceil(LANES.trailing_zeros()) as usize
}
