//! The Rust engine: a bounding volume hierarchy over all primitives of a scene.
//!
//! A tree whose nodes have up to eight children (Wald, Benthin and Boulos, "Getting Rid of Packets",
//! 2008), so that one ray is tested against eight boxes, or eight triangles of a leaf, at a time.

use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::accel::{RustModes, TriangleTest};
use super::groups::{build_groups, distinct};
use super::spurious::{Doubt, intersect_analytic};
use super::triangle::{Corners, Plain, Watertight};
use super::{BuildError, Intersector, for_each_ray, reach};
use crate::math::real::Level;
use crate::ray::{Hit, Ray, Rays};
use crate::shape::{Geometry, Shape};

mod build;
mod moving;
mod node;
#[cfg(test)]
mod tests;
mod traverse;
mod validate;

pub(super) use moving::MovingTree;
use node::{Child, Node, Pack};
use traverse::{Found, Inner, Walk};
pub use validate::Flaw;

/// Boxes in a node, and triangles in a leaf: as many as lanes.
const LANES: usize = 8;

/// A tree of boxes, built by the surface area heuristic.
#[derive(Debug)]
pub struct Bvh {
    /// The root first; none if there are no primitives.
    nodes: Vec<Node>,
    packs: Vec<Pack>,
    shapes: Vec<Arc<dyn Shape>>,
    /// Primitives of all shapes are numbered through: where each shape begins, and the end.
    offsets: Vec<u32>,
    /// By shape: the tree over the group of an instance. Empty if there is no instance.
    groups: Vec<Option<Arc<Bvh>>>,
    /// By shape: the tree over a mesh that deforms.
    moving: Vec<Option<MovingTree>>,
    modes: RustModes,
    level: Level,
    /// See [`reach`].
    reach: f32,
}

impl Bvh {
    /// Builds over `shapes`, in parallel in the current thread pool. The tree does not depend on the
    /// number of threads.
    ///
    /// # Errors
    /// More primitives than the tree can number.
    pub fn new(modes: RustModes, shapes: &[Arc<dyn Shape>]) -> Result<Self, BuildError> {
        let offsets = offsets(shapes)?;
        let references = build::references(shapes, &offsets);
        let tree = build::build(references);
        let corners = |id| corners(shapes, &offsets, id);
        let pack = |leaf: &build::Leaf| Pack::new(&tree.order[leaf.range()], corners);
        let packs = tree.leaves.par_iter().map(pack).collect();
        let groups = build_groups(shapes, |members| Self::new(modes, members))?;
        let moving = shapes.iter().map(MovingTree::new).collect();
        let level = Level::detect();
        let (reach, shapes) = (reach(shapes), shapes.to_vec());
        Ok(Self { nodes: tree.nodes, packs, shapes, offsets, groups, moving, modes, level, reach })
    }

    /// The nearest hit with a shape that has a test of its own or, if `ANY`, just some hit.
    fn intersect_shape<const ANY: bool>(
        &self,
        shape: usize,
        ray: &Ray,
        doubt: Doubt,
    ) -> Option<Found> {
        let id = self.offsets[shape];
        match self.shapes[shape].geometry() {
            Geometry::Deforming(_) => {
                let Hit { t, u, v, primitive, .. } =
                    self.moving[shape].as_ref()?.hit::<ANY>(ray, doubt)?;
                Some(Found { t, u, v, id, inner: Inner { member: 0, primitive } })
            }
            Geometry::Analytic(analytic) => {
                let (t, u, v) = intersect_analytic(ray, analytic, doubt)?;
                Some(Found { t, u, v, id, inner: Inner::NONE })
            }
            Geometry::Instance(instance) => {
                let group = self.groups[shape].as_ref()?;
                // Where it was hit is not asked.
                if ANY {
                    let within = group.trace::<ANY>(&instance.local(ray).ray)?;
                    return Some(Found { id, ..within });
                }
                let hit = instance.nearest(ray, |local| group.closest_hit(local))?;
                let Hit { t, u, v, primitive, member, .. } = hit;
                Some(Found { t, u, v, id, inner: Inner { member, primitive } })
            }
            Geometry::Triangles { .. } => unreachable!("built from another shape"),
        }
    }

    #[inline]
    fn trace<const ANY: bool>(&self, ray: &Ray) -> Option<Found> {
        if self.nodes.is_empty() || !ray.is_traceable() {
            return None;
        }
        match self.modes.triangle {
            TriangleTest::Watertight => self.level.run(Walk::<Watertight, ANY>::new(self, *ray)),
            TriangleTest::Plain => self.level.run(Walk::<Plain, ANY>::new(self, *ray)),
        }
    }
}

/// Where the primitives of each shape begin, and the number of all.
fn offsets(shapes: &[Arc<dyn Shape>]) -> Result<Vec<u32>, BuildError> {
    let count = |shape: &Arc<dyn Shape>| match shape.geometry() {
        Geometry::Triangles { triangles, .. } => triangles.len(),
        Geometry::Deforming(_) | Geometry::Analytic(_) | Geometry::Instance(_) => 1,
    };
    let mut offsets = vec![0];
    let mut total = 0usize;
    for shape in shapes {
        total += count(shape);
        if total > Child::LIMIT {
            return Err(BuildError::TooManyPrimitives { limit: Child::LIMIT });
        }
        offsets.push(total as u32);
    }
    Ok(offsets)
}

/// Shape and primitive that have a number.
#[inline]
fn locate(offsets: &[u32], id: u32) -> (usize, u32) {
    let shape = offsets.partition_point(|&first| first <= id) - 1;
    (shape, id - offsets[shape])
}

fn corners(shapes: &[Arc<dyn Shape>], offsets: &[u32], id: u32) -> Corners {
    let (shape, primitive) = locate(offsets, id);
    let corners = shapes[shape].geometry().corners(primitive, 0.0);
    corners.expect("leaves of triangles hold triangles").map(|p| Vec3::from(p).to_array())
}

impl Intersector for Bvh {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        let Found { t, u, v, id, inner } = self.trace::<false>(ray)?;
        let (shape, primitive) = locate(&self.offsets, id);
        // One of both is 0.
        let primitive = primitive + inner.primitive;
        Some(Hit { t, u, v, shape: shape as u32, primitive, member: inner.member })
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.trace::<true>(ray).is_some()
    }

    fn closest_hits(&self, rays: &Rays, hits: &mut [Option<Hit>]) {
        for_each_ray(rays, hits, |ray| self.closest_hit(ray));
    }

    fn occluded_many(&self, rays: &Rays, occluded: &mut [bool]) {
        for_each_ray(rays, occluded, |ray| self.occluded(ray));
    }

    fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice())
            + size_of_val(self.packs.as_slice())
            + size_of_val(self.offsets.as_slice())
            + size_of_val(self.groups.as_slice())
            + distinct(&self.groups).map(|group| group.bytes()).sum::<usize>()
            + self.moving.iter().flatten().map(MovingTree::bytes).sum::<usize>()
    }

    fn name(&self) -> String {
        format!("Rust BVH {}, {}", env!("CARGO_PKG_VERSION"), self.modes)
    }
}
