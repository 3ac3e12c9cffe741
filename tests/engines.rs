//! Both engines answer the same about the same shapes, one ray at a time and in batches.

mod support;

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec2, Vec3A};
use support::meshes::{engines, sphere_mesh};
use telamon::math::{Frame, warp};
use telamon::ray::{Hit, Ray, Rays};
use telamon::sampler::{Independent, PathSampler};
use telamon::shape::{Cylinder, Disk, Shape, Sphere, TriangleMesh, primitives};

fn shapes() -> Vec<Arc<dyn Shape>> {
    let tilted = DAffine3::from_scale_rotation_translation(
        DVec3::new(1.5, 0.5, 1.0),
        glam::DQuat::from_rotation_x(0.7),
        DVec3::new(0.0, 0.0, 4.0),
    );
    let (cube, _) = primitives::cube(DAffine3::from_translation(DVec3::new(4.0, 0.0, 0.0)), false);
    let axes = Frame::from_normal(Vec3A::Z.into());
    vec![
        Arc::new(sphere_mesh(DVec3::ZERO, 1.0, 40, 80)),
        Arc::new(Sphere::new(Vec3A::new(-4.0, 0.0, 0.0), 1.25, axes, false)),
        Arc::new(Disk::new(tilted, false).expect("not singular")),
        Arc::new(cube),
        Arc::new(tube()),
        Arc::new(TriangleMesh::default()),
    ]
}

fn tube() -> Cylinder {
    let axes = [DVec3::X, DVec3::Z, DVec3::Y * 2.0];
    Cylinder::new(DVec3::new(0.0, -1.0, -4.0), axes, false).expect("has an area")
}

/// Random rays from a box around the shapes towards points among them.
fn rays(count: u32) -> Vec<Ray> {
    let sampler = Independent::new(7);
    (0..count)
        .map(|i| {
            let mut u = PathSampler::new(&sampler, i, 0);
            let mut cube = || Vec3A::new(u.next_1d(), u.next_1d(), u.next_1d()) * 2.0 - 1.0;
            let origin = cube() * 7.0;
            let target = cube() * Vec3A::new(5.5, 1.5, 5.0);
            let ray = Ray::new(origin, (target - origin).normalize());
            if i % 3 == 0 { ray.until(10.0 * u.next_1d()) } else { ray }
        })
        .collect()
}

#[test]
fn single_rays_and_batches_agree() {
    let shapes = shapes();
    let mut rays = rays(10_003);
    rays[17].origin.x = f32::NAN;
    rays[4711].direction = Vec3A::splat(f32::INFINITY);
    for engine in engines(&shapes) {
        let mut hits = vec![None; rays.len()];
        engine.closest_hits(&Rays::from_iter(&rays), &mut hits);
        let mut occluded = vec![false; rays.len()];
        engine.occluded_many(&Rays::from_iter(&rays), &mut occluded);
        assert!(hits.iter().flatten().count() > 1000, "{}: hardly a hit", engine.name());
        for ((ray, hit), occluded) in rays.iter().zip(&hits).zip(&occluded) {
            let single = engine.closest_hit(ray);
            assert_eq!(key(single), key(*hit), "{}: {ray:?}", engine.name());
            // Packets use other instructions; a distance may differ by the engine's own tolerance.
            let t = |h: Option<Hit>| h.map_or(0.0, |h| h.t);
            assert!((t(single) - t(*hit)).abs() <= 16.0 * f32::EPSILON * t(single), "{ray:?}");
            assert_eq!(engine.occluded(ray), *occluded, "{}: {ray:?}", engine.name());
            assert_eq!(hit.is_some(), *occluded, "{}: {ray:?}", engine.name());
        }
    }
}

/// Which primitive was hit.
fn key(hit: Option<Hit>) -> Option<(u32, u32)> {
    hit.map(|h| (h.shape, h.primitive))
}

/// Of 100,000 random rays at most 1 may see another primitive than the other engine does: the two round
/// differently within 1e-6 of an edge, which such a ray meets with a probability below 1e-5.
#[test]
fn engines_agree() {
    let shapes = shapes();
    let engines = engines(&shapes);
    let [first, others @ ..] = engines.as_slice() else { panic!("no engine") };
    for other in others {
        let mut differences = 0;
        for ray in rays(100_000) {
            let (a, b) = (first.closest_hit(&ray), other.closest_hit(&ray));
            if key(a) != key(b) {
                differences += 1;
                continue;
            }
            let (Some(a), Some(b)) = (a, b) else { continue };
            // Grazing hits are 1e-4 off at worst.
            assert!((a.t - b.t).abs() <= 1e-4 * a.t.max(b.t), "{ray:?}: {a:?} {b:?}");
            let [p, q] = [a, b].map(|hit| shapes[hit.shape as usize].surface(&ray, &hit).position);
            assert!(p.distance(q) <= 1e-3, "{ray:?}: {p} {q}");
        }
        assert!(differences <= 1, "{} against {}: {differences}", first.name(), other.name());
    }
}

