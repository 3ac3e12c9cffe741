//! Top-down construction by the binned surface area heuristic.
//!
//! Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies" (2007).

use glam::Vec3;

use super::{MAX_DEPTH, Node};
use crate::math::Aabb;

/// Bins per axis.
const BINS: usize = 16;
/// Largest leaf, unless the tree is as deep as it may be.
const MAX_LEAF: usize = 8;
/// Cost of entering a node, in units of a triangle test.
const NODE_COST: f32 = 1.0;
/// From this depth on nodes are split in halves: 32 more levels then suffice for any number of
/// primitives that an index of 32 bits can name.
const HALVE_FROM: usize = MAX_DEPTH - 1 - 32;
/// Ranges longer than this are built by two threads.
const PARALLEL_FROM: usize = 4096;

/// A primitive during construction.
#[derive(Clone, Copy)]
struct Reference {
    bounds: Aabb,
    index: u32,
}

impl Reference {
    /// Twice the centre: the factor does not matter to any comparison.
    fn center(&self) -> Vec3 {
        self.bounds.min + self.bounds.max
    }
}

/// A tree with its own nodes, before they are laid out in one array.
enum Tree {
    Leaf { bounds: Aabb, first: u32, count: u32 },
    Inner { bounds: Aabb, children: Box<[Tree; 2]> },
}

impl Tree {
    fn bounds(&self) -> Aabb {
        match self {
            Self::Leaf { bounds, .. } | Self::Inner { bounds, .. } => *bounds,
        }
    }
}

/// The nodes, root first and siblings side by side, and the primitives' indices in the order in which
/// leaves refer to them.
pub(super) fn build(bounds: &[Aabb]) -> (Vec<Node>, Vec<u32>) {
    let mut references: Vec<Reference> =
        bounds.iter().zip(0..).map(|(&bounds, index)| Reference { bounds, index }).collect();
    if references.is_empty() {
        return (Vec::new(), Vec::new());
    }
    let tree = subtree(&mut references, 0, 0);
    let mut nodes = vec![node(&tree)];
    lay_out(&tree, 0, &mut nodes);
    (nodes, references.iter().map(|r| r.index).collect())
}

fn subtree(references: &mut [Reference], first: u32, depth: usize) -> Tree {
    let bounds = union(references);
    let leaf = Tree::Leaf { bounds, first, count: references.len() as u32 };
    if references.len() == 1 {
        return leaf;
    }
    let split = match (best_split(references, &bounds), depth < HALVE_FROM) {
        (Some(split), true)
            if references.len() > MAX_LEAF || split.cost < references.len() as f32 =>
        {
            partition(references, &split)
        }
        _ if references.len() <= MAX_LEAF => return leaf,
        // All centres coincide, or the tree is deep: any split is as good.
        _ => references.len() / 2,
    };
    let (left, right) = references.split_at_mut(split);
    let second = first + split as u32;
    let build_left = |left| subtree(left, first, depth + 1);
    let build_right = |right| subtree(right, second, depth + 1);
    let (a, b) = if left.len() + right.len() > PARALLEL_FROM {
        rayon::join(|| build_left(left), || build_right(right))
    } else {
        (build_left(left), build_right(right))
    };
    Tree::Inner { bounds, children: Box::new([a, b]) }
}

fn union(references: &[Reference]) -> Aabb {
    references.iter().fold(Aabb::EMPTY, |b, r| b.union(r.bounds))
}

/// A plane between bins: references whose bin is below `bin` go left.
struct Split {
    axis: usize,
    bin: usize,
    binning: Binning,
    cost: f32,
}

/// Maps centres to bins.
#[derive(Clone, Copy)]
struct Binning {
    min: Vec3,
    scale: Vec3,
}

impl Binning {
    fn new(centers: &Aabb) -> Self {
        let extent = centers.max - centers.min;
        // An axis without extent puts all in one bin.
        let scale = extent.map(|e| {
            let scale = BINS as f32 / e;
            if scale.is_finite() { scale } else { 0.0 }
        });
        Self { min: centers.min, scale }
    }

    fn bins(&self, reference: &Reference) -> [usize; 3] {
        ((reference.center() - self.min) * self.scale)
            .to_array()
            .map(|b| (b as usize).min(BINS - 1))
    }
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    count: usize,
}

/// The cheapest plane, `None` if all references fall into one bin on each axis. Costs are in triangle
/// tests for a ray that meets `bounds`.
fn best_split(references: &[Reference], bounds: &Aabb) -> Option<Split> {
    let binning = Binning::new(&Aabb::around(references.iter().map(Reference::center)));
    let mut bins = [[Bin { bounds: Aabb::EMPTY, count: 0 }; BINS]; 3];
    for reference in references {
        for (axis, bin) in binning.bins(reference).into_iter().enumerate() {
            let bin = &mut bins[axis][bin];
            bin.bounds = bin.bounds.union(reference.bounds);
            bin.count += 1;
        }
    }
    let mut best: Option<Split> = None;
    for (axis, bins) in bins.iter().enumerate() {
        let right_costs = right_costs(bins);
        let mut left = Bin { bounds: Aabb::EMPTY, count: 0 };
        for bin in 1..BINS {
            left.bounds = left.bounds.union(bins[bin - 1].bounds);
            left.count += bins[bin - 1].count;
            if left.count == 0 || left.count == references.len() {
                continue;
            }
            let tests = left.count as f32 * half_area(&left.bounds) + right_costs[bin];
            let cost = NODE_COST + tests / half_area(bounds).max(f32::MIN_POSITIVE);
            if best.as_ref().is_none_or(|b| cost < b.cost) {
                best = Some(Split { axis, bin, binning, cost });
            }
        }
    }
    best
}

/// For each bin the area times count of it and all above it.
fn right_costs(bins: &[Bin; BINS]) -> [f32; BINS] {
    let mut costs = [0.0; BINS];
    let mut right = Bin { bounds: Aabb::EMPTY, count: 0 };
    for (bin, cost) in bins.iter().zip(&mut costs).rev() {
        right.bounds = right.bounds.union(bin.bounds);
        right.count += bin.count;
        *cost = if right.count == 0 { 0.0 } else { right.count as f32 * half_area(&right.bounds) };
    }
    costs
}

fn half_area(bounds: &Aabb) -> f32 {
    let e = bounds.max - bounds.min;
    e.x * e.y + e.y * e.z + e.z * e.x
}

/// Moves the left side to the front, in place; returns its length.
fn partition(references: &mut [Reference], split: &Split) -> usize {
    let mut left = 0;
    for i in 0..references.len() {
        if split.binning.bins(&references[i])[split.axis] < split.bin {
            references.swap(i, left);
            left += 1;
        }
    }
    left
}

fn node(tree: &Tree) -> Node {
    let Aabb { min, max } = tree.bounds();
    let (first, count) = match *tree {
        Tree::Leaf { first, count, .. } => (first, count),
        // Filled in when the children have their place.
        Tree::Inner { .. } => (0, 0),
    };
    Node { min: min.to_array(), first, max: max.to_array(), count }
}

/// Appends the descendants of `tree`, whose own node is at `place`. Recursion is no deeper than the tree.
fn lay_out(tree: &Tree, place: usize, nodes: &mut Vec<Node>) {
    if let Tree::Inner { children, .. } = tree {
        let first = nodes.len();
        nodes[place].first = first as u32;
        nodes.extend(children.iter().map(node));
        for (child, place) in children.iter().zip(first..) {
            lay_out(child, place, nodes);
        }
    }
}
