//! Rays that leave surfaces: they do not meet them again, nothing gets through, and what is close is seen.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec2, Vec3A};
use telamon::bsdf::{Bsdf, Dielectric, Diffuse, TwoSided};
use telamon::emitter::{Area, Emitter, EmitterSample, LightOrigin};
use telamon::integrator::{Integrator, Path, PathSettings, Tracer};
use telamon::intersect::Intersector;
use telamon::math::{Frame, Rgb, warp};
use telamon::ray::{Ray, RayEnd};
use telamon::sampler::{Independent, PathSampler};
use telamon::scene::Scene;
use telamon::shape::{Shape, Sphere, SurfacePoint, TriangleMesh, primitives};

use crate::support::lights::triangle;
use crate::support::meshes::{engines, mesh, sphere_mesh};
use crate::support::rooms::object;
use crate::support::{points, points_3d};

/// The surface that a ray meets, which must be there.
fn seen(engine: &dyn Intersector, shapes: &[Arc<dyn Shape>], ray: &Ray) -> SurfacePoint {
    let hit = engine.closest_hit(ray).unwrap_or_else(|| panic!("{}: {ray:?}", engine.name()));
    shapes[hit.shape as usize].surface(ray, &hit)
}

/// A floor exactly in a plane of constant y, of 20 by 20.
fn floor(y: f32) -> Arc<dyn Shape> {
    let corner = |x, z| Vec3A::new(x, y, z);
    let corners =
        [corner(-10.0, -10.0), corner(-10.0, 10.0), corner(10.0, 10.0), corner(10.0, -10.0)];
    Arc::new(mesh(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]))
}

/// The offset of a floor in y = 0 is 0, so only the start of the segment, the smallest normal number, keeps
/// the ray off; at other heights there is an offset.
#[test]
fn no_ray_meets_the_floor_that_it_leaves() {
    for y in [0.0, 1.0, -100.0, 1e5] {
        let shapes = [floor(y)];
        for engine in engines(&shapes) {
            for (a, b) in points_3d(301, 20_000).zip(points(302, 20_000)) {
                let target = Vec3A::new(20.0 * a.x - 10.0, y, 20.0 * a.y - 10.0)
                    * Vec3A::new(0.99, 1.0, 0.99);
                let side = if a.z < 0.5 { 1.0 } else { -1.0 };
                let origin = target + Vec3A::new(3.0 * (a.z - 0.5), 5.0 * side, 1.0);
                let ray = Ray::new(origin, (target - origin).normalize());
                let point = seen(engine.as_ref(), &shapes, &ray);
                let up = Vec3A::from(warp::square_to_uniform_hemisphere(b.into()));
                // Down to 1e-6 above the plane.
                let flat = Vec3A::new(up.x, up.y, 1e-6).normalize();
                for local in [up, flat] {
                    let away = Vec3A::new(local.x, side * local.z, local.y);
                    let leaving = point.spawn(away);
                    let again = engine.closest_hit(&leaving);
                    assert_eq!(again, None, "{} at {y}: {leaving:?}", engine.name());
                    assert!(!engine.occluded(&leaving), "{} at {y}: {leaving:?}", engine.name());
                }
            }
        }
    }
}

/// pbrt's recipe: triangles whose coordinates range over 16 decades; a ray from a hit does not find the
/// triangle again, whichever side it leaves to.
#[test]
fn triangles_of_all_shapes_are_left() {
    let coordinates: Vec<f32> = points(311, 9 * 1_000)
        .map(|u| 10f64.powf(16.0 * f64::from(u.x) - 8.0).copysign(f64::from(u.y) - 0.5) as f32)
        .collect();
    let mut tested = 0;
    for numbers in coordinates.chunks(9) {
        let corners = [0, 3, 6].map(|i| Vec3A::new(numbers[i], numbers[i + 1], numbers[i + 2]));
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        if (b - a).cross(c - a).length_squared() < 1e-20 {
            continue;
        }
        let shapes = [triangle(corners)];
        for engine in engines(&shapes) {
            for (i, u) in (0..).zip(points_3d(312, 1_000)) {
                let bary = Vec2::from(warp::square_to_uniform_triangle(u.truncate().into()));
                let target =
                    (a + (b - a) * f64::from(bary.x) + (c - a) * f64::from(bary.y)).as_vec3a();
                let origin = Vec3A::new(u.z, u.x, u.y) * 2.0 - 1.0;
                let distance = (target - origin).length();
                let ray = Ray::new(origin, (target - origin) / distance);
                // Slivers are often missed: they are thinner than the rounding of the ray.
                let Some(hit) = engine.closest_hit(&ray) else { continue };
                let point = shapes[0].surface(&ray, &hit);
                let away = Vec3A::from(warp::square_to_uniform_sphere(
                    points(313 + i, 1).next().expect("one point").into(),
                ));
                let leaving = point.spawn(away);
                let again = engine.closest_hit(&leaving);
                assert_eq!(again, None, "{}: {corners:?} {leaving:?}", engine.name());
                tested += 1;
            }
        }
    }
    assert!(tested > 50_000, "{tested}");
}

