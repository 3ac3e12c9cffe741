//! Trees over meshes that deform: one for each part of the shutter in which the vertices go along straight
//! lines. So do the planes of its boxes, which at each moment hold what is in them.

use std::sync::Arc;

use arrayvec::ArrayVec;
use glam::Vec3;
use rayon::prelude::*;

use super::LANES;
use super::build::{self, Reference, outward};
use super::node::{Child, ChildKind, Node, Slabs};
use super::traverse::{Entry, STACK, sort_descending, without_denormals};
use crate::intersect::spurious::{Doubt, meets_triangle};
use crate::intersect::triangle::{RayTriangle, TriangleHit, Watertight, in_f64, nearer};
use crate::math::real::{Lanes, Level, Mask, Simd, Task, f32x8};
use crate::math::{Aabb, UNIT_ROUNDOFF as U};
use crate::ray::{Hit, Ray};
use crate::shape::{DeformingMesh, Geometry, Shape};

/// Answers for a deforming mesh in every engine: Embree's own would place vertices by a rounding elsewhere.
#[derive(Debug)]
pub(in crate::intersect) struct MovingTree {
    shape: Arc<dyn Shape>,
    parts: Vec<Part>,
    level: Level,
}

/// A part of the shutter.
#[derive(Debug)]
struct Part {
    begin: f32,
    end: f32,
    /// Each node as it is at the beginning and at the end.
    nodes: Vec<[Node; 2]>,
}

impl MovingTree {
    /// Over the triangles of `shape`; `None` if that is no deforming mesh.
    pub(in crate::intersect) fn new(shape: &Arc<dyn Shape>) -> Option<Self> {
        let Geometry::Deforming(mesh) = shape.geometry() else {
            return None;
        };
        let moments = mesh.moments();
        let parts = moments.windows(2).map(|pair| Part::new(mesh, pair[0], pair[1])).collect();
        Some(Self { shape: Arc::clone(shape), parts, level: Level::detect() })
    }

    fn mesh(&self) -> &DeformingMesh {
        match self.shape.geometry() {
            Geometry::Deforming(mesh) => mesh,
            _ => unreachable!("built over a deforming mesh"),
        }
    }

    /// The nearest hit within the ray's segment or, if `ANY`, just some hit, as one of the only shape.
    pub(in crate::intersect) fn hit<const ANY: bool>(
        &self,
        ray: &Ray,
        doubt: Doubt,
    ) -> Option<Hit> {
        let part = self.parts.iter().find(|part| ray.time <= part.end).or(self.parts.last())?;
        if part.nodes.is_empty() {
            return None;
        }
        let ray = Ray { direction: without_denormals(ray.direction), ..*ray };
        let walk = Walk::<ANY> { mesh: self.mesh(), part, ray, doubt };
        let (TriangleHit { t, u, v }, primitive) = self.level.run(walk)?;
        Some(Hit { t, u, v, shape: 0, primitive, member: 0 })
    }

    /// Bytes of its nodes.
    pub(in crate::intersect) fn bytes(&self) -> usize {
        self.parts.iter().map(|part| size_of_val(part.nodes.as_slice())).sum()
    }
}

impl Part {
    /// Divides by where triangles are halfway.
    fn new(mesh: &DeformingMesh, begin: f32, end: f32) -> Self {
        let around = |primitive: u32, time: f32| {
            Aabb::around(mesh.corners(primitive as usize, time).map(Vec3::from))
        };
        let middle = 0.5 * (begin + end);
        let count = mesh.triangles().len() as u32;
        let reference = |i| Reference::new(&around(i, middle), i, Some(i as usize));
        let references = (0..count).into_par_iter().map(reference).collect();
        let nodes = build::build(references).nodes;
        let mut moving: Vec<_> = nodes.iter().map(|node| [node.moving(), node.moving()]).collect();
        // Nodes come after those that they are below.
        for index in (0..nodes.len()).rev() {
            for (i, _, child) in nodes[index].children() {
                let boxes = match child.kind() {
                    ChildKind::Node(below) => [0, 1].map(|side| moving[below][side].around()),
                    ChildKind::Shape(primitive) => {
                        let primitive = primitive as u32;
                        with_margin([around(primitive, begin), around(primitive, end)])
                    }
                    ChildKind::Triangles(_) => unreachable!("each triangle is a leaf of its own"),
                };
                for (side, bounds) in boxes.iter().enumerate() {
                    moving[index][side].set(i, bounds, child);
                }
            }
        }
        Self { begin, end, nodes: moving }
    }

