//! Nodes of the tree and the leaves' triangles, as they lie in memory, and the test of a ray against
//! the boxes of a node.

use super::LANES;
use crate::intersect::triangle::{Corners, Corners8};
use crate::math::real::{Float, Lanes, Real, Simd, Uint, f32x8, mask32x8, u32x8};
use crate::math::{Aabb, UNIT_ROUNDOFF};
use crate::ray::Ray;

/// Boxes of up to eight children and what is in them. Four cache lines.
#[derive(Clone, Debug, PartialEq)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// By axis: the lower planes of all boxes, then the upper ones.
    planes: [[[f32; LANES]; 2]; 3],
    children: [Child; LANES],
}

/// What a child is, and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Child(u32);

/// The same, to look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ChildKind {
    /// Index of a node.
    Node(usize),
    /// Index of a pack.
    Triangles(usize),
    /// Index of a shape with a test of its own.
    Shape(usize),
}

impl Child {
    /// Nodes, packs and shapes that a tree can have of each.
    pub(super) const LIMIT: usize = 1 << 30;

    const LEAF: u32 = 1 << 31;
    const SHAPE: u32 = 1 << 30;

    pub(super) fn new(kind: ChildKind) -> Self {
        Self(match kind {
            ChildKind::Node(index) => index as u32,
            ChildKind::Triangles(index) => index as u32 | Self::LEAF,
            ChildKind::Shape(index) => index as u32 | Self::LEAF | Self::SHAPE,
        })
    }

    #[inline(always)]
    pub(super) fn kind(self) -> ChildKind {
        let index = (self.0 & (Self::SHAPE - 1)) as usize;
        match (self.0 & Self::LEAF, self.0 & Self::SHAPE) {
            (0, _) => ChildKind::Node(index),
            (_, 0) => ChildKind::Triangles(index),
            _ => ChildKind::Shape(index),
        }
    }

    /// The same child when other nodes and packs come before it.
    pub(super) fn shifted(self, nodes: usize, packs: usize) -> Self {
        Self::new(match self.kind() {
            ChildKind::Node(index) => ChildKind::Node(index + nodes),
            ChildKind::Triangles(index) => ChildKind::Triangles(index + packs),
            kind @ ChildKind::Shape(_) => kind,
        })
    }

    pub(super) fn bits(self) -> u32 {
        self.0
    }

    pub(super) fn from_bits(bits: u32) -> Self {
        Self(bits)
    }
}

impl Node {
    /// A node without children: boxes that no ray enters.
    pub(super) const EMPTY: Self = Self {
        planes: [[[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]]; 3],
        children: [Child(0); LANES],
    };

    pub(super) fn set(&mut self, i: usize, bounds: &Aabb, child: Child) {
        for (axis, [lower, upper]) in self.planes.iter_mut().enumerate() {
            lower[i] = bounds.min[axis];
            upper[i] = bounds.max[axis];
        }
        self.children[i] = child;
    }

    #[inline(always)]
    pub(super) fn child(&self, i: usize) -> Child {
        self.children[i]
    }

    pub(super) fn bounds(&self, i: usize) -> Aabb {
        let corner = |side: usize| self.planes.map(|planes| planes[side][i]).into();
        Aabb { min: corner(0), max: corner(1) }
    }

    /// The places that are taken: their index, box and child.
    pub(super) fn children(&self) -> impl Iterator<Item = (usize, Aabb, Child)> {
        let place = |(i, &child)| (i, self.bounds(i), child);
        self.children.iter().enumerate().map(place).filter(|(_, bounds, _)| !bounds.is_empty())
    }

    /// Moves what the children refer to, when the arrays that hold it are appended to others.
    pub(super) fn shift(&mut self, nodes: usize, packs: usize) {
        for child in &mut self.children {
            *child = child.shifted(nodes, packs);
        }
    }
}

impl Node {
    /// Without boxes: those of free places hold nothing, as in [`Node::EMPTY`], and are finite, so that
    /// [`Node::between`] two of them is as empty.
    pub(super) fn moving(&self) -> Self {
        const FAR: f32 = f32::MAX / 4.0;
        Self { planes: [[[FAR; LANES], [-FAR; LANES]]; 3], children: self.children }
    }

    /// The box around all children.
    pub(super) fn around(&self) -> Aabb {
        self.children().fold(Aabb::EMPTY, |all, (_, bounds, _)| all.union(bounds))
    }

    /// The node on its way to be `end`, for a fraction of it from 0 to 1.
    #[inline(always)]
    pub(super) fn between<S: Simd>(&self, simd: S, end: &Self, fraction: f32) -> Self {
        let mut node = self.clone();
        for axis in 0..3 {
            for side in 0..2 {
                let begin = f32x8::load(simd, &self.planes[axis][side]) * (1.0 - fraction);
                let end = f32x8::load(simd, &end.planes[axis][side]) * fraction;
                (begin + end).store(&mut node.planes[axis][side]);
            }
        }
        node
    }
}