/// Two facing unit squares at coordinates near 1 see each other down to a gap of 5e-7, two offsets of
/// 4 · 2⁻²⁴ and a step of the grid; with an offset of 32 · 2⁻²⁴ it was 4e-6.
#[test]
fn narrow_gaps_are_seen() {
    for gap in [1e-5, 1e-6, 5e-7] {
        let at = |z: f64| {
            DAffine3::from_translation(DVec3::new(1.0, 1.0, 1.0 + z))
                * DAffine3::from_scale(DVec3::splat(0.5))
        };
        let shapes: [Arc<dyn Shape>; 2] = [
            Arc::new(primitives::rectangle(at(0.0), false).0),
            Arc::new(primitives::rectangle(at(gap), true).0),
        ];
        for engine in engines(&shapes) {
            for u in points_3d(321, 10_000) {
                let target = Vec3A::new(0.6 + 0.8 * u.x, 0.6 + 0.8 * u.y, 1.0);
                let origin = target - Vec3A::Z * 3.0;
                let point = seen(engine.as_ref(), &shapes, &Ray::new(origin, Vec3A::Z));
                assert!((point.position.z - 1.0).abs() < 1e-7);
                let leaving = point.spawn(Vec3A::new(0.3 * u.z, 0.1, 1.0).normalize());
                let hit = engine.closest_hit(&leaving);
                let shape = hit.map(|h| h.shape);
                assert_eq!(shape, Some(1), "{}, gap {gap}: {leaving:?}", engine.name());
            }
        }
    }
}

/// Two concentric spheres of 78,000 triangles, 4e-5 apart: a ray that passes the outer one meets the
/// inner one.
#[test]
fn thin_shells_are_kept_apart() {
    let shapes: [Arc<dyn Shape>; 2] = [
        Arc::new(sphere_mesh(DVec3::ZERO, 1.0 + 4e-5, 140, 280)),
        Arc::new(sphere_mesh(DVec3::ZERO, 1.0, 140, 280)),
    ];
    for engine in engines(&shapes) {
        for u in points(331, 50_000) {
            let outward = Vec3A::from(warp::square_to_uniform_sphere(u.into()));
            // Off the centre, so that the view is flat here and there.
            let through = Vec3A::new(u.y, -u.x, 0.3) * 0.9 - 0.3;
            let ray = Ray::new(outward * 3.0, (through - outward * 3.0).normalize());
            let Some(hit) = engine.closest_hit(&ray) else { continue };
            assert_eq!(hit.shape, 0, "{}: {ray:?}", engine.name());
            let point = shapes[0].surface(&ray, &hit);
            let on = engine.closest_hit(&point.spawn(ray.direction));
            let shape = on.map(|h| h.shape);
            let flat = point.geometric_normal.dot(ray.direction).abs() < 0.1;
            assert!(shape == Some(1) || flat, "{}: {ray:?} {on:?}", engine.name());
        }
    }
}

/// Whether paths along such rays carry nothing, with each engine.
pub(crate) fn assert_all_black(scene: &Scene, paths: u32, ray: impl Fn(Vec3A) -> Ray) {
    let integrator = Path::new(&PathSettings::default(), scene);
    for engine in engines(&scene.shapes()) {
        let mut tracer = Tracer::new(scene, engine.as_ref());
        let sampler = Independent::new(1);
        for i in 0..paths {
            let mut numbers = PathSampler::new(&sampler, i, 0);
            let ray = ray(numbers.next_2d().extend(numbers.next_1d()).into());
            let radiance = integrator.estimate(&mut tracer, &ray, &mut numbers).radiance;
            assert_eq!(radiance, Rgb::ZERO, "{}: path {i}", engine.name());
        }
    }
}

