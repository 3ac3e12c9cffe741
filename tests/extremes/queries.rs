//! Single rays: what is hit, at what distance and where on it.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec2, Vec3A};
use telamon::bsdf::{Bsdf, Diffuse};
use telamon::integrator::Tracer;
use telamon::math::{Frame, Rgb, warp};
use telamon::ray::{Hit, Ray, Rays};
use telamon::scene::{Object, Scene};
use telamon::shape::mesh::Dropped;
use telamon::shape::{Shape, TriangleMesh, primitives};

use crate::ULP;
use crate::support::lights::triangle;
use crate::support::meshes::{corners_of, engines, mesh, sphere_mesh};
use crate::support::rays::trace;
use crate::support::{points, points_3d};

/// Legs of length `leg` along x and y from the origin.
fn right_triangle(leg: f32) -> [Arc<dyn Shape>; 1] {
    [triangle([Vec3A::ZERO, Vec3A::X * leg, Vec3A::Y * leg])]
}

/// Upwards through the point (1/4, 1/4) of [`right_triangle`], whose plane is at distance `height`.
fn upwards(leg: f32, height: f32) -> Ray {
    Ray::new(Vec3A::new(0.25 * leg, 0.25 * leg, -height), Vec3A::Z)
}

/// Embree's own tolerance for weights is 16 ulp; its distance is 1 ulp off.
#[test]
fn a_plain_hit_is_right_to_a_few_ulp() {
    for engine in engines(&right_triangle(1.0)) {
        let hit = engine.closest_hit(&upwards(1.0, 1.0)).expect("in the middle");
        assert!((hit.t - 1.0).abs() <= 2.0 * ULP, "{}: {hit:?}", engine.name());
        let off = (hit.u - 0.25).abs().max((hit.v - 0.25).abs());
        assert!(off <= 16.0 * ULP, "{}: {hit:?}", engine.name());
    }
}

/// A ray in the plane of a triangle meets it nowhere: the convention of all engines.
#[test]
fn a_ray_in_the_plane_misses() {
    for engine in engines(&right_triangle(1.0)) {
        for (origin, direction) in
            [(Vec3A::new(-1.0, 0.5, 0.0), Vec3A::X), (Vec3A::new(0.2, 0.2, 0.0), Vec3A::NEG_Y)]
        {
            let ray = Ray::new(origin, direction);
            assert_eq!(engine.closest_hit(&ray), None, "{}", engine.name());
            assert!(!engine.occluded(&ray), "{}", engine.name());
        }
    }
}

/// Rays that no engine may see: each misses and is counted, whichever question is asked.
#[test]
fn untraceable_rays_are_counted() {
    let good = upwards(1.0, 1.0);
    let mut bad = Vec::new();
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e20] {
        for axis in [Vec3A::X, Vec3A::Y, Vec3A::Z] {
            bad.push(Ray { origin: good.origin + axis * value, ..good });
            bad.push(Ray { direction: good.direction + axis * value, ..good });
        }
    }
    bad.extend([-1.0, f32::NAN].map(|t_min| Ray { t_min, ..good }));
    bad.push(Ray { t_max: f32::NAN, ..good });
    bad.extend([-1e-7, 1.000_000_1, f32::NAN].map(|time| Ray { time, ..good }));
    let [shape] = right_triangle(1.0);
    let object = Object::new("", shape, 0, None);
    let grey: Box<dyn Bsdf> = Box::new(Diffuse::new(Rgb::splat(0.5)));
    let scene = Scene::new(vec![object], vec![grey], Vec::new(), None).expect("valid");
    for engine in engines(&scene.shapes()) {
        let mut tracer = Tracer::new(&scene, engine.as_ref());
        assert!(tracer.closest_vertex(&good).is_some() && tracer.occluded(&good));
        assert_eq!(tracer.counts.untraceable, 0, "{}", engine.name());
        for (count, ray) in (1..).zip(&bad) {
            assert!(tracer.closest_vertex(ray).is_none(), "{}: {ray:?}", engine.name());
            assert!(!tracer.occluded(ray), "{}: {ray:?}", engine.name());
            assert_eq!(tracer.counts.untraceable, 2 * count, "{}: {ray:?}", engine.name());
        }
    }
}