/// Rays that no engine may be asked about: none ends the process, all miss.
#[test]
fn untraceable_rays_miss() {
    let shapes = shapes();
    let good = Ray::new(Vec3A::new(0.1, 0.1, -3.0), Vec3A::Z);
    for engine in engines(&shapes) {
        assert!(engine.closest_hit(&good).is_some());
        let mut bad = Vec::new();
        for value in [f32::NAN, f32::INFINITY, 1e20] {
            bad.push(Ray { origin: Vec3A::new(value, 0.0, 0.0), ..good });
            bad.push(Ray { direction: Vec3A::new(0.0, value, 1.0), ..good });
        }
        bad.extend([-1.0, f32::NAN].map(|t_min| Ray { t_min, ..good }));
        bad.push(Ray { t_max: f32::NAN, ..good });
        bad.extend([-1e-7, 1.000_000_1, f32::NAN].map(|time| Ray { time, ..good }));
        for ray in bad {
            assert_eq!(engine.closest_hit(&ray), None, "{}: {ray:?}", engine.name());
            assert!(!engine.occluded(&ray), "{}: {ray:?}", engine.name());
        }
    }
}

#[test]
fn nothing_to_hit_is_never_hit() {
    let empty = TriangleMesh::default();
    for shapes in [Vec::new(), vec![Arc::new(empty) as Arc<dyn Shape>]] {
        for engine in engines(&shapes) {
            assert_eq!(engine.closest_hit(&Ray::new(Vec3A::ZERO, Vec3A::X)), None);
            assert!(!engine.occluded(&Ray::new(Vec3A::ZERO, Vec3A::X)));
        }
    }
}

/// Neither building nor tracing changes how the processor rounds: the smallest normal number halves to
/// a denormal one before, after, and on every thread of the pool.
#[test]
fn denormal_numbers_survive() {
    let halve = || std::hint::black_box(f32::MIN_POSITIVE) * std::hint::black_box(0.5);
    for engine in engines(&shapes()) {
        let ray = Ray::new(Vec3A::new(0.1, 0.1, -3.0), Vec3A::Z);
        assert!(engine.closest_hit(&ray).is_some());
        assert_eq!(halve(), f32::from_bits(0x0040_0000), "{}", engine.name());
        for half in rayon::broadcast(|_| (engine.closest_hit(&ray), halve()).1) {
            assert_eq!(half, f32::from_bits(0x0040_0000), "{}", engine.name());
        }
    }
}

/// A ray that leaves a surface does not hit it again, however large it is and wherever it lies.
#[test]
fn surfaces_are_left() {
    let sampler = Independent::new(3);
    for exponent in [-6, -2, 0, 3, 6] {
        for distance in [0.0, 1.0, 1e3] {
            let size = 10f32.powi(exponent);
            let center = Vec3A::new(0.3, -0.5, 0.8) * distance * size;
            let mesh: Arc<dyn Shape> =
                Arc::new(sphere_mesh(center.as_dvec3(), size.into(), 20, 40));
            let shapes = [mesh];
            for engine in engines(&shapes) {
                for i in 0..2000 {
                    let mut u = PathSampler::new(&sampler, i, exponent.unsigned_abs());
                    let outward = Vec3A::from(warp::square_to_uniform_sphere(u.next_2d().into()));
                    let ray = Ray::new(center + outward * (3.0 * size), -outward);
                    let hit = engine.closest_hit(&ray).expect("towards the centre");
                    let point = shapes[0].surface(&ray, &hit);
                    // The mesh is convex: no ray that leaves it hits it again.
                    let frame = Frame::from_normal(point.geometric_normal.into());
                    let up = Vec3A::from(warp::square_to_cosine_hemisphere(u.next_2d().into()));
                    let leaving = point.spawn(Vec3A::from(frame.to_world(up.into())));
                    assert_eq!(
                        engine.closest_hit(&leaving),
                        None,
                        "{}: {leaving:?}",
                        engine.name()
                    );
                    assert!(!engine.occluded(&leaving));
                }
            }
        }
    }
}

/// Many copies of one triangle leave a builder nothing to split.
#[test]
fn coincident_triangles_build() {
    let positions = vec![Vec3A::ZERO, Vec3A::X, Vec3A::Y];
    let mesh = TriangleMesh::new(positions, vec![[0, 1, 2]; 100_000], Vec::new(), Vec::new())
        .expect("indices in range")
        .0;
    let shapes: [Arc<dyn Shape>; 1] = [Arc::new(mesh)];
    for engine in engines(&shapes) {
        let ray = Ray::new(Vec2::splat(0.25).extend(-1.0), Vec3A::Z);
        // Embree's own tolerance is 16 ulp.
        let t = engine.closest_hit(&ray).expect("in the middle").t;
        assert!((t - 1.0).abs() < 16.0 * f32::EPSILON, "{}: {t}", engine.name());
    }
}