    /// How far a moment is from the beginning to the end.
    fn fraction(&self, time: f32) -> f32 {
        let length = f64::from(self.end) - f64::from(self.begin);
        let fraction = (f64::from(time) - f64::from(self.begin)) / length;
        if length > 0.0 { fraction.clamp(0.0, 1.0) as f32 } else { 0.0 }
    }
}

/// Boxes of a triangle at two moments, with the margin that a box at rest has, and one for what [`Node::between`]
/// rounds: with u = 2⁻²⁴, the fraction f is off by u f, so a plane p (1 - f) + q f by u |q - p|; 1 - f, both
/// products and the sum are rounded once, which adds less than 3u max(|p|, |q|).
fn with_margin(boxes: [Aabb; 2]) -> [Aabb; 2] {
    let [a, b] = boxes.map(|bounds| outward(&bounds));
    let reach = a.min.abs().max(a.max.abs()).max(b.min.abs()).max(b.max.abs());
    let margin = reach * (8.0 * U);
    [a, b].map(|bounds| Aabb { min: bounds.min - margin, max: bounds.max + margin })
}

/// The nearest hit of a ray or, if `ANY`, just some hit; of hits at the same f32 as in the tree of what rests.
struct Walk<'a, const ANY: bool> {
    mesh: &'a DeformingMesh,
    part: &'a Part,
    ray: Ray,
    doubt: Doubt,
}

impl<const ANY: bool> Task for Walk<'_, ANY> {
    type Output = Option<(TriangleHit, u32)>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let Self { mesh, part, mut ray, doubt } = self;
        let (test, slabs) = (Watertight::new(&ray), Slabs::new(&ray));
        let fraction = part.fraction(ray.time);
        let t_min = f32x8::splat(simd, ray.t_min);
        let mut found: Option<(TriangleHit, u32)> = None;
        let mut stack = ArrayVec::<Entry, STACK>::new();
        let mut child = Child::new(ChildKind::Node(0));
        loop {
            match child.kind() {
                ChildKind::Node(index) => {
                    let [begin, end] = &part.nodes[index];
                    let node = begin.between(simd, end, fraction);
                    let t_max = f32x8::splat(simd, ray.t_max);
                    let (entered, distance) = slabs.enter(&node, t_min, t_max);
                    let mut mask = entered.bits();
                    let mut near = [0.0; LANES];
                    distance.store(&mut near);
                    let waiting = stack.len();
                    while mask != 0 {
                        let i = mask.trailing_zeros() as usize % LANES;
                        mask &= mask - 1;
                        stack.push(Entry::new(near[i], node.child(i)));
                    }
                    sort_descending(&mut stack[waiting..]);
                }
                ChildKind::Shape(primitive) => {
                    let corners_of = |primitive| {
                        let corners = mesh.corners(primitive, ray.time);
                        corners.map(|corner| Vec3::from(corner).to_array())
                    };
                    let corners = corners_of(primitive);
                    let primitive = primitive as u32;
                    let is_behind = |best: u32| {
                        let order = nearer(&ray, &corners_of(best as usize), &corners);
                        order.then(best.cmp(&primitive)).is_le()
                    };
                    let hit = test.hit(&ray, &corners).filter(|hit| {
                        let true_hit =
                            !doubt.covers(hit.t) || meets_triangle(&ray, hit.t, in_f64(&corners));
                        true_hit && !found.is_some_and(|(best, i)| hit.t == best.t && is_behind(i))
                    });
                    if let Some(hit) = hit {
                        found = Some((hit, primitive));
                        if ANY {
                            return found;
                        }
                        ray.t_max = hit.t;
                    }
                }
                ChildKind::Triangles(_) => unreachable!("each triangle is a leaf of its own"),
            }
            // The nearest that waits and is still nearer than what was found meanwhile.
            let reach = Slabs::reach(ray.t_max);
            child = loop {
                let Some(entry) = stack.pop() else { return found };
                if entry.distance() <= reach {
                    break entry.child();
                }
            };
        }
    }
}