/// Segments: empty ones, points, all of space. Whether a hit at exactly an end counts is open.
#[test]
fn segments_of_all_kinds_are_served() {
    let ray = upwards(1.0, 1.0);
    for engine in engines(&right_triangle(1.0)) {
        for (t_min, t_max, hits) in [
            (0.0, f32::INFINITY, Some(true)),
            (0.0, f32::MAX, Some(true)),
            (0.0, 0.0, Some(false)),
            (0.5, 0.5, Some(false)),
            (1.0, 1.0, None),
            (2.0, 0.5, Some(false)),
            (1.5, 0.5, Some(false)),
            (0.0, -1.0, Some(false)),
            (0.0, f32::NEG_INFINITY, Some(false)),
            (f32::INFINITY, f32::INFINITY, Some(false)),
            (f32::MAX, f32::INFINITY, Some(false)),
            (f32::MIN_POSITIVE, 1e-45, Some(false)),
        ] {
            let ray = Ray { t_min, t_max, ..ray };
            let (hit, occluded) = (engine.closest_hit(&ray), engine.occluded(&ray));
            assert_eq!(hit.is_some(), occluded, "{}: {ray:?} {hit:?}", engine.name());
            if let Some(expected) = hits {
                assert_eq!(occluded, expected, "{}: {ray:?}", engine.name());
            }
            let (mut many, mut occluded_many) = ([None; 9], [false; 9]);
            engine.closest_hits(&Rays::from_iter(&[ray; 9]), &mut many);
            engine.occluded_many(&Rays::from_iter(&[ray; 9]), &mut occluded_many);
            if hits.is_some() {
                assert_eq!(many.map(|h| h.is_some()), [occluded; 9], "{}: {ray:?}", engine.name());
                assert_eq!(occluded_many, [occluded; 9], "{}: {ray:?}", engine.name());
            }
        }
    }
}

/// No direction hits nothing. One of length 1e-30, which breaks the promise that directions are unit vectors,
/// needs t = 1e30 to get to the triangle: three roundings of the division.
#[test]
fn short_directions_do_no_harm() {
    let ray = upwards(1.0, 1.0);
    for engine in engines(&right_triangle(1.0)) {
        for direction in [Vec3A::ZERO, Vec3A::splat(-0.0)] {
            assert_eq!(engine.closest_hit(&Ray { direction, ..ray }), None, "{}", engine.name());
        }
        let short = Ray { direction: Vec3A::Z * 1e-30, ..ray };
        let t = engine.closest_hit(&short).expect("ahead").t;
        assert!((t / 1e30 - 1.0).abs() < 4.0 * f32::EPSILON, "{}: {t}", engine.name());
    }
}

/// Legs and height s: every product of lengths stays in range between 1e-12 and 1e12, and t is right to three
/// roundings. Beyond, a product of three overflows: nothing may be reported, but no infinite distance.
#[test]
fn a_triangle_is_hit_at_every_scale() {
    for exponent in -12..=18 {
        let s = 10f32.powi(exponent);
        for engine in engines(&right_triangle(s)) {
            let ray = upwards(s, s);
            let hit = engine.closest_hit(&ray);
            assert_eq!(hit.is_some(), engine.occluded(&ray), "{}, {s}: {hit:?}", engine.name());
            match hit {
                Some(hit) => {
                    assert!((hit.t / s - 1.0).abs() < 2e-7, "{}, {s}: {hit:?}", engine.name());
                }
                None => assert!(exponent > 12, "{}: missed at {s}", engine.name()),
            }
        }
    }
}

/// Legs whose products are denormal or 0: a miss, or numbers.
#[test]
fn the_smallest_triangles_give_no_nan() {
    for exponent in -40..=-13 {
        let leg = 10f32.powi(exponent);
        // Below 1e-45 the legs are 0.
        let corners = [Vec3A::ZERO, Vec3A::X * leg, Vec3A::Y * leg].map(Into::into).into();
        let (mesh, _) = TriangleMesh::new(corners, vec![[0, 1, 2]], Vec::new(), Vec::new())
            .expect("indices in range");
        let shapes: [Arc<dyn Shape>; 1] = [Arc::new(mesh)];
        for engine in engines(&shapes) {
            for height in [1.0, leg] {
                let hit = engine.closest_hit(&upwards(leg, height));
                let finite = |h: Hit| [h.t, h.u, h.v].iter().all(|x| x.is_finite());
                assert!(hit.is_none_or(finite), "{}, {leg}: {hit:?}", engine.name());
            }
        }
    }
}