/// Light below a floor on which a glass sphere rests: none comes up.
#[test]
fn no_light_leaks_through_a_floor() {
    let at = |height: f64, scale: f64| {
        DAffine3::from_translation(DVec3::new(0.0, 0.0, height))
            * DAffine3::from_scale(DVec3::splat(scale))
    };
    let floor: Arc<dyn Shape> = Arc::new(primitives::rectangle(at(0.0, 10.0), false).0);
    let light: Arc<dyn Shape> = Arc::new(primitives::rectangle(at(-0.1, 5.0), false).0);
    let glass: Arc<dyn Shape> =
        Arc::new(Sphere::new(Vec3A::Z, 1.0, Frame::from_normal(Vec3A::Z.into()), false));
    let emitter = Area::new(Arc::clone(&light), Rgb::ONE).expect("an area");
    let bsdfs: Vec<Box<dyn Bsdf>> = vec![
        Box::new(Diffuse::new(Rgb::splat(0.5))),
        Box::new(Dielectric::new(1.5, 1.0, Rgb::ONE, Rgb::ONE)),
    ];
    let objects = vec![object(floor, 0, None), object(light, 0, Some(0)), object(glass, 1, None)];
    let scene =
        Scene::new(objects, bsdfs, vec![Box::new(emitter)], None).expect("indices in range");
    assert_all_black(&scene, 500_000, |u| {
        let target = Vec3A::new(4.0 * u.x - 2.0, 4.0 * u.y - 2.0, 0.0);
        let origin = Vec3A::new(3.0, 0.0, 4.0);
        Ray::new(origin, (target - origin).normalize())
    });
}

/// A shadow ray ends before its light by the sum of both ends' bounds and not by a part of its length: of
/// two surfaces at a thousandth from a light, the one between 1000 and it is in the way, the one behind is
/// not. Ends that are closer than the bounds see each other.
#[test]
fn shadow_rays_end_at_the_light() {
    let facing = |z: f64, flip| {
        let at = DAffine3::from_translation(DVec3::Z * z);
        let shape: Arc<dyn Shape> = Arc::new(primitives::rectangle(at, flip).0);
        shape
    };
    let receiver = facing(0.0, false);
    let light = facing(1000.0, true);
    let ray = Ray::new(Vec3A::new(0.1, 0.2, 0.5), Vec3A::NEG_Z);
    for engine in engines(&[receiver.clone(), light.clone()]) {
        let point = seen(engine.as_ref(), std::slice::from_ref(&receiver), &ray);
        let area = Area::new(light.clone(), Rgb::ONE).expect("an area");
        for u in points(341, 1_000) {
            let sample = area.sample_toward(point.position, u.as_dvec2()).expect("in front");
            let shadow = sample.shadow_ray(&point).expect("far away");
            for (z, blocked) in [(999.999, true), (1000.001, false), (0.001, true), (-0.001, false)]
            {
                let blocker = facing(z, false);
                for engine in engines(&[blocker]) {
                    assert_eq!(engine.occluded(&shadow), blocked, "{} at {z}", engine.name());
                }
            }
            assert!(!engine.occluded(&shadow), "{}: {shadow:?}", engine.name());
        }
        // A light that touches the receiver.
        let near = EmitterSample {
            direction: Vec3A::Z,
            weight: Rgb::ONE,
            pdf: 1.0,
            origin: LightOrigin::Surface(RayEnd {
                point: point.position
                    + DVec3::Z * f64::from(0.5 * point.end_towards(Vec3A::Z).lift()),
                ..point.end_towards(Vec3A::NEG_Z)
            }),
        };
        assert!(near.shadow_ray(&point).is_none());
    }
}

/// A coarse sphere with smooth normals, whose shading normals lean over its silhouettes: neither does a lamp
/// inside shine out, nor one outside shine in, though it reflects on both sides.
#[test]
fn smooth_normals_leak_no_light() {
    let coarse = sphere_mesh(DVec3::ZERO, 1.0, 6, 10);
    let normals = coarse.positions().iter().map(|&p| p.into()).collect();
    let (smooth, _) = TriangleMesh::new(
        coarse.positions().to_vec(),
        coarse.triangles().to_vec(),
        normals,
        Vec::new(),
    )
    .expect("valid");
    assert!(smooth.has_vertex_normals());
    let smooth: Arc<dyn Shape> = Arc::new(smooth);
    let lamp = |center: Vec3A| -> Arc<dyn Shape> {
        Arc::new(Sphere::new(center, 0.2, Frame::from_normal(Vec3A::Z.into()), false))
    };
    for (lamp, from) in [(lamp(Vec3A::ZERO), Vec3A::Z * 3.0), (lamp(Vec3A::Z * 3.0), Vec3A::ZERO)] {
        let grey = Diffuse::new(Rgb::splat(0.9));
        let both = TwoSided::new(Box::new(grey), None).expect("reflects only");
        let emitter = Area::new(Arc::clone(&lamp), Rgb::ONE).expect("an area");
        let objects = vec![object(smooth.clone(), 0, None), object(lamp, 0, Some(0))];
        let bsdfs: Vec<Box<dyn Bsdf>> = vec![Box::new(both)];
        let scene = Scene::new(objects, bsdfs, vec![Box::new(emitter)], None).expect("valid");
        assert_all_black(&scene, 100_000, |u| {
            let target = Vec3A::from(warp::square_to_uniform_sphere(u.truncate().into())) * 0.9;
            Ray::new(from, (target - from).normalize())
        });
    }
}
