//! The referee: which primitives a ray truly crosses, where, and what rounding may excuse.
//!
//! **Crossings** are exact. Whether a line passes a triangle's edge on its left or right is decided by
//! determinants whose sign is exact on the f32 input; the border belongs to the triangle, and a line in its
//! plane does not cross it. Spheres and disks are intersected in f64.
//!
//! **The bound.** An f32 engine is forgiven what a shift of the triangle by [`bound`] would explain:
//! 32 u R, where u = 2⁻²⁴ and R is the distance of the ray's origin from the farthest corner. A watertight
//! test (Woop, Benthin and Wald 2013) rounds each corner relative to the origin (u R), its shear (u R each
//! for the constant, the product and the difference, on two axes) and the weighted distance (5 u R): about
//! 12 u R in all. A Plücker test, Embree's robust one, rounds an edge (u), the sum of its ends
//! (u), their cross product (2 u) and its dot product with the direction (3 u), which moves the edge by up
//! to 8 u R, and the same again moves the plane, over a well-shaped triangle. 32 leaves a margin of 2.
//! Sideways, a sliver is forgiven no more than that.
//!
//! **Distances.** t may be off by 16 u (R + L S) over the cosine c between ray and normal, where L is the longest
//! edge, A the area and S = L²/2A the triangle's shape, 2 for half a square; whether it is that of the right
//! primitive or not. The plane's distance, (a·n)/(d·n) with a corner a, is what errs most: a is
//! rounded (u R), and so are a·n (3 u R |n|, three products and their sum) and d·n (3 u |n|, which is 3 u R/c of
//! t), then the quotient (2 u R, an approximate reciprocal and a product), 9 u R/c at most. The normal is a difference
//! of products of two edges, of L² each and 2A together, of which each component is rounded by 3 u L²: the plane
//! tilts by 5 u S, and its far end moves by 5 u L S. That rounded corners tilt it as well adds u R, since none of
//! its points moves by more than the corners do. A mean of the corners' distances by weights, as a watertight test
//! takes it, has the same terms. 16 leaves a margin of 1.5. (Of 4·10⁵ hits of robust Embree on 871,000 triangles
//! the worst was off by 4.6 u (R + L S)/c.) Möller and Trumbore's products have distances in the place of
//! an edge and err by u R S, which is not excused.
//!
//! Where c is so small that this leaves the triangle, t must still be that of one of its points, to 16 u R. A mean
//! of the corners' distances always is. The plane's distance need not be: of triangles that it sees from the
//! side Embree reports any, and these are faults.
//!
//! **What must be hit.** Take all primitives within the bound of the ray. If each of their edges that is
//! within it has such primitives on both sides, as the ray sees it, then no edge of the whole passes
//! there: it covers the ray's surroundings, wherever rounding moves its corners, and an answer that goes
//! through it is a leak. Neither a closed mesh nor shared indices are needed: edges are compared by the
//! positions of their ends. If an edge has a side that is bare, the ray is at a silhouette.
//! Where more than [`MOST_NEAR`] primitives are within the bound, f32 does not tell them apart, and whether they
//! cover the ray is left open.
//!
//! **Instances** are judged in the space of their group, where all engines ask about one and the same ray
//! ([`Instance::local`](crate::shape::Instance::local)): a referee over the group says what this ray meets, and
//! distances are taken back to the scene.

use std::convert::Infallible;
use std::sync::Arc;

use glam::{Vec3, Vec3A};

use crate::intersect::groups::build_groups;
use crate::math::{Aabb, UNIT_ROUNDOFF};
use crate::ray::Ray;
use crate::shape::{Geometry, Shape};

mod analytic;
mod cover;
mod exact;
mod nested;
mod span;
mod tree;
mod triangle;
mod truth;

#[cfg(test)]
mod bound_tests;
#[cfg(test)]
mod tests;

pub use span::Span;
pub use truth::{Encounter, Truth};

use tree::Tree;

/// What rounding in f32 may shift, at a distance `reach` from the origin of a ray: see the module.
#[must_use]
pub fn bound(reach: f64) -> f64 {
    const FACTOR: f64 = 32.0 * UNIT_ROUNDOFF as f64;
    FACTOR * reach
}

/// What rounding in f32 may shift the plane of a triangle by, whose corners are up to `reach` away from the origin of
/// a ray, and whose edges of up to `longest` make the shape `shape`: see the module on distances.
#[must_use]
fn distance_bound(reach: f64, longest: f64, shape: f64) -> f64 {
    0.5 * bound(reach + longest * shape)
}

/// Primitives within the bound of a ray beyond which the referee does not ask what they cover: more than meet at any
/// vertex of a mesh that was made for rendering. The time of a ray is bounded by it.
pub const MOST_NEAR: usize = 1000;

/// Knows the truth about rays over the shapes that it was built from.
#[derive(Debug)]
pub struct Oracle {
    shapes: Vec<Arc<dyn Shape>>,
    /// Shape and primitive of each box of the tree.
    primitives: Vec<(u32, u32)>,
    tree: Tree,
    /// By shape: the referee over the group of an instance. Empty if there is no instance.
    groups: Vec<Option<Arc<Oracle>>>,
}

impl Oracle {
    /// The referee over `shapes`, which looks only at what its tree of boxes cannot leave out.
    #[must_use]
    pub fn new(shapes: &[Arc<dyn Shape>]) -> Self {
        Self::with_tree(shapes, Tree::new)
    }

    /// The referee by brute force: looks at every primitive for every ray.
    #[must_use]
    pub fn brute_force(shapes: &[Arc<dyn Shape>]) -> Self {
        Self::with_tree(shapes, Tree::flat)
    }

    fn with_tree(shapes: &[Arc<dyn Shape>], tree: fn(&[Aabb]) -> Tree) -> Self {
        let (mut primitives, mut boxes) = (Vec::new(), Vec::new());
        for (shape, index) in shapes.iter().zip(0..) {
            for primitive in 0..primitives_of(shape.as_ref()) {
                primitives.push((index, primitive));
                boxes.push(match shape.geometry() {
                    Geometry::Triangles { .. } => {
                        Aabb::around(corners(shape.as_ref(), primitive, 0.0).map(Vec3::from))
                    }
                    Geometry::Deforming(mesh) => mesh.primitive_bounds(primitive as usize),
                    Geometry::Analytic(_) | Geometry::Instance(_) => shape.bounds(),
                });
            }
        }
        let group = |shapes: &[Arc<dyn Shape>]| Ok::<_, Infallible>(Self::with_tree(shapes, tree));
        let Ok(groups) = build_groups(shapes, group);
        Self { shapes: shapes.to_vec(), primitives, tree: tree(&boxes), groups }
    }

    /// What lies along a ray.
    #[must_use]
    pub fn examine(&self, ray: &Ray) -> Truth<'_> {
        Truth::new(self, ray)
    }
}

/// Boxes that a shape takes in the tree.
fn primitives_of(shape: &dyn Shape) -> u32 {
    match shape.geometry() {
        Geometry::Instance(_) => 1,
        _ => shape.primitive_count() as u32,
    }
}

/// The corners of a triangle at a moment.
fn corners(shape: &dyn Shape, primitive: u32, time: f32) -> [Vec3A; 3] {
    shape.geometry().corners(primitive, time).expect("asked of meshes only")
}
