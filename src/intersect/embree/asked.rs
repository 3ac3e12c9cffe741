//! What Embree's callbacks have to know of the query that they are called in.

use std::ffi::c_void;

use embree_sys::ShimQuery;

use super::Embree;
use crate::intersect::spurious::{Doubt, meets_triangle};
use crate::ray::{Ray, Rays};
use crate::shape::Geometry;

/// The rays of a query, by their `id`, and the engine that is asked.
pub(super) struct Asked<'a> {
    pub(super) engine: &'a Embree,
    pub(super) rays: AskedRays<'a>,
}

/// Rays by their `id`.
pub(super) enum AskedRays<'a> {
    /// One alone.
    One(&'a Ray),
    /// Those from `first` on.
    Packet { rays: &'a Rays, first: usize },
}

impl Asked<'_> {
    /// For the time that `self` is borrowed.
    pub(super) fn query(&self) -> ShimQuery {
        ShimQuery { user: (&raw const *self).cast(), accept: Some(accept) }
    }

    /// The query behind a callback's user pointer.
    ///
    /// # Safety
    /// `user` is that of an [`Asked::query`], and the query has not ended.
    pub(super) unsafe fn from_user<'a>(user: *const c_void) -> &'a Self {
        // SAFETY: the caller's promise.
        unsafe { &*user.cast::<Self>() }
    }

    /// One of them.
    #[inline(always)]
    pub(super) fn ray(&self, id: usize) -> Ray {
        match self.rays {
            AskedRays::One(ray) => *ray,
            AskedRays::Packet { rays, first } => rays.get(first + id),
        }
    }

    /// Where a ray's hits may be made up.
    #[inline(always)]
    pub(super) fn doubt(&self, id: usize) -> Doubt {
        let between = match self.rays {
            AskedRays::One(ray) => ray.into(),
            AskedRays::Packet { rays, first } => rays.between(first + id),
        };
        Doubt::new(between, self.engine.reach)
    }

    /// Whether a ray truly has a hit. Shapes with a test of their own have decided that before.
    #[inline(always)]
    pub(super) fn counts(&self, ray: usize, t: f32, shape: u32, primitive: u32) -> bool {
        !self.doubt(ray).covers(t) || self.is_met(&self.ray(ray), t, shape, primitive)
    }

    #[cold]
    fn is_met(&self, ray: &Ray, t: f32, shape: u32, primitive: u32) -> bool {
        match self.engine.shapes[shape as usize].geometry() {
            Geometry::Triangles { positions, triangles } => {
                let corners = triangles[primitive as usize].map(|i| positions[i as usize]);
                meets_triangle(ray, t, corners.map(|corner| corner.as_dvec3()))
            }
            Geometry::Deforming(_) | Geometry::Analytic(_) | Geometry::Instance(_) => true,
        }
    }
}

/// Asked by the shim of each triangle that an occlusion query finds.
unsafe extern "C" fn accept(
    user: *const c_void,
    ray: u32,
    shape: u32,
    primitive: u32,
    t: f32,
) -> bool {
    // SAFETY: the shim passes what the query came with, which lives until it ends.
    unsafe { Asked::from_user(user) }.counts(ray as usize, t, shape, primitive)
}
