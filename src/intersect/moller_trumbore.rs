//! The ray–triangle test of the Rust engine.

use glam::Vec3;

use crate::ray::Ray;

/// A triangle as the test wants it: a vertex and the edges that leave it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    vertex: Vec3,
    edge_1: Vec3,
    edge_2: Vec3,
}

impl Triangle {
    pub(super) fn new([a, b, c]: [Vec3; 3]) -> Self {
        Self { vertex: a, edge_1: b - a, edge_2: c - a }
    }

    /// Distance and the barycentric weights of the second and third vertex, `(t, u, v)`, of a hit on
    /// either side within the ray's segment.
    ///
    /// Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997). The determinant
    /// is compared with 0 and nothing else: any other bound would be a length, and lose small triangles.
    /// The comparisons are written so that NaN fails them.
    pub(super) fn intersect(&self, ray: &Ray) -> Option<(f32, f32, f32)> {
        let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
        let p = direction.cross(self.edge_2);
        let determinant = self.edge_1.dot(p);
        if determinant == 0.0 {
            return None;
        }
        let inverse = 1.0 / determinant;
        let to_origin = origin - self.vertex;
        let u = to_origin.dot(p) * inverse;
        let q = to_origin.cross(self.edge_1);
        let v = direction.dot(q) * inverse;
        let t = self.edge_2.dot(q) * inverse;
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
        (inside && t >= ray.t_min && t <= ray.t_max && t.is_finite()).then_some((t, u, v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

    #[test]
    fn weights_name_the_second_and_third_vertex() {
        let ray = Ray::new(Vec3::new(0.5, 0.25, -1.0), Vec3::Z);
        assert_eq!(Triangle::new(UNIT).intersect(&ray), Some((1.0, 0.5, 0.25)));
    }

    #[test]
    fn a_ray_in_the_plane_misses() {
        let ray = Ray::new(Vec3::new(-1.0, 0.5, 0.0), Vec3::X);
        assert_eq!(Triangle::new(UNIT).intersect(&ray), None);
    }

    /// Legs and height s: t = s up to three roundings of the test, at every scale whose products of
    /// two lengths stay in range.
    #[test]
    fn size_does_not_matter() {
        for exponent in -12..=12 {
            let s = 10f32.powi(exponent);
            let triangle = Triangle::new(UNIT.map(|p| p * s));
            let ray = Ray::new(Vec3::new(0.25, 0.25, -1.0) * s, Vec3::Z);
            let (t, ..) = triangle.intersect(&ray).unwrap_or_else(|| panic!("missed at {s}"));
            assert!((t / s - 1.0).abs() < 2e-7, "{s}: {t}");
        }
    }

    #[test]
    fn the_segment_bounds_the_hit() {
        let ray = Ray::new(Vec3::new(0.25, 0.25, -1.0), Vec3::Z);
        let triangle = Triangle::new(UNIT);
        assert!(triangle.intersect(&ray.until(0.999)).is_none());
        assert!(triangle.intersect(&Ray { t_min: 1.001, ..ray }).is_none());
        assert!(triangle.intersect(&ray.until(1.001)).is_some());
    }
}