/// Where the hit lies on a small triangle, though Embree itself gives up on weights where twice the area
/// is below 1e-18.
#[test]
fn small_triangles_have_weights() {
    for exponent in -13..=-6 {
        let leg = 10f32.powi(exponent);
        for engine in engines(&right_triangle(leg)) {
            for height in [1.0, leg] {
                let hit = engine.closest_hit(&upwards(leg, height)).expect("in the middle");
                let off = (hit.u - 0.25).abs().max((hit.v - 0.25).abs());
                assert!(off <= 16.0 * ULP, "{}, {leg} from {height}: {hit:?}", engine.name());
            }
            // At a corner they are 0 for another reason.
            let corner = engine.closest_hit(&Ray::new(Vec3A::NEG_Z, Vec3A::Z));
            assert!(corner.is_none_or(|h| h.u == 0.0 && h.v == 0.0), "{corner:?}");
        }
    }
}

/// A mesh with one triangle as large as any may be, one larger, one not finite, one with an infinite
/// vertex and one without area.
#[test]
fn the_largest_triangle_is_hit_and_worse_ones_are_counted() {
    let mut positions = Vec::new();
    for half in [1.8439e18f32, 1.845e18, f32::NAN, f32::INFINITY] {
        positions.extend(
            [(-half, -half), (half, -half), (0.0, half)].map(|(x, y)| Vec3A::new(x, y, 0.0)),
        );
    }
    positions.extend([Vec3A::ZERO, Vec3A::X, Vec3A::X * 2.0]);
    let triangles = (0..5).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let (mesh, dropped) =
        TriangleMesh::new(positions, triangles, Vec::new(), Vec::new()).expect("in range");
    assert_eq!(dropped, Dropped { not_finite: 2, too_large: 1, degenerate: 1 });
    let shapes: [Arc<dyn Shape>; 1] = [Arc::new(mesh)];
    for engine in engines(&shapes) {
        let hit = engine.closest_hit(&Ray::new(Vec3A::NEG_Z, Vec3A::Z)).expect("below the middle");
        assert!((hit.t - 1.0).abs() <= 4.0 * ULP, "{}: {hit:?}", engine.name());
    }
}

/// Rays parallel to an axis, with a 0 of either sign in the other coordinates, that start in planes of
/// boxes and run along their faces, edges and diagonals within a block of unit cubes: 0 times an infinite
/// inverse is NaN in the test of a box. All numbers are small multiples of 1/2, so the f64 brute force is
/// exact. Rays along the block's own edges are left out: whether they touch it is open.
#[test]
fn axis_parallel_rays_meet_what_is_there() {
    let half =
        DAffine3::from_translation(DVec3::splat(0.5)) * DAffine3::from_scale(DVec3::splat(0.5));
    let cube = primitives::cube(half, false).0;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..27 {
        let corner = Vec3A::new((i % 3) as f32, (i / 3 % 3) as f32, (i / 9) as f32);
        let first = positions.len() as u32;
        positions.extend(cube.positions().iter().map(|&p| p + corner));
        triangles.extend(cube.triangles().iter().map(|t| t.map(|v| v + first)));
    }
    let shapes: [Arc<dyn Shape>; 1] = [Arc::new(mesh(positions, triangles))];
    let engines = engines(&shapes);
    let mut hits = 0;
    for axis in 0..3 {
        for (sign, zero) in [(1.0, 0.0f32), (1.0, -0.0), (-1.0, 0.0), (-1.0, -0.0)] {
            let mut direction = Vec3A::splat(zero);
            direction[axis] = sign;
            // From -1 to 4 along the ray, from 0.5 to 2.5 across it.
            for i in 0..11 * 5 * 5 {
                let at = |k: i32| 0.5 * k as f32;
                let mut origin = Vec3A::ZERO;
                origin[axis] = at(i % 11 - 2);
                origin[(axis + 1) % 3] = at(i / 11 % 5 + 1);
                origin[(axis + 2) % 3] = at(i / 55 + 1);
                let ray = Ray::new(origin, direction);
                let expected = trace(shapes[0].as_ref(), &ray).map(|h| h.t);
                hits += usize::from(expected.is_some());
                for engine in &engines {
                    let t = engine.closest_hit(&ray).map(|h| h.t);
                    let same = match (t, expected) {
                        (Some(t), Some(e)) => (t - e).abs() <= 4.0 * ULP * e,
                        (t, e) => t.is_none() && e.is_none(),
                    };
                    assert!(same, "{}: {ray:?} {t:?}, not {expected:?}", engine.name());
                }
            }
        }
    }
    assert!(hits > 2_000, "{hits}");
}

