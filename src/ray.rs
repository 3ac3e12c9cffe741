//! Rays and the hits that an engine reports for them.

use glam::{DAffine3, Vec3A};

/// A segment of a half-line: the points `origin + t * direction` with `t` in `[t_min, t_max]`.
///
/// World frame, lengths in scene units. `direction` has unit length, so `t` is a distance.
/// `time` is the moment within the shutter, in `[0, 1]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where the ray starts.
    pub origin: Vec3A,
    /// Unit vector.
    pub direction: Vec3A,
    /// Hits nearer than this are ignored; at least 0.
    pub t_min: f32,
    /// Hits farther than this are ignored; may be infinite.
    pub t_max: f32,
    /// Moment within the shutter, in `[0, 1]`.
    pub time: f32,
}

impl Ray {
    /// Components at or above this magnitude overflow in Embree's own tests of a box
    /// (its `FLT_LARGE`, the square root of the largest f32 over 100).
    pub const LARGEST_COORDINATE: f32 = 1.844e18;

    /// The whole half-line from `origin`, at time 0.
    ///
    /// `t_min` is the smallest positive normal number and not 0, because a watertight test accepts
    /// `t == t_min`, and a surface through the origin is at exactly 0.
    #[must_use]
    pub fn new(origin: impl Into<Vec3A>, direction: impl Into<Vec3A>) -> Self {
        let (origin, direction) = (origin.into(), direction.into());
        Self { origin, direction, t_min: f32::MIN_POSITIVE, t_max: f32::INFINITY, time: 0.0 }
    }

    /// The same ray, ending at `t_max`.
    #[must_use]
    pub fn until(self, t_max: f32) -> Self {
        Self { t_max, ..self }
    }

    /// The ray in the space that `map` leads to, formed in f64 and rounded once, and lengths along it over
    /// lengths along this one. The map must not flatten its direction.
    #[must_use]
    pub fn mapped(&self, map: &DAffine3) -> (Self, f64) {
        let origin = map.transform_point3(self.origin.as_dvec3());
        let direction = map.transform_vector3(self.direction.as_dvec3());
        let stretch = direction.length();
        let along = |t: f32| (f64::from(t) * stretch) as f32;
        let ray = Self {
            origin: origin.as_vec3a(),
            direction: (direction / stretch).as_vec3a(),
            // 0 stands for the surface that the ray leaves, as in `Ray::new`.
            t_min: along(self.t_min).max(f32::MIN_POSITIVE),
            t_max: along(self.t_max),
            time: self.time,
        };
        (ray, stretch)
    }

    /// Whether an engine may be asked about this ray. Engines report no hit for any other:
    /// Debian 12's Embree is compiled with assertions and would end the process, Debian 13's
    /// would answer with an arbitrary hit.
    ///
    /// Every comparison is written so that NaN fails it.
    #[must_use]
    pub fn is_traceable(&self) -> bool {
        let limit = Vec3A::splat(Self::LARGEST_COORDINATE);
        let small = |v: Vec3A| v.abs().cmplt(limit);
        (small(self.origin) & small(self.direction)).all()
            && self.t_min >= 0.0
            && !self.t_max.is_nan()
            && (0.0..=1.0).contains(&self.time)
    }
}

/// Where a ray meets a shape. Position and normals are rebuilt from these numbers and the shape's
/// own data (`Shape::surface`), never from `origin + t * direction`, whose error grows with `t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, in scene units.
    pub t: f32,
    /// First surface parameter: for a triangle the barycentric weight of its second vertex.
    pub u: f32,
    /// Second surface parameter: for a triangle the barycentric weight of its third vertex.
    pub v: f32,
    /// Index of the shape in the scene.
    pub shape: u32,
    /// Index of the primitive in the shape: the triangle of a mesh, 0 for the others.
    pub primitive: u32,
    /// Of an instance, index of the shape in its group, whose primitive is meant; else 0.
    pub member: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_that_no_engine_may_see_are_recognised() {
        let good = Ray::new(Vec3A::ZERO, Vec3A::Z);
        assert!(good.is_traceable());
        assert!(Ray { t_min: 0.0, time: 1.0, ..good }.is_traceable());
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e20, -1e20] {
            for axis in 0..3 {
                let mut v = Vec3A::splat(0.5);
                v[axis] = bad;
                assert!(!Ray { origin: v, ..good }.is_traceable(), "origin {v}");
                assert!(!Ray { direction: v, ..good }.is_traceable(), "direction {v}");
            }
        }
        for t_min in [-1.0, f32::NAN] {
            assert!(!Ray { t_min, ..good }.is_traceable(), "t_min {t_min}");
        }
        assert!(!Ray { t_max: f32::NAN, ..good }.is_traceable());
        for time in [-1e-7, 1.000_000_1, f32::NAN] {
            assert!(!Ray { time, ..good }.is_traceable(), "time {time}");
        }
    }
}
