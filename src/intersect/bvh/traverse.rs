//! The walk of a ray through the tree.

use std::cmp::Ordering;
use std::marker::PhantomData;

use arrayvec::ArrayVec;
use glam::Vec3A;

use super::node::{Child, ChildKind, Slabs};
use super::{Bvh, LANES};
use crate::intersect::spurious::{Doubt, meets_triangle};
use crate::intersect::triangle::{Corners, RayTriangle, TriangleHit, in_f64, nearer};
use crate::math::real::{Lanes, Mask, Simd, Task, f32x8};
use crate::ray::Ray;

/// Nodes on the way from the root to a leaf, at most.
pub(super) const MAX_DEPTH: usize = 48;

/// On each level all children but one may wait.
pub(super) const STACK: usize = MAX_DEPTH * (LANES - 1) + 1;

/// A hit, with the index of the primitive in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    pub(super) t: f32,
    pub(super) u: f32,
    pub(super) v: f32,
    pub(super) id: u32,
    pub(super) inner: Inner,
}

/// What was hit of an instance: a shape of its group, and a primitive of that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Inner {
    pub(super) member: u32,
    pub(super) primitive: u32,
}

impl Inner {
    pub(super) const NONE: Self = Self { member: 0, primitive: 0 };
}

/// The nearest hit of a ray or, if `ANY`, just some hit. Of hits at the same f32 that is the nearest in f64, and of those in
/// one plane the one with the smallest index, so the answer does not depend on the shape of the tree.
pub(super) struct Walk<'a, T, const ANY: bool> {
    bvh: &'a Bvh,
    ray: Ray,
    test: PhantomData<T>,
}

impl<'a, T, const ANY: bool> Walk<'a, T, ANY> {
    /// `ray` must be traceable.
    #[inline(always)]
    pub(super) fn new(bvh: &'a Bvh, mut ray: Ray) -> Self {
        ray.direction = without_denormals(ray.direction);
        Self { bvh, ray, test: PhantomData }
    }
}

/// The direction with 0 in the place of components that are smaller than the largest by more than 2¹⁰⁰:
/// their products with coordinates are no longer right to a few roundings, which the test of boxes counts
/// on. Over a distance of 1e18, about the largest that there is, it turns the ray aside by 1e-12.
#[inline(always)]
pub(super) fn without_denormals(direction: Vec3A) -> Vec3A {
    const LEAST: f32 = 7.888_609e-31;
    let least = Vec3A::splat(LEAST * direction.abs().max_element());
    let zero = Vec3A::ZERO.copysign(direction);
    Vec3A::select(direction.abs().cmplt(least), zero, direction)
}

/// A child that waits: the bits of the distance of its box, then those of its index. Distances are
/// not negative, so they are ordered as their bits are.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Entry(u64);

impl Entry {
    #[inline(always)]
    pub(super) fn new(distance: f32, child: Child) -> Self {
        Self(u64::from(distance.to_bits()) << 32 | u64::from(child.bits()))
    }

    #[inline(always)]
    pub(super) fn distance(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    #[inline(always)]
    pub(super) fn child(self) -> Child {
        Child::from_bits(self.0 as u32)
    }
}

impl<T: RayTriangle, const ANY: bool> Task for Walk<'_, T, ANY> {
    type Output = Option<Found>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<Found> {
        let Self { bvh, mut ray, .. } = self;
        let test = T::new(&ray);
        let slabs = Slabs::new(&ray);
        let doubt = Doubt::new((&ray).into(), bvh.reach);
        let t_min = f32x8::splat(simd, ray.t_min);
        let mut t_max = f32x8::splat(simd, ray.t_max);
        let mut found: Option<Found> = None;
        // Of the triangle that was found, if it is one.
        let mut found_corners: Option<Corners> = None;
        let mut stack = ArrayVec::<Entry, STACK>::new();
        let mut child = Child::new(ChildKind::Node(0));
        loop {
            match child.kind() {
                ChildKind::Node(index) => {
                    let node = &bvh.nodes[index];
                    let (entered, distance) = slabs.enter(node, t_min, t_max);
                    let mut mask = entered.bits();
                    if mask != 0 {
                        let mut near = [0.0; LANES];
                        distance.store(&mut near);
                        let first = mask.trailing_zeros() as usize % LANES;
                        mask &= mask - 1;
                        if mask == 0 {
                            child = node.child(first);
                            continue;
                        }
                        let entry = |i: usize| Entry::new(near[i], node.child(i));
                        let second = mask.trailing_zeros() as usize % LANES;
                        mask &= mask - 1;
                        let (a, b) = (entry(first), entry(second));
                        if mask == 0 {
                            stack.push(a.max(b));
                            child = a.min(b).child();
                            continue;
                        }
                        let waiting = stack.len();
                        stack.push(a);
                        stack.push(b);
                        while mask != 0 {
                            stack.push(entry(mask.trailing_zeros() as usize % LANES));
                            mask &= mask - 1;
                        }
                        if !ANY {
                            sort_descending(&mut stack[waiting..]);
                        }
                    }
                }
                ChildKind::Triangles(index) => {
                    let pack = &bvh.packs[index];
                    let candidates = test.candidates(simd, &pack.corners) & pack.occupied(simd);
                    let mut mask = candidates.bits();
                    while mask != 0 {
                        let lane = mask.trailing_zeros() as usize % LANES;
                        mask &= mask - 1;
                        let corners = pack.corners(lane);
                        let Some(hit) = test.hit(&ray, &corners) else { continue };
                        if doubt.covers(hit.t) && !meets_triangle(&ray, hit.t, in_f64(&corners)) {
                            continue;
                        }
                        let id = pack.id(lane);
                        let is_behind = |best: Found| {
                            let nearer = |best| nearer(&ray, best, &corners);
                            let order = found_corners.as_ref().map_or(Ordering::Equal, nearer);
                            order.then(best.id.cmp(&id)).is_le()
                        };
                        if !found.is_some_and(|best| hit.t == best.t && is_behind(best)) {
                            let TriangleHit { t, u, v } = hit;
                            found = Some(Found { t, u, v, id, inner: Inner::NONE });
                            found_corners = Some(corners);
                            if ANY {
                                return found;
                            }
                            ray.t_max = hit.t;
                            t_max = f32x8::splat(simd, hit.t);
                        }
                    }
                }
                ChildKind::Shape(shape) => {
                    if let Some(hit) = bvh.intersect_shape::<ANY>(shape, &ray, doubt)
                        && !found.is_some_and(|best| hit.t == best.t && hit.id >= best.id)
                    {
                        found = Some(hit);
                        found_corners = None;
                        if ANY {
                            return found;
                        }
                        ray.t_max = hit.t;
                        t_max = f32x8::splat(simd, hit.t);
                    }
                }
            }
            // The nearest that waits and is still nearer than what was found meanwhile.
            let reach = Slabs::reach(ray.t_max);
            child = loop {
                let Some(entry) = stack.pop() else { return found };
                if ANY || entry.distance() <= reach {
                    break entry.child();
                }
            };
        }
    }
}

/// By insertion: there are few.
#[inline(always)]
pub(super) fn sort_descending(entries: &mut [Entry]) {
    for i in 1..entries.len() {
        let entry = entries[i];
        let mut hole = i;
        while hole > 0 && entries[hole - 1] < entry {
            entries[hole] = entries[hole - 1];
            hole -= 1;
        }
        entries[hole] = entry;
    }
}
