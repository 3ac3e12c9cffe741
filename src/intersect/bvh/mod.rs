//! The Rust engine: a bounding volume hierarchy over all primitives of a scene.

use std::sync::Arc;

use glam::Vec3A;

use super::accel::RustModes;
use super::moller_trumbore::Triangle;
use super::{Intersector, for_each_ray};
use crate::math::Aabb;
use crate::ray::{Hit, Ray};
use crate::shape::{Analytic, Geometry, Shape};

mod build;

/// Nodes on the way from the root to a leaf, at most: the stack of a traversal.
const MAX_DEPTH: usize = 96;

/// A binary tree of boxes, built by the surface area heuristic.
#[derive(Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    /// In the order of the leaves.
    primitives: Vec<Primitive>,
    shapes: Vec<Arc<dyn Shape>>,
    modes: RustModes,
}

/// 32 bytes: two to a cache line, and the two children of a node lie side by side.
#[derive(Clone, Copy, Debug)]
struct Node {
    min: [f32; 3],
    /// The first child of an inner node, the first primitive of a leaf.
    first: u32,
    max: [f32; 3],
    /// Primitives of a leaf; 0 for an inner node.
    count: u32,
}

#[derive(Clone, Copy, Debug)]
enum Primitive {
    Triangle { triangle: Triangle, shape: u32, primitive: u32 },
    Analytic { shape: u32 },
}

/// What a traversal needs of a ray: computed once.
struct Slabs {
    origin: Vec3A,
    inverse_direction: Vec3A,
}

impl Slabs {
    fn new(ray: &Ray) -> Self {
        // Infinite inverses would give 0 * inf = NaN for a ray that starts in a plane of the box; the
        // largest number in their place gives 0, which counts as inside.
        let limit = Vec3A::splat(f32::MAX);
        let inverse_direction = ray.direction.recip().clamp(-limit, limit);
        Self { origin: ray.origin, inverse_direction }
    }

    /// Where the ray enters the box, if it does so within `[t_min, t_max]`.
    fn enter(&self, node: &Node, t_min: f32, t_max: f32) -> Option<f32> {
        let to_min = (Vec3A::from(node.min) - self.origin) * self.inverse_direction;
        let to_max = (Vec3A::from(node.max) - self.origin) * self.inverse_direction;
        let near = to_min.min(to_max).max_element().max(t_min);
        // Ize, "Robust BVH Ray Traversal" (2013): 1 + 2γ₃ makes up for the three roundings of each side.
        const WIDEN: f32 = 1.0 + 2.0 * (3.0 * 5.960_464_5e-8 / (1.0 - 3.0 * 5.960_464_5e-8));
        let far = (to_min.max(to_max).min_element() * WIDEN).min(t_max);
        (near <= far).then_some(near)
    }
}

impl Bvh {
    /// Builds over `shapes`, in parallel in the current thread pool. The tree does not depend on the
    /// number of threads.
    #[must_use]
    pub fn new(modes: RustModes, shapes: &[Arc<dyn Shape>]) -> Self {
        let mut primitives = Vec::new();
        let mut bounds = Vec::new();
        for (index, shape) in shapes.iter().enumerate() {
            let index = index as u32;
            match shape.geometry() {
                Geometry::Triangles { positions, triangles } => {
                    for (primitive, corners) in triangles.iter().enumerate() {
                        let corners = corners.map(|i| positions[i as usize].into());
                        bounds.push(Aabb::around(corners));
                        primitives.push(Primitive::Triangle {
                            triangle: Triangle::new(corners),
                            shape: index,
                            primitive: primitive as u32,
                        });
                    }
                }
                Geometry::Analytic(analytic) => {
                    bounds.push(analytic.bounds());
                    primitives.push(Primitive::Analytic { shape: index });
                }
            }
        }
        let (nodes, order) = build::build(&bounds);
        let primitives = order.iter().map(|&i| primitives[i as usize]).collect();
        Self { nodes, primitives, shapes: shapes.to_vec(), modes }
    }

    fn analytic(&self, shape: u32) -> &dyn Analytic {
        match self.shapes[shape as usize].geometry() {
            Geometry::Analytic(analytic) => analytic,
            Geometry::Triangles { .. } => unreachable!("built from an analytic shape"),
        }
    }

    fn intersect(&self, primitive: &Primitive, ray: &Ray) -> Option<Hit> {
        match *primitive {
            Primitive::Triangle { triangle, shape, primitive } => {
                triangle.intersect(ray).map(|(t, u, v)| Hit { t, u, v, shape, primitive })
            }
            Primitive::Analytic { shape } => self
                .analytic(shape)
                .intersect(ray)
                .map(|(t, u, v)| Hit { t, u, v, shape, primitive: 0 }),
        }
    }

    /// Visits the leaves that the ray may hit, the nearer child first. `visit` gets the primitives of a
    /// leaf and the ray, which it may shorten; it returns whether to go on.
    fn traverse(&self, mut ray: Ray, mut visit: impl FnMut(&[Primitive], &mut Ray) -> bool) {
        if self.nodes.is_empty() || !ray.is_traceable() {
            return;
        }
        let slabs = Slabs::new(&ray);
        let mut stack = [(0u32, 0f32); MAX_DEPTH];
        let mut height = 0;
        let Some(_) = slabs.enter(&self.nodes[0], ray.t_min, ray.t_max) else {
            return;
        };
        let mut current = 0u32;
        loop {
            let node = &self.nodes[current as usize];
            if node.count > 0 {
                let first = node.first as usize;
                if !visit(&self.primitives[first..first + node.count as usize], &mut ray) {
                    return;
                }
            } else {
                let enter = |child: u32| {
                    let child_node = &self.nodes[child as usize];
                    slabs.enter(child_node, ray.t_min, ray.t_max).map(|t| (child, t))
                };
                match (enter(node.first), enter(node.first + 1)) {
                    (Some(a), Some(b)) => {
                        let (near, far) = if a.1 <= b.1 { (a, b) } else { (b, a) };
                        stack[height] = far;
                        height += 1;
                        current = near.0;
                        continue;
                    }
                    (Some((child, _)), None) | (None, Some((child, _))) => {
                        current = child;
                        continue;
                    }
                    (None, None) => {}
                }
            }
            // The next box that is still nearer than what was found meanwhile.
            loop {
                if height == 0 {
                    return;
                }
                height -= 1;
                let (node, t) = stack[height];
                if t <= ray.t_max {
                    current = node;
                    break;
                }
            }
        }
    }
}

impl Intersector for Bvh {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        let mut closest = None;
        self.traverse(*ray, |primitives, ray| {
            for primitive in primitives {
                if let Some(hit) = self.intersect(primitive, ray) {
                    ray.t_max = hit.t;
                    closest = Some(hit);
                }
            }
            true
        });
        closest
    }

    fn occluded(&self, ray: &Ray) -> bool {
        let mut occluded = false;
        self.traverse(*ray, |primitives, ray| {
            occluded = primitives.iter().any(|p| self.intersect(p, ray).is_some());
            !occluded
        });
        occluded
    }

    fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for_each_ray(rays, hits, |ray| self.closest_hit(ray));
    }

    fn occluded_many(&self, rays: &[Ray], occluded: &mut [bool]) {
        for_each_ray(rays, occluded, |ray| self.occluded(ray));
    }

    fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.primitives.as_slice())
    }

    fn name(&self) -> String {
        format!("Rust BVH {}, {}", env!("CARGO_PKG_VERSION"), self.modes)
    }
}
