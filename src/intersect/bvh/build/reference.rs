//! Primitives during construction, and boxes around many.

use std::sync::Arc;

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::super::locate;
use crate::math::{Aabb, UNIT_ROUNDOFF as U};
use crate::shape::{Geometry, Shape};

/// A box. The fourth coordinates mean nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub(super) lower: Vec4,
    pub(super) upper: Vec4,
}

impl Bounds {
    pub(super) const EMPTY: Self = Self { lower: Vec4::INFINITY, upper: Vec4::NEG_INFINITY };

    #[inline(always)]
    pub(super) fn extend(&mut self, lower: Vec4, upper: Vec4) {
        self.lower = self.lower.min(lower);
        self.upper = self.upper.max(upper);
    }

    #[inline(always)]
    pub(super) fn union(mut self, other: &Self) -> Self {
        self.extend(other.lower, other.upper);
        self
    }

    pub(super) fn extent(&self) -> Vec3 {
        self.upper.truncate() - self.lower.truncate()
    }

    pub(super) fn aabb(&self) -> Aabb {
        Aabb { min: self.lower.truncate(), max: self.upper.truncate() }
    }
}

/// A primitive: 32 bytes, since construction is bound by memory.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Reference {
    /// The lower corner of its box; then the bits of its index in the scene.
    lower: Vec4,
    /// The upper corner; then, for a shape with a test of its own, the bits of its index plus 1, and
    /// else 0.
    upper: Vec4,
}

impl Reference {
    pub(in super::super) fn new(bounds: &Aabb, id: u32, shape: Option<usize>) -> Self {
        let shape = shape.map_or(0, |shape| shape as u32 + 1);
        Self {
            lower: bounds.min.extend(f32::from_bits(id)),
            upper: bounds.max.extend(f32::from_bits(shape)),
        }
    }

    pub(super) fn id(&self) -> u32 {
        self.lower.w.to_bits()
    }

    /// The index of a shape with a test of its own.
    pub(super) fn shape(&self) -> Option<usize> {
        (self.upper.w.to_bits() as usize).checked_sub(1)
    }

    #[inline(always)]
    pub(super) fn lower(&self) -> Vec4 {
        self.lower
    }

    #[inline(always)]
    pub(super) fn upper(&self) -> Vec4 {
        self.upper
    }

    /// Twice the centre: the factor does not matter to any comparison.
    #[inline(always)]
    pub(super) fn center(&self) -> Vec4 {
        self.lower + self.upper
    }
}

/// What construction starts from: every primitive with its box.
pub(in super::super) fn references(shapes: &[Arc<dyn Shape>], offsets: &[u32]) -> Vec<Reference> {
    let total = offsets[offsets.len() - 1];
    let reference = |id| {
        let (shape, primitive) = locate(offsets, id);
        match shapes[shape].geometry() {
            Geometry::Triangles { positions, triangles } => {
                let corners =
                    triangles[primitive as usize].map(|i| Vec3::from(positions[i as usize]));
                Reference::new(&outward(&Aabb::around(corners)), id, None)
            }
            Geometry::Deforming(_) | Geometry::Analytic(_) | Geometry::Instance(_) => {
                Reference::new(&finite(&shapes[shape].bounds()), id, Some(shape))
            }
        }
    };
    (0..total).into_par_iter().with_min_len(1 << 12).map(reference).collect()
}

/// The box of a triangle with the margin that `node::WIDEN` counts on: u times its largest extent, and
/// what rounding may take from that again.
pub(in super::super) fn outward(bounds: &Aabb) -> Aabb {
    let extent = U * (bounds.max - bounds.min).max_element();
    // The least is for corners that are 0 or denormal.
    let margin = |side: Vec3| extent + 2.0 * U * side.abs() + f32::from_bits(4);
    Aabb { min: bounds.min - margin(bounds.min), max: bounds.max + margin(bounds.max) }
}

/// The same box, within what can be added and subtracted.
pub(in super::super) fn finite(bounds: &Aabb) -> Aabb {
    let limit = Vec3::splat(f32::MAX / 4.0);
    Aabb { min: bounds.min.max(-limit), max: bounds.max.min(limit) }
}
