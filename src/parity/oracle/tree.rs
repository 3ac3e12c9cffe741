//! Which primitives a ray may come near: a tree of boxes that leaves out only what is provably far.

use std::ops::ControlFlow;

use glam::{DVec3, Vec3};

use super::bound;
use super::span::Line;
use crate::math::Aabb;

/// A binary tree over boxes.
#[derive(Debug)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    /// Indices of the boxes, in the order of the leaves.
    order: Vec<u32>,
}

#[derive(Debug)]
struct Node {
    bounds: Aabb,
    /// The boxes of a leaf in `order`, empty for an inner node.
    items: std::ops::Range<u32>,
    /// The second child of an inner node; the first follows it.
    second: u32,
}

/// Boxes of a leaf at most.
const LEAF: usize = 4;

impl Tree {
    pub(super) fn new(boxes: &[Aabb]) -> Self {
        let order = (0..boxes.len() as u32).collect();
        let mut tree = Self { nodes: Vec::new(), order };
        if !boxes.is_empty() {
            tree.split(boxes, 0..boxes.len());
        }
        tree
    }

    /// One leaf for all: nothing is left out but by its own box.
    pub(super) fn flat(boxes: &[Aabb]) -> Self {
        let bounds = boxes.iter().fold(Aabb::EMPTY, |a, &b| a.union(b));
        let count = boxes.len() as u32;
        Self {
            nodes: vec![Node { bounds, items: 0..count, second: 0 }],
            order: (0..count).collect(),
        }
    }

    /// Appends the nodes over a part of the order: halves by the median of the centres along the axis
    /// on which they spread most, which ends even for boxes that all coincide.
    fn split(&mut self, boxes: &[Aabb], part: std::ops::Range<usize>) {
        let all = self.order[part.clone()].iter().map(|&i| boxes[i as usize]);
        let bounds = all.clone().fold(Aabb::EMPTY, Aabb::union);
        let node = self.nodes.len();
        let items = part.start as u32..part.end as u32;
        self.nodes.push(Node { bounds, items, second: 0 });
        if part.len() <= LEAF {
            return;
        }
        // Halved first: the sum of two of the largest coordinates is still an f32, but need not be.
        let center = |b: &Aabb| b.min * 0.5 + b.max * 0.5;
        let spread = Aabb::around(all.map(|b| center(&b)));
        let axis = (spread.max - spread.min).max_position();
        let middle = part.len() / 2;
        self.order[part.clone()].select_nth_unstable_by(middle, |&a, &b| {
            let [a, b] = [a, b].map(|i| center(&boxes[i as usize])[axis]);
            a.total_cmp(&b)
        });
        let middle = part.start + middle;
        self.split(boxes, part.start..middle);
        let second = self.nodes.len() as u32;
        self.nodes[node].items = 0..0;
        self.nodes[node].second = second;
        self.split(boxes, middle..part.end);
    }

    /// Calls `visit` with the index of each box that may hold a point of the ray's segment.
    pub(super) fn visit_crossed(&self, line: &Line, mut visit: impl FnMut(u32)) {
        let _ = self.visit(line, 1e-6, |item| {
            visit(item);
            ControlFlow::Continue(())
        });
    }

    /// Calls `visit` with the index of each box that may hold a point within the [`bound`] of the ray's
    /// segment, until it breaks off.
    pub(super) fn visit_near(
        &self,
        line: &Line,
        visit: impl FnMut(u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.visit(line, 1.0 + 1e-6, visit)
    }

    fn visit(
        &self,
        line: &Line,
        bounds_wider: f64,
        mut visit: impl FnMut(u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut stack = vec![0];
        while let Some(at) = stack.pop() {
            let node = self.nodes.get(at as usize);
            let Some(node) = node.filter(|n| may_come_near(line, &n.bounds, bounds_wider)) else {
                continue;
            };
            if node.second == 0 {
                let items = node.items.start as usize..node.items.end as usize;
                self.order[items].iter().try_for_each(|&i| visit(i))?;
            } else {
                stack.extend([node.second, at + 1]);
            }
        }
        ControlFlow::Continue(())
    }
}

/// Whether the ray's segment may come within `bounds_wider` times the bound of a point of the box.
///
/// The separating axes of a line and a box: the cross products of the line with the box's edges, and the
/// line itself for the ends of the segment. No division, hence no infinity for rays along an axis. The box
/// is widened by the bound for its farthest corner, 2⁻¹⁹ of that distance; the roundings of these products
/// are below 2⁻⁴⁹ of it, for which a millionth of the bound, 2⁻³⁹, is enough.
fn may_come_near(line: &Line, bounds: &Aabb, bounds_wider: f64) -> bool {
    let [min, max] = [bounds.min, bounds.max].map(Vec3::as_dvec3);
    let (center, half) = ((min + max) * 0.5 - line.origin, (max - min) * 0.5);
    let half = half + bounds_wider * bound((center.abs() + half).length());
    let (d, size) = (line.direction, line.direction.abs());
    let apart = center.cross(d).abs();
    let reach = DVec3::new(
        half.y * size.z + half.z * size.y,
        half.z * size.x + half.x * size.z,
        half.x * size.y + half.y * size.x,
    );
    if !apart.cmple(reach).all() {
        return false;
    }
    let (along, reach) = (center.dot(d), half.dot(size));
    let scale = d.length_squared();
    along + reach >= line.segment.near * scale && along - reach <= line.segment.far * scale
}
