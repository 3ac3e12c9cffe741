//! Whether a tree is what traversal takes it for.

use glam::Vec3;

use super::node::{Child, ChildKind};
use super::traverse::MAX_DEPTH;
use super::{Bvh, build, corners};
use crate::intersect::lanes::LANES;
use crate::math::Aabb;

/// What is wrong with a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Flaw {
    /// A node, pack or shape that is not there.
    #[error("node {node} refers to {what} {index}, but there are {count}")]
    Dangling {
        /// Index of the node.
        node: usize,
        /// `"node"`, `"pack"` or `"shape"`.
        what: &'static str,
        /// What it refers to.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// More nodes on the way to a leaf than the stack of a traversal has room for.
    #[error("node {node} lies below {depth} nodes (at most {} allowed)", MAX_DEPTH - 1)]
    TooDeep {
        /// Index of the node.
        node: usize,
        /// Nodes above it.
        depth: usize,
    },
    /// The box of a child does not hold what is in the child.
    #[error("child {child} of node {node} reaches out of its box")]
    BoxTooSmall {
        /// Index of the node.
        node: usize,
        /// Its place in the node.
        child: usize,
    },
    /// A triangle of a pack that is not the mesh's.
    #[error("pack {pack} has another triangle than the scene's primitive {primitive}")]
    OtherTriangle {
        /// Index of the pack.
        pack: usize,
        /// Index of the primitive in the scene.
        primitive: u32,
    },
    /// A node, pack or primitive that a ray meets never, or more than once.
    #[error("{what} {index} is in {times} places")]
    NotOnce {
        /// `"node"`, `"pack"` or `"primitive"`.
        what: &'static str,
        /// Which.
        index: usize,
        /// How often it was found.
        times: u32,
    },
}

/// How often each thing was found.
struct Seen {
    nodes: Vec<u32>,
    packs: Vec<u32>,
    primitives: Vec<u32>,
}

impl Bvh {
    /// Checks that every primitive is in exactly one leaf, that each box holds the boxes and primitives
    /// below it, and that the tree is no deeper than a traversal can follow.
    ///
    /// # Errors
    /// The first flaw that is found.
    pub fn validate(&self) -> Result<(), Flaw> {
        let primitives = self.offsets[self.offsets.len() - 1] as usize;
        let mut seen = Seen {
            nodes: vec![0; self.nodes.len()],
            packs: vec![0; self.packs.len()],
            primitives: vec![0; primitives],
        };
        // Nodes to look at, with the number of those above.
        let mut waiting = Vec::new();
        if let Some(root) = seen.nodes.first_mut() {
            *root = 1;
            waiting.push((0, 0));
        }
        while let Some((node, depth)) = waiting.pop() {
            if depth >= MAX_DEPTH {
                return Err(Flaw::TooDeep { node, depth });
            }
            for (i, bounds, child) in self.nodes[node].children() {
                let inside = self.visit(node, child, &bounds, &mut seen)?;
                if !inside {
                    return Err(Flaw::BoxTooSmall { node, child: i });
                }
                // What was found twice may be a circle.
                if let ChildKind::Node(index) = child.kind()
                    && seen.nodes[index] == 1
                {
                    waiting.push((index, depth + 1));
                }
            }
        }
        once("node", &seen.nodes)?;
        once("pack", &seen.packs)?;
        once("primitive", &seen.primitives)
    }

    /// Counts a child of `node`; returns whether its box holds what is in it.
    fn visit(
        &self,
        node: usize,
        child: Child,
        bounds: &Aabb,
        seen: &mut Seen,
    ) -> Result<bool, Flaw> {
        let find = |what, index: usize, count: usize| {
            if index < count { Ok(()) } else { Err(Flaw::Dangling { node, what, index, count }) }
        };
        match child.kind() {
            ChildKind::Node(index) => {
                find("node", index, self.nodes.len())?;
                seen.nodes[index] += 1;
                let inside = self.nodes[index].children().all(|(_, b, _)| holds(bounds, &b));
                Ok(inside)
            }
            ChildKind::Triangles(index) => {
                find("pack", index, self.packs.len())?;
                seen.packs[index] += 1;
                self.visit_pack(index, bounds, seen)
            }
            ChildKind::Shape(index) => {
                find("shape", index, self.shapes.len())?;
                seen.primitives[self.offsets[index] as usize] += 1;
                Ok(holds(bounds, &build::finite(&self.shapes[index].bounds())))
            }
        }
    }

    fn visit_pack(&self, index: usize, bounds: &Aabb, seen: &mut Seen) -> Result<bool, Flaw> {
        let pack = &self.packs[index];
        let mut inside = true;
        for lane in (0..LANES).filter(|&lane| pack.is_occupied(lane)) {
            let primitive = pack.id(lane);
            let Some(times) = seen.primitives.get_mut(primitive as usize) else {
                return Err(Flaw::OtherTriangle { pack: index, primitive });
            };
            *times += 1;
            let triangle = corners(&self.shapes, &self.offsets, primitive);
            if pack.corners(lane) != triangle {
                return Err(Flaw::OtherTriangle { pack: index, primitive });
            }
            let around = Aabb::around(triangle.map(Vec3::from));
            inside &= holds(bounds, &build::outward(&around));
        }
        Ok(inside)
    }
}

fn holds(outer: &Aabb, inner: &Aabb) -> bool {
    outer.min.cmple(inner.min).all() && inner.max.cmple(outer.max).all()
}

fn once(what: &'static str, times: &[u32]) -> Result<(), Flaw> {
    match times.iter().position(|&t| t != 1) {
        Some(index) => Err(Flaw::NotOnce { what, index, times: times[index] }),
        None => Ok(()),
    }
}