/// How much farther a box reaches in units of t, so that none is left out in which the watertight test
/// finds a hit.
///
/// Ize, "Robust BVH Ray Traversal" (2013). Let u = 2⁻²⁴, L and H be the planes of a box on one axis, o and d
/// the origin and direction of the ray. Hits are found in f64: the point of the triangle at the weights of a
/// hit is off the ray by less than u/1000 of its distance and of the triangle's extents. The extents' part is
/// in the box (`outward`), which leaves L - o <= t d (1 ± u) <= H - o. Each side of the test is rounded three
/// times, t once, so that it enters the box at no more than t (1 + 5u) and leaves it at no less than
/// t (1 - 5u).
const WIDEN: f32 = 1.0 + 16.0 * UNIT_ROUNDOFF;

/// What the test of boxes needs to know of a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slabs {
    origin: [f32; 3],
    inverse: [f32; 3],
    /// By axis, which plane the ray meets first: 0 the lower, 1 the upper.
    first: [usize; 3],
}

impl Slabs {
    #[inline(always)]
    pub(super) fn new(ray: &Ray) -> Self {
        // Infinite for an axis that the ray does not move along. The planes are then at ±∞, or, with the
        // origin in one of them, at 0 · ∞ = NaN, which `enter` ignores.
        let inverse = ray.direction.to_array().map(f32::recip);
        let first = inverse.map(|i| usize::from(i.is_sign_negative()));
        Self { origin: ray.origin.to_array(), inverse, first }
    }

    /// Whether the ray may hit something in each box within `[t_min, t_max]`; and where it enters the box, or
    /// `t_min`.
    #[inline(always)]
    pub(super) fn enter<S: Simd>(
        &self,
        node: &Node,
        t_min: f32x8<S>,
        t_max: f32x8<S>,
    ) -> (mask32x8<S>, f32x8<S>) {
        let near = |axis: usize| self.distance(t_min.token(), node, axis, self.first[axis]);
        let far = |axis: usize| self.distance(t_min.token(), node, axis, 1 - self.first[axis]);
        let near = [near(0), near(1), near(2)];
        let far = [far(0), far(1), far(2)];
        // A NaN must be the first operand, so that the other comes out of it; two of three axes may be
        // ignored with it, which makes the box larger.
        let near = near[0].max(near[1]).max(near[2].max(t_min));
        let far = far[0].min(far[1]).min(far[2].min(t_max));
        (near.le(far * WIDEN), near)
    }

    /// Where the ray meets the lower (0) or upper (1) planes of the boxes on an axis.
    #[inline(always)]
    fn distance<S: Simd>(&self, simd: S, node: &Node, axis: usize, side: usize) -> f32x8<S> {
        let plane = f32x8::load(simd, &node.planes[axis][side & 1]);
        (plane - self.origin[axis]) * self.inverse[axis]
    }

    /// The end of the segment as `enter` sees it.
    #[inline(always)]
    pub(super) fn reach(t_max: f32) -> f32 {
        t_max * WIDEN
    }
}

/// Up to eight triangles. Five cache lines.
#[derive(Clone, Debug, PartialEq)]
#[repr(C, align(64))]
pub(super) struct Pack {
    pub(super) corners: Corners8,
    /// Indices of the primitives in the scene, [`Self::FREE`] in lanes without one.
    ids: [u32; LANES],
}

impl Pack {
    const FREE: u32 = u32::MAX;

    /// Of the first eight triangles.
    pub(super) fn new(ids: &[u32], corners: impl Fn(u32) -> Corners) -> Self {
        let mut pack = Self { corners: [[[0.0; LANES]; 3]; 3], ids: [Self::FREE; LANES] };
        for (lane, &id) in ids.iter().enumerate().take(LANES) {
            pack.ids[lane] = id;
            for (i, corner) in corners(id).iter().enumerate() {
                for (axis, &coordinate) in corner.iter().enumerate() {
                    pack.corners[axis][i][lane] = coordinate;
                }
            }
        }
        pack
    }

    /// Whether each lane holds a triangle.
    #[inline(always)]
    pub(super) fn occupied<S: Simd>(&self, simd: S) -> mask32x8<S> {
        !u32x8::load(simd, &self.ids).eq(Self::FREE)
    }

    pub(super) fn is_occupied(&self, lane: usize) -> bool {
        self.ids[lane] != Self::FREE
    }

    /// Index in the scene.
    #[inline(always)]
    pub(super) fn id(&self, lane: usize) -> u32 {
        self.ids[lane]
    }

    #[inline(always)]
    pub(super) fn corners(&self, lane: usize) -> Corners {
        let corner = |i: usize| self.corners.each_ref().map(|axis| axis[i][lane]);
        [corner(0), corner(1), corner(2)]
    }
}
