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
                if let ChildKind::Node(index) = child.kind() {
                    if seen.nodes[index] == 1 {
                        waiting.push((index, depth + 1));
                    }
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
                Ok(holds(bounds, &build::finite(&self.analytic(index).bounds())))
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Vec3A;

    use super::*;
    use crate::intersect::accel::RustModes;
    use crate::shape::{Shape, TriangleMesh};

    /// Triangles of their own three corners each.
    fn tree(corners: impl IntoIterator<Item = [Vec3A; 3]>) -> Bvh {
        let positions: Vec<_> = corners.into_iter().flatten().collect();
        let triangles = (0..positions.len() as u32 / 3).map(|i| [0, 1, 2].map(|c| 3 * i + c));
        let mesh = TriangleMesh::new(positions, triangles.collect(), Vec::new(), Vec::new());
        let shape: Arc<dyn Shape> = Arc::new(mesh.expect("valid").0);
        Bvh::new(RustModes::default(), &[shape]).expect("few primitives")
    }

    fn triangle_at(center: Vec3A, size: f32) -> [Vec3A; 3] {
        [center, center + Vec3A::X * size, center + Vec3A::Y * size]
    }

    #[test]
    fn trees_over_anything_are_sound() {
        let unit = triangle_at(Vec3A::ZERO, 1.0);
        for count in [0, 1, 2, 7, 8, 9, 64, 100_000] {
            assert_eq!(tree((0..count).map(|_| unit)).validate(), Ok(()), "{count} coincident");
            let row = (0..count).map(|i| triangle_at(Vec3A::Z * i as f32, 1.0));
            assert_eq!(tree(row).validate(), Ok(()), "{count} in a row");
        }
        let slivers = (0..1000).map(|i| {
            let y = i as f32 * 1e-3;
            [Vec3A::new(0.0, y, 0.0), Vec3A::new(1.0, y, 0.0), Vec3A::new(1.0, y + 1e-6, y)]
        });
        assert_eq!(tree(slivers).validate(), Ok(()));
        for size in [1e-38, 1e-20, 1e17] {
            let scattered = (0..1000).map(|i| {
                let i = i as f32;
                triangle_at(Vec3A::new(i.sin(), i.cos(), (2.0 * i).sin()) * size, size)
            });
            assert_eq!(tree(scattered).validate(), Ok(()), "{size}");
        }
    }

    /// Each part of a tree that is wrong is found.
    #[test]
    fn flaws_are_found() {
        let sound = || tree((0..100).map(|i| triangle_at(Vec3A::Z * i as f32, 1.0)));
        let mut lost = sound();
        lost.packs.pop();
        assert!(matches!(lost.validate(), Err(Flaw::Dangling { .. })), "{:?}", lost.validate());
        let mut twice = sound();
        let pack = twice.packs[0].clone();
        twice.packs[1] = pack;
        assert!(twice.validate().is_err());
        let mut tight = sound();
        let child = tight.nodes[0].child(0);
        tight.nodes[0].set(0, &Aabb { min: Vec3::ZERO, max: Vec3::ZERO }, child);
        assert!(tight.validate().is_err());
    }
}