/// A sliver a million times as long as wide is hit along its whole length, and missed beside it.
#[test]
fn slivers_are_hit() {
    for scale in [1e-6f32, 1.0, 1e6] {
        let corners = [Vec3A::ZERO, Vec3A::X * scale, Vec3A::new(0.0, 1e-6, 0.0) * scale];
        for engine in engines(&[triangle(corners)]) {
            for i in 1..1000 {
                let x = i as f32 / 1000.0;
                let at = |y: f32| Ray::new(Vec3A::new(x, y, -1.0) * scale, Vec3A::Z);
                let inside = at(0.5e-6 * (1.0 - x));
                let hit = engine.closest_hit(&inside).unwrap_or_else(|| panic!("missed at {x}"));
                assert!((hit.t / scale - 1.0).abs() <= 4.0 * ULP, "{}: {hit:?}", engine.name());
                for beside in [1.01e-6 * (1.0 - x), -1e-8] {
                    assert_eq!(engine.closest_hit(&at(beside)), None, "{}", engine.name());
                }
            }
        }
    }
}

/// A triangle of edges 11, 9.7 and 1.4, seen at half a degree from 600 away: the point at the reported
/// distance and the point at the reported weights are one. A weight is a product of a distance from the
/// ray's start with an edge, of three roundings, over twice the area that is seen; the point errs by that times
/// an edge: 3 u (|o| + t) e² / (2 A sin 0.5°), a hundredth of the distance at most. Embree has reported
/// distances 20 times too large here (its issue 387).
#[test]
fn flat_views_of_thin_triangles_keep_their_distance() {
    // The angle between the long edges from the law of cosines.
    let (a, b, c) = (11.0f64, 9.7, 1.4);
    let cosine = (a * a + b * b - c * c) / (2.0 * a * b);
    let corner = DVec3::new(b * cosine, b * (1.0 - cosine * cosine).sqrt(), 0.0);
    let turns: Vec<Frame> = points(151, 4_000)
        .map(|u| Frame::from_normal(warp::square_to_uniform_sphere(u.into())))
        .collect();
    let centers: Vec<Vec3A> = points_3d(152, 4_000).map(|u| (u * 2.0 - 1.0) * 400.0).collect();
    let mut positions = Vec::new();
    for (turn, center) in turns.iter().zip(&centers) {
        for p in [DVec3::ZERO, DVec3::X * a, corner] {
            positions.push(*center + Vec3A::from(turn.to_world(p.as_vec3a().into())));
        }
    }
    let triangles = (0..4_000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let shapes: [Arc<dyn Shape>; 1] = [Arc::new(mesh(positions, triangles))];
    let flat = 0.5f32.to_radians();
    for engine in engines(&shapes) {
        let mut hits = 0;
        for (i, (u, w)) in points(153, 1_000_000).zip(points(154, 1_000_000)).enumerate() {
            let primitive = i % 4_000;
            let b = Vec2::from(warp::square_to_uniform_triangle(u.into()));
            let point = corner.as_vec3a() * b.x + Vec3A::X * a as f32 * b.y;
            let turn = &turns[primitive];
            let target = centers[primitive] + Vec3A::from(turn.to_world(point.into()));
            let azimuth = std::f32::consts::TAU * w.x;
            let away = Vec3A::new(
                flat.cos() * azimuth.cos(),
                flat.cos() * azimuth.sin(),
                flat.sin() * (if w.y < 0.5 { 1.0 } else { -1.0 }),
            );
            let origin = target + Vec3A::from(turn.to_world(away.into())) * 600.0;
            let ray = Ray::new(origin, (target - origin).normalize());
            let Some(hit) = engine.closest_hit(&ray) else { continue };
            // Others are seen from every angle; those have no bound.
            if hit.primitive as usize != primitive {
                continue;
            }
            hits += 1;
            let end = ray.origin.as_dvec3() + ray.direction.as_dvec3() * f64::from(hit.t);
            let point = shapes[0].surface(&ray, &hit).position;
            let off = end.distance(point);
            let reach = ray.origin.as_dvec3().length() + f64::from(hit.t);
            let bound =
                3.0 * f64::from(ULP) * reach * a * a / (a * corner.y * f64::from(flat.sin()));
            assert!(off <= bound, "{}: {off} > {bound}, {ray:?} {hit:?}", engine.name());
        }
        assert!(hits > 500_000, "{}: {hits}", engine.name());
    }
}

/// Weights slightly outside the triangle, which engines may report, name a point of it.
#[test]
fn weights_are_clamped() {
    let [shape] = right_triangle(1.0);
    let ray = upwards(1.0, 1.0);
    for (u, v) in [(-1e-6, 0.5), (0.5, -1e-6), (1.000_001, 0.0), (0.6, 0.400_001), (-1.0, 2.0)] {
        let hit = Hit { t: 1.0, u, v, shape: 0, primitive: 0, member: 0 };
        let p = shape.surface(&ray, &hit).position;
        let inside = p.x >= 0.0 && p.y >= 0.0 && p.x + p.y <= 1.0;
        assert!(inside, "({u}, {v}) is {p}");
        let uv: Vec2 = shape.uv(&ray, &hit);
        assert!(uv.cmpge(Vec2::ZERO).all() && uv.x + uv.y <= 1.0, "({u}, {v}) is {uv}");
    }
}

/// Both questions have one answer, for segments that end just before and just behind the nearest hit.
#[test]
fn occlusion_is_whether_there_is_a_hit() {
    let sphere = sphere_mesh(DVec3::new(0.5, -0.25, 4.0), 2.0, 60, 120);
    let shapes: [Arc<dyn Shape>; 1] = [Arc::new(sphere)];
    for engine in engines(&shapes) {
        let mut hits = 0;
        for (a, b) in points_3d(171, 100_000).zip(points(172, 100_000)) {
            let ray = Ray::new(
                (a * 2.0 - 1.0) * 5.0,
                Vec3A::from(warp::square_to_uniform_sphere(b.into())),
            );
            let Some(hit) = engine.closest_hit(&ray) else {
                assert!(!engine.occluded(&ray), "{}: {ray:?}", engine.name());
                continue;
            };
            hits += 1;
            assert!(engine.occluded(&ray), "{}: {ray:?}", engine.name());
            for t_max in [hit.t * 0.999, hit.t * 1.001] {
                let segment = ray.until(t_max);
                let expected = engine.closest_hit(&segment).is_some();
                assert_eq!(engine.occluded(&segment), expected, "{}: {segment:?}", engine.name());
                assert_eq!(expected, t_max > hit.t, "{}: {segment:?}", engine.name());
            }
        }
        assert!(hits > 5_000, "{}: {hits}", engine.name());
    }
}

/// The distance of a hit's point from its triangle's plane, a million sizes away: weights keep it on the
/// triangle to a rounding of each term, where `origin + t · direction` is 0.2 off.
#[test]
fn positions_do_not_depend_on_the_distance() {
    let corners =
        [Vec3A::new(0.3, -0.4, 0.1), Vec3A::new(-0.5, 0.2, 0.3), Vec3A::new(0.1, 0.6, -0.2)];
    let shape = triangle(corners);
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    let normal = (b - a).cross(c - a).normalize();
    let one = mesh(corners.map(Vec3A::from).into(), vec![[0, 1, 2]]);
    assert_eq!(corners_of(&one, 0), [a, b, c]);
    for engine in engines(&[Arc::clone(&shape)]) {
        let mut hits = 0;
        for (u, w) in points(181, 20_000).zip(points(182, 20_000)) {
            let b = Vec2::from(warp::square_to_uniform_triangle(u.into()));
            let target =
                corners[0] + (corners[1] - corners[0]) * b.x + (corners[2] - corners[0]) * b.y;
            let away = Vec3A::from(warp::square_to_uniform_sphere(w.into()));
            let ray = Ray::new(target + away * 1e6, -away);
            let Some(hit) = engine.closest_hit(&ray) else { continue };
            hits += 1;
            let p = shape.surface(&ray, &hit).position;
            let off = (p - a).dot(normal).abs();
            assert!(off < 1e-7, "{}: {off} off the plane, {hit:?}", engine.name());
        }
        assert!(hits > 2_000, "{}: {hits}", engine.name());
    }
}
