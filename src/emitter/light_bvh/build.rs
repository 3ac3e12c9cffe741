//! How the tree is built: from the root, splits that make the expected noise small.

use std::f32::consts::PI;

use glam::Vec3;

use super::{Content, LightBvh, Node, Trail};
use crate::emitter::EmitterBounds;
use crate::emitter::importance::LightBounds;
use crate::math::Aabb;

/// Places along an axis where a node may be split.
const BINS: usize = 12;

/// Levels down to which costs decide. Below, halves do, and so no trail has more than 32 + 31 bits and its end.
const COSTLY_LEVELS: u32 = 32;

/// Lights from which on both sides of a node are built at the same time.
const PARALLEL: usize = 4096;

pub(super) fn build(lights: &[EmitterBounds]) -> Option<LightBvh> {
    let mut items: Vec<_> = (0..)
        .zip(lights)
        .filter(|(_, bounds)| bounds.intensity > 0.0)
        .map(|(light, bounds)| Item { light, trail: None, bounds: *bounds })
        .collect();
    if items.is_empty() {
        return None;
    }
    assert!(lights.len() <= 1 << 31, "two nodes for each light, counted in 32 bits");
    let total: f64 = items.iter().map(|item| item.bounds.intensity).sum();
    for item in &mut items {
        item.bounds.intensity /= total;
    }
    let leaf = Node::new(&items[0].bounds, Content::Light(0));
    let mut nodes = vec![leaf; 2 * items.len() - 1];
    fill(&mut items, &mut nodes, 0, 0, 0);
    let mut trails: Vec<Option<Trail>> = vec![None; lights.len()];
    for item in &items {
        trails[item.light as usize] = item.trail;
    }
    Some(LightBvh { nodes, trails })
}

/// A light on its way to its leaf.
#[derive(Clone, Copy)]
struct Item {
    light: u32,
    trail: Option<Trail>,
    bounds: EmitterBounds,
}

/// Fills `nodes`, whose first has the index `first` in the tree and which are as many as the tree over `items` has.
fn fill(
    items: &mut [Item],
    nodes: &mut [Node],
    first: u32,
    level: u32,
    trail: u64,
) -> EmitterBounds {
    if let [item] = items {
        item.trail = Trail::new(trail | 1 << level);
        nodes[0] = Node::new(&item.bounds, Content::Light(item.light));
        return item.bounds;
    }
    let middle = split(items, level);
    let parallel = items.len() >= PARALLEL;
    let (low, high) = items.split_at_mut(middle);
    let (node, below) = nodes.split_at_mut(1);
    let (left, right) = below.split_at_mut(2 * middle - 1);
    let second = first + 2 * middle as u32;
    let mut fill_low = || fill(low, left, first + 1, level + 1, trail);
    let mut fill_high = || fill(high, right, second, level + 1, trail | 1 << level);
    let (a, b) =
        if parallel { rayon::join(fill_low, fill_high) } else { (fill_low(), fill_high()) };
    let bounds = a.union(&b);
    node[0] = Node::new(&bounds, Content::Children(second));
    bounds
}

impl Node {
    fn new(bounds: &EmitterBounds, content: Content) -> Self {
        Self { bounds: LightBounds::new(bounds), content }
    }
}

/// What is known of the lights in a bin, as far as costs go.
#[derive(Clone, Copy)]
struct Bin {
    count: usize,
    space: Aabb,
    intensity: f64,
    /// Sum of the axes of the normals.
    axes: Vec3,
    /// Widest cone of normals.
    normals: f32,
    emission: f32,
}

impl Bin {
    const EMPTY: Self = Self {
        count: 0,
        space: Aabb::EMPTY,
        intensity: 0.0,
        axes: Vec3::ZERO,
        normals: 0.0,
        emission: 0.0,
    };

    fn add(&mut self, bounds: &EmitterBounds) {
        *self = self.union(&Self {
            count: 1,
            space: bounds.space,
            intensity: bounds.intensity,
            axes: bounds.normals.axis,
            normals: bounds.normals.angle,
            emission: bounds.emission,
        });
    }

