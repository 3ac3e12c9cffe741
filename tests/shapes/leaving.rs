//! Exact positions and normals, and rays that leave them.

use std::sync::Arc;

use crate::support::meshes::engines;
use crate::support::points;
use crate::support::rays::trace;
use crate::{cylinder, scaled};
use glam::{DAffine3, DMat3, DVec3, Vec3A};
use telamon::math::{Frame, warp};
use telamon::ray::Ray;
use telamon::shape::{Disk, Shape, Sphere, SurfacePoint, TriangleMesh, primitives};

/// The normal of a distant sphere, for a ray taken as exact: the rounding of t moves the point by
/// 6e-8 of the distance along the ray, which is much against the radius.
#[test]
fn distant_spheres_have_exact_normals() {
    for (radius, distance) in [(1.0f32, 1e3f32), (1.0, 1e6), (1e-3, 1e3), (1e-6, 1.0)] {
        let axis = Vec3A::new(1.0, 2.0, 3.0).normalize();
        let sphere =
            Sphere::new(axis * distance, radius, Frame::from_normal(Vec3A::Z.into()), false);
        let center = (axis * distance).as_dvec3();
        let mut hits = 0;
        for u in points(1, 10_000) {
            let across = Vec3A::from(
                Frame::from_normal(axis.into()).to_world((u * 1.8 - 0.9).extend(0.0).into()),
            );
            // Parallel to the line to the centre, so that most rays hit.
            let ray = Ray::new(across * radius, axis);
            let Some(hit) = trace(&sphere, &ray) else {
                continue;
            };
            hits += 1;
            let (o, d) = (ray.origin.as_dvec3() - center, ray.direction.as_dvec3());
            let (a, b) = (d.length_squared(), o.dot(d));
            let closest = o - d * (b / a);
            let half = ((f64::from(radius).powi(2) - closest.length_squared()) / a).sqrt();
            let exact = (closest - d * half) / f64::from(radius);
            let normal = sphere.surface(&ray, &hit).geometric_normal.as_dvec3();
            // One rounding for each coordinate.
            assert!((normal - exact).length() < 2e-7, "{radius} at {distance}: {normal}, {exact}");
        }
        assert!(hits > 1_000, "{radius} at {distance}: only {hits} hits");
    }
}

const CENTERS: [f32; 4] = [0.0, 1.0, -100.0, 1e5];

/// Rays that leave a sphere to either side, in each engine: outwards none comes back, inwards each meets the far side.
#[test]
fn rays_leave_spheres() {
    for (size, center) in [1e-3f32, 1.0, 1e3].into_iter().flat_map(|s| CENTERS.map(|c| (s, c))) {
        let center = Vec3A::new(center, -0.7 * center, 0.3 * center);
        let sphere = Sphere::new(center, size, Frame::from_normal(Vec3A::Z.into()), false);
        for engine in engines(&[Arc::new(sphere)]) {
            for (a, b) in points(11, 2_000).zip(points(12, 2_000)) {
                let side = Vec3A::from(warp::square_to_uniform_sphere(a.into()));
                let ray = Ray::new(center + side * (3.0 * size), -side);
                let Some(hit) = trace(&sphere, &ray) else {
                    continue;
                };
                let point = sphere.surface(&ray, &hit);
                let direction = Vec3A::from(warp::square_to_uniform_sphere(b.into()));
                let cosine = direction.dot(point.geometric_normal);
                let again = engine.closest_hit(&point.spawn(direction)).map(|h| h.t);
                if cosine >= 0.0 {
                    assert_eq!(again, None, "{size} at {center}: {direction} from {point:?}");
                    continue;
                }
                // The far end of the chord, from a start that is off by the lift; shorter ones are shorter than that.
                let (chord, lift) = (-2.0 * size * cosine, point.end_towards(direction).lift());
                if chord > 100.0 * lift {
                    let t = again.unwrap_or_else(|| panic!("{size} at {center}: no far side"));
                    let slack = 4.0 * lift / -cosine + 1e-5 * size;
                    assert!((t - chord).abs() < slack, "{size} at {center}: {t}, chord {chord}");
                }
            }
        }
    }
}

/// Rays that leave a cylinder to either side: outwards none comes back; inwards each meets the far side or leaves
/// through an end.
#[test]
fn rays_leave_cylinders() {
    for (size, center) in [1e-3f64, 1.0, 1e3].into_iter().flat_map(|s| CENTERS.map(|c| (s, c))) {
        let base = f64::from(center) * DVec3::new(1.0, -0.7, 0.3);
        let top = base + DVec3::new(1.0, 2.0, -2.0) * size;
        let cylinder = cylinder(base.into(), top.into(), size, false);
        for engine in engines(&[Arc::new(cylinder)]) {
            for (a, b) in points(41, 2_000).zip(points(42, 2_000)) {
                let s = cylinder.sample_primitive(0, DVec3::splat(3e5), a).expect("seen");
                let direction = Vec3A::from(warp::square_to_uniform_sphere(b.into()));
                let cosine = direction.dot(s.point.geometric_normal);
                let again = engine.closest_hit(&s.point.spawn(direction)).map(|hit| hit.t);
                if cosine >= 0.0 {
                    assert_eq!(again, None, "{size} at {center}: {direction} from {:?}", s.point);
                    continue;
                }
                // The far end of the chord, by the angle to the axis.
                let axis = DVec3::new(1.0, 2.0, -2.0) / 3.0;
                let sine = direction.as_dvec3().cross(axis).length() as f32;
                let chord = -2.0 * size as f32 * cosine / (sine * sine);
                let lift = s.point.end_towards(direction).lift();
                let slack = 8.0 * lift / -cosine / sine + 1e-5 * size as f32 / sine;
                if let Some(t) = again.filter(|_| chord > 100.0 * lift) {
                    assert!((t - chord).abs() < slack, "{size} at {center}: {t}, chord {chord}");
                }
            }
        }
    }
}

