//! The line of a ray in f64, and intervals of distances along it.

use glam::DVec3;

use crate::ray::Ray;

/// The line that a ray lies on, and the segment that counts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) ray: Ray,
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    pub(super) segment: Span,
}

impl Line {
    /// `None` for a ray that no engine may be asked about, or that has no direction: it hits nothing.
    pub(super) fn new(ray: &Ray) -> Option<Self> {
        let direction = ray.direction.as_dvec3();
        (ray.is_traceable() && direction != DVec3::ZERO).then(|| Self {
            ray: *ray,
            origin: ray.origin.as_dvec3(),
            direction,
            segment: Span { near: ray.t_min.into(), far: ray.t_max.into() },
        })
    }

    /// Distance of the line from the segment between `p` and `q`, which are relative to the origin.
    pub(super) fn distance_to_segment(&self, p: DVec3, q: DVec3) -> f64 {
        // Across the line, where it is a point.
        let dd = self.direction.length_squared();
        let [p, q] = [p, q].map(|v| v - self.direction * (v.dot(self.direction) / dd));
        distance_to_segment(DVec3::ZERO, p, q)
    }
}

/// Distance of a point from the segment between `a` and `b`.
fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let s = (p - a).dot(along) / along.length_squared();
    // NaN for a segment without length.
    let s = if s > 0.0 { s.min(1.0) } else { 0.0 };
    (a + along * s).distance(p)
}

/// The distances along a ray from `near` to `far`, in units of its direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// The smaller one.
    pub near: f64,
    /// The larger one.
    pub far: f64,
}

impl Span {
    /// Whether both have a point in common.
    #[must_use]
    pub fn meets(self, other: Self) -> bool {
        self.near <= other.far && other.near <= self.far
    }

    /// Whether all of this lies within `other`.
    pub(super) fn lies_in(self, other: Self) -> bool {
        self.near >= other.near && self.far <= other.far
    }

    pub(super) fn contains(self, t: f64) -> bool {
        t >= self.near && t <= self.far
    }

    pub(super) fn union(self, other: Self) -> Self {
        Self { near: self.near.min(other.near), far: self.far.max(other.far) }
    }
}