    fn union(&self, other: &Self) -> Self {
        Self {
            count: self.count + other.count,
            space: self.space.union(other.space),
            intensity: self.intensity + other.intensity,
            axes: self.axes + other.axes,
            normals: self.normals.max(other.normals),
            emission: self.emission.max(other.emission),
        }
    }

    /// Equation 12.19 of Pharr, Jakob and Humphreys without its factor for thin boxes, with the squared diagonal
    /// instead of the surface, which is 0 for lights in a row. The cone of normals is a guess here: the one over
    /// which they were spread evenly if their mean is as long as this one.
    fn cost(&self) -> f64 {
        let mean = self.axes.length() / self.count as f32;
        let spread = (2.0 * mean - 1.0).clamp(-1.0, 1.0).acos();
        let o = f64::from((spread + self.normals).min(PI));
        let w = (o + f64::from(self.emission)).min(f64::from(PI));
        // The solid angle of directions that are lit, each weighted by the cosine to the cone of normals.
        let lit = 2.0 * (1.0 - o.cos())
            + 0.5 * (2.0 * w * o.sin() - (o - 2.0 * w).cos() - 2.0 * o * o.sin() + o.cos());
        let diagonal = (self.space.max - self.space.min).as_dvec3().length_squared();
        self.intensity * lit * diagonal
    }
}

/// Orders two lights or more for two nodes; returns where the second begins.
fn split(items: &mut [Item], level: u32) -> usize {
    let center = |item: &Item| 0.5 * item.bounds.space.min + 0.5 * item.bounds.space.max;
    let centers = Aabb::around(items.iter().map(center));
    let size = centers.max - centers.min;
    let scale = Vec3::splat(BINS as f32) / size;
    // NaN, and so the first bin, where all have the same coordinate.
    let bins = |item: &Item| {
        ((center(item) - centers.min) * scale).to_array().map(|x| (x as usize).min(BINS - 1))
    };
    let best = if level < COSTLY_LEVELS { cheapest(items, size, bins) } else { None };
    if let Some((axis, place)) = best {
        let middle = partition(items, |item| bins(item)[axis] < place);
        if middle > 0 && middle < items.len() {
            return middle;
        }
    }
    let axis =
        if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
    let half = items.len() / 2;
    items.select_nth_unstable_by(half, |a, b| {
        center(a)[axis].total_cmp(&center(b)[axis]).then(a.light.cmp(&b.light))
    });
    half
}

/// The axis and the place whose two sides cost least; `None` where nothing can be split.
fn cheapest(
    items: &[Item],
    size: Vec3,
    bins: impl Fn(&Item) -> [usize; 3],
) -> Option<(usize, usize)> {
    let mut filled = [[Bin::EMPTY; BINS]; 3];
    for item in items {
        for (row, bin) in filled.iter_mut().zip(bins(item)) {
            row[bin].add(&item.bounds);
        }
    }
    let mut best: Option<(f64, (usize, usize))> = None;
    for (axis, row) in filled.iter().enumerate().filter(|&(axis, _)| size[axis] > 0.0) {
        let mut above = [Bin::EMPTY; BINS];
        above[BINS - 1] = row[BINS - 1];
        for i in (0..BINS - 1).rev() {
            above[i] = above[i + 1].union(&row[i]);
        }
        // Long thin nodes are worth less than cubes.
        let thinness = f64::from(size.max_element() / size[axis]);
        let mut below = Bin::EMPTY;
        for place in 1..BINS {
            below = below.union(&row[place - 1]);
            if below.count == 0 || above[place].count == 0 {
                continue;
            }
            let cost = thinness * (below.cost() + above[place].cost());
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, (axis, place)));
            }
        }
    }
    best.map(|(_, split)| split)
}

/// Brings those that `is_low` holds for to the front; returns how many they are. The order depends on the items
/// alone.
fn partition(items: &mut [Item], is_low: impl Fn(&Item) -> bool) -> usize {
    let mut low = 0;
    for i in 0..items.len() {
        if is_low(&items[i]) {
            items.swap(i, low);
            low += 1;
        }
    }
    low
}