/// Rays that leave a disk never meet it again.
#[test]
fn rays_leave_disks() {
    for (size, center) in [1e-6f64, 1.0, 1e3].into_iter().flat_map(|s| CENTERS.map(|c| (s, c))) {
        let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0);
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.5, 2.0, 0.0), DVec3::Z);
        let offset = f64::from(center) * DVec3::new(1.0, -0.7, 0.3);
        let to_world = DAffine3::from_mat3_translation(turn * shear * size, offset);
        let disk = Disk::new(to_world, false).expect("not singular");
        for engine in engines(&[Arc::new(disk)]) {
            for (a, b) in points(21, 2_000).zip(points(22, 2_000)) {
                let s = disk.sample_primitive(0, DVec3::splat(3e5), a).expect("seen");
                let direction = Vec3A::from(warp::square_to_uniform_sphere(b.into()));
                let again = engine.closest_hit(&s.point.spawn(direction));
                assert_eq!(again, None, "{size} at {center}: {direction}");
            }
        }
    }
}

/// pbrt's recipe: triangles whose coordinates range over 16 decades. A ray starts on the side that it
/// goes to, clear of the exact plane by a good part of the lift, and no farther than the lift and two roundings.
#[test]
fn rays_leave_triangles_on_their_own_side() {
    let coordinates = |seed| {
        points(seed, 9_000)
            .map(|u| 10f64.powf(16.0 * f64::from(u.x) - 8.0).copysign(f64::from(u.y) - 0.5))
    };
    let all: Vec<f32> = coordinates(31).map(|x| x as f32).collect();
    let mut tested = 0;
    for corners in all.chunks(9) {
        let corners = [0, 3, 6].map(|i| Vec3A::new(corners[i], corners[i + 1], corners[i + 2]));
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        let across = (b - a).cross(c - a);
        if across.length_squared() < 1e-20 {
            continue;
        }
        let exact_normal = across.normalize();
        let positions = corners.map(Into::into).into();
        let (mesh, _) =
            TriangleMesh::new(positions, vec![[0, 1, 2]], Vec::new(), Vec::new()).expect("valid");
        for (u, w) in points(32, 100).zip(points(33, 100)) {
            let Some(s) = mesh.sample_primitive(0, DVec3::splat(1e9), u) else {
                continue;
            };
            assert_leaves(
                &s.point,
                [a, b, c],
                exact_normal,
                Vec3A::from(warp::square_to_uniform_sphere(w.into())),
            );
            tested += 1;
        }
    }
    assert!(tested > 80_000, "only {tested} rays");
}

fn assert_leaves(point: &SurfacePoint, corners: [DVec3; 3], exact_normal: DVec3, direction: Vec3A) {
    let error = (point.geometric_normal.as_dvec3() - exact_normal).length();
    // Rounded to f32 three times: the product of the edges, its length, and their quotient.
    assert!(error < 1.8e-7, "normal {} is off by {error}", point.geometric_normal);
    let height = (point.position - corners[0]).dot(exact_normal).abs();
    let size = corners.iter().fold(0.0, |most: f64, p| most.max(p.abs().max_element()));
    // Two products and three sums in f64; and the roundings of this test, whose normal cancels for slivers.
    let [to_b, to_c] = [corners[1] - corners[0], corners[2] - corners[0]];
    let sharpness = to_b.length() * to_c.length() / to_b.cross(to_c).length();
    let rounding = 16.0 * f64::EPSILON * size * (1.0 + sharpness);
    assert!(height <= rounding, "{height} above the plane, whose corners reach to {size}");
    let cosine = f64::from(direction.dot(point.geometric_normal));
    if cosine.abs() < 1e-6 {
        return;
    }
    let start = (point.leave_towards(direction).0.as_dvec3() - corners[0]).dot(exact_normal);
    let (start, lift) = (start * cosine.signum(), f64::from(point.end_towards(direction).lift()));
    // The point and the start are rounded, each by a quarter of the lift at most.
    let range = 0.499 * lift - rounding..1.501 * lift + rounding;
    assert!(range.contains(&start), "starts at {start}, lift {lift}");
}

/// Two squares 1e-6 apart at coordinates near 1 do not hide each other, however large they are.
#[test]
fn lifts_are_small() {
    for half in [1.0, 1e6] {
        let to_world = DAffine3::from_translation(DVec3::ONE) * scaled(half, half, 1.0);
        let square = primitives::rectangle(to_world, false).0;
        let ray = Ray::new(Vec3A::new(1.2, 1.1, 5.0), Vec3A::NEG_Z);
        let hit = trace(&square, &ray).expect("in front");
        let lift = square.surface(&ray, &hit).end_towards(Vec3A::Z).lift();
        // 4 · 2⁻²⁴ · |z| with z = 1, and 2⁻⁴⁰ of the coordinates.
        assert!((4.0 / 16_777_216.0..4.001 / 16_777_216.0).contains(&lift), "{lift}");
    }
}
