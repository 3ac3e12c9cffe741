//! A ray against one shape, by brute force and, for triangles, in f64.

use glam::{DVec3, Vec3A};
use telamon::ray::{Hit, Ray};
use telamon::shape::{Geometry, Shape};

/// The nearest hit of `ray` with `shape`.
pub(crate) fn trace(shape: &dyn Shape, ray: &Ray) -> Option<Hit> {
    match shape.geometry() {
        Geometry::Analytic(analytic) => {
            let hit = |(t, u, v)| Hit { t, u, v, shape: 0, primitive: 0, member: 0 };
            analytic.intersect(ray).map(hit)
        }
        Geometry::Instance(instance) => instance.nearest(ray, |local| {
            let shapes = instance.group().shapes().iter().zip(0..);
            let hits = shapes.filter_map(|(member, shape)| {
                Some(Hit { shape, ..trace(member.as_ref(), local)? })
            });
            hits.min_by(|a, b| a.t.total_cmp(&b.t))
        }),
        Geometry::Triangles { positions, triangles } => {
            nearest(triangles.iter().map(|indices| indices.map(|i| positions[i as usize])), ray)
        }
        Geometry::Deforming(mesh) => {
            nearest((0..mesh.triangles().len()).map(|i| mesh.corners(i, ray.time)), ray)
        }
    }
}

/// The nearest hit with triangles, given by their corners.
fn nearest(triangles: impl Iterator<Item = [Vec3A; 3]>, ray: &Ray) -> Option<Hit> {
    let hit = |(corners, primitive): ([Vec3A; 3], u32)| {
        let (t, u, v) = triangle(corners.map(|p| p.as_dvec3()), ray)?;
        Some(Hit { t, u, v, shape: 0, primitive, member: 0 })
    };
    triangles.zip(0..).filter_map(hit).min_by(|a, b| a.t.total_cmp(&b.t))
}

/// Möller and Trumbore (1997), without a tolerance.
fn triangle([a, b, c]: [DVec3; 3], ray: &Ray) -> Option<(f32, f32, f32)> {
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let (e1, e2) = (b - a, c - a);
    let p = direction.cross(e2);
    let determinant = e1.dot(p);
    let s = origin - a;
    let q = s.cross(e1);
    let [t, u, v] = [e2.dot(q), s.dot(p), direction.dot(q)].map(|x| x / determinant);
    let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
    let within = t >= f64::from(ray.t_min) && t <= f64::from(ray.t_max);
    (inside && within).then_some((t as f32, u as f32, v as f32))
}
