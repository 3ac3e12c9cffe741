//! Directions, frames and materials at the ends of their ranges.

use glam::{DVec3, Vec2, Vec3A};
use telamon::bsdf::{Bsdf, Dielectric, Diffuse};
use telamon::emitter::{Constant, Emitter};
use telamon::integrator::{Integrator, Path, PathSettings, Tracer};
use telamon::math::{Frame, Rgb};
use telamon::ray::Ray;
use telamon::sampler::{Independent, PathSampler};
use telamon::scene::Scene;
use telamon::shape::{Shape, Sphere, TriangleMesh};

use crate::support::meshes::{engines, mesh};
use crate::support::points;
use crate::support::rooms::{NO_ROULETTE, object};

/// Frames around normals down to 1e-8 from the pole at which other constructions fail. Duff et al. measured
/// 1.5e-7; a product of two vectors sums the deviations of both.
#[test]
fn frames_are_orthonormal_near_the_pole() {
    let mut worst = 0.0f64;
    let mut check = |n: Vec3A| {
        let f = Frame::from_normal(n.into());
        let [s, t, n] = [f.s, f.t, f.n].map(|v| Vec3A::from(v).as_dvec3());
        let lengths = [s, t, n].map(|v| v.length_squared() - 1.0);
        for off in lengths.into_iter().chain([s.dot(t), t.dot(n), n.dot(s)]) {
            worst = worst.max(off.abs());
        }
    };
    for normal in [Vec3A::X, Vec3A::new(1.0, 0.0, -0.0), Vec3A::Y, Vec3A::NEG_Z, Vec3A::Z] {
        check(normal);
    }
    for u in points(401, 1_000_000) {
        let theta = 10f64.powf(-8.0 + 8.0 * f64::from(u.x));
        let phi = std::f64::consts::TAU * f64::from(u.y);
        let (sin, cos) = theta.sin_cos();
        for side in [1.0, -1.0] {
            check(DVec3::new(sin * phi.cos(), sin * phi.sin(), side * cos).as_vec3a());
        }
    }
    assert!(worst < 3e-7, "{worst}");
}

/// What a path from a sphere of glass under a white sky sees: 1, whatever the index. Refraction divides by the
/// squared index on the way in and multiplies by it on the way out, once for each passage.
#[test]
fn glass_of_every_index_vanishes_in_a_white_sky() {
    for index in [1.0, 1.0 + 1e-6, 1.0 + 1e-3, 1.5, 1000.0, 1e-3, 1e6] {
        let glass: Box<dyn Bsdf> = Box::new(Dielectric::new(index, 1.0, Rgb::ONE, Rgb::ONE));
        assert_vanishes(&format!("index {index}"), glass);
    }
}

fn assert_vanishes(name: &str, bsdf: Box<dyn Bsdf>) {
    let sphere = Sphere::new(Vec3A::ZERO, 1.0, Frame::from_normal(Vec3A::Z.into()), false);
    let sky: Box<dyn Emitter> = Box::new(Constant::new(Rgb::ONE));
    let objects = vec![object(std::sync::Arc::new(sphere), 0, None)];
    let scene = Scene::new(objects, vec![bsdf], vec![sky], Some(0)).expect("valid");
    let settings = PathSettings { roulette: NO_ROULETTE, ..PathSettings::default() };
    let integrator = Path::new(&settings, &scene);
    for engine in engines(&scene.shapes()) {
        let mut tracer = Tracer::new(&scene, engine.as_ref());
        let sampler = Independent::new(2);
        for (i, u) in (0..).zip(points(402, 3_000)) {
            let mut numbers = PathSampler::new(&sampler, i, 0);
            // From the middle of the disk that is seen to a millionth of its rim.
            let r = if i % 2 == 0 { u.x.sqrt() } else { 1.0 - 1e-6 * u.x };
            let (sin, cos) = (std::f32::consts::TAU * u.y).sin_cos();
            let ray = Ray::new(Vec3A::new(r * cos, r * sin, -4.0), Vec3A::Z);
            let before = tracer.counts.closest;
            let value = integrator.estimate(&mut tracer, &ray, &mut numbers).radiance.x;
            // Each bounce within rounds the angle, but only a passage scales the radiance: 4 roundings.
            let rays = tracer.counts.closest - before;
            assert!((value - 1.0).abs() < 1e-5, "{}, {name}: {value}, {rays} rays", engine.name());
        }
    }
}

/// A floor seen at an angle of a millionth: under a white sky it shows its reflectance, from either side of
/// such a view, a million away.
#[test]
fn floors_are_seen_at_the_flattest_angles() {
    let far = 2e6;
    let floor = mesh(
        vec![
            Vec3A::new(-far, -far, 0.0),
            Vec3A::new(far, -far, 0.0),
            Vec3A::new(far, far, 0.0),
            Vec3A::new(-far, far, 0.0),
        ],
        vec![[0, 1, 2], [0, 2, 3]],
    );
    let sky: Box<dyn Emitter> = Box::new(Constant::new(Rgb::ONE));
    let grey: Box<dyn Bsdf> = Box::new(Diffuse::new(Rgb::splat(0.25)));
    let objects = vec![object(std::sync::Arc::new(floor), 0, None)];
    let scene = Scene::new(objects, vec![grey], vec![sky], Some(0)).expect("valid");
    let settings = PathSettings {
        strategy: telamon::integrator::Strategy::Bsdf,
        roulette: NO_ROULETTE,
        ..PathSettings::default()
    };
    let integrator = Path::new(&settings, &scene);
    for engine in engines(&scene.shapes()) {
        let mut tracer = Tracer::new(&scene, engine.as_ref());
        let sampler = Independent::new(3);
        for i in 0..10_000 {
            let mut numbers = PathSampler::new(&sampler, i, 0);
            let u = numbers.next_2d();
            let (sin, cos) = (std::f32::consts::TAU * u.x).sin_cos();
            // From 1e-6 to 1e-3 radians below the horizon.
            let slope = 10f32.powf(-6.0 + 3.0 * u.y);
            let direction = Vec3A::new(cos, sin, -slope).normalize();
            let ray = Ray::new(Vec3A::new(0.3, 0.2, 1.0), direction);
            let value = integrator.estimate(&mut tracer, &ray, &mut numbers).radiance.x;
            // The floor is flat: no path meets it twice.
            assert_eq!(value, 0.25, "{}: slope {slope}", engine.name());
        }
    }
}

/// Vertex normals that are zero, missing in part, or that face away from the viewer: the surface is lit by
/// its geometric normal, or black, and never NaN.
#[test]
fn broken_vertex_normals_are_no_nan() {
    let corners = vec![Vec3A::ZERO, Vec3A::X, Vec3A::Y];
    let normal = |v: Vec3A| v.into();
    for (name, normals) in [
        ("zero", [Vec3A::ZERO; 3]),
        ("opposed", [Vec3A::Z, Vec3A::NEG_Z, Vec3A::ZERO]),
        ("not a number", [Vec3A::NAN, Vec3A::Z, Vec3A::Z]),
        ("infinite", [Vec3A::INFINITY, Vec3A::Z, Vec3A::Z]),
        ("tiny", [Vec3A::Z * 1e-30; 3]),
        ("huge", [Vec3A::Z * 1e30; 3]),
        ("flat", [Vec3A::X, Vec3A::X, Vec3A::X]),
        ("backwards", [Vec3A::NEG_Z; 3]),
    ] {
        let (mesh, _) = TriangleMesh::new(
            corners.clone(),
            vec![[0, 1, 2]],
            normals.map(normal).into(),
            Vec::new(),
        )
        .expect("valid");
        let shapes: [std::sync::Arc<dyn Shape>; 1] = [std::sync::Arc::new(mesh)];
        let sky: Box<dyn Emitter> = Box::new(Constant::new(Rgb::ONE));
        let grey: Box<dyn Bsdf> = Box::new(Diffuse::new(Rgb::splat(0.5)));
        let objects = vec![object(shapes[0].clone(), 0, None)];
        let scene = Scene::new(objects, vec![grey], vec![sky], Some(0)).expect("valid");
        let integrator = Path::new(&PathSettings::default(), &scene);
        for engine in engines(&shapes) {
            let mut tracer = Tracer::new(&scene, engine.as_ref());
            let sampler = Independent::new(4);
            for (i, u) in (0..).zip(points(404, 1_000)) {
                let mut numbers = PathSampler::new(&sampler, i, 0);
                let target = Vec3A::new(0.5 * u.x, 0.5 * u.y, 0.0);
                let side = if i % 2 == 0 { 1.0 } else { -1.0 };
                let origin = Vec3A::new(0.4, -0.2, 2.0 * side);
                let ray = Ray::new(origin, (target - origin).normalize());
                let point = engine.closest_hit(&ray).map(|hit| shapes[0].surface(&ray, &hit));
                let point = point.expect("in front");
                let unit = |v: Vec3A| (v.length() - 1.0).abs() < 1e-6;
                assert!(unit(point.shading_normal) && unit(point.geometric_normal), "{name}");
                // Both lie on one side.
                assert!(
                    point.shading_normal.dot(point.geometric_normal) >= 0.0,
                    "{name}: {point:?}"
                );
                let value = integrator.estimate(&mut tracer, &ray, &mut numbers).radiance;
                let lit = value.is_finite() && value.cmpge(Rgb::ZERO).all();
                assert!(lit, "{}, {name}: {value}", engine.name());
                // Of the geometric normal where the others say nothing.
                if ["zero", "not a number"].contains(&name) {
                    assert_eq!(point.shading_normal, Vec3A::Z, "{name}");
                }
            }
        }
    }
}

/// The ends of the square of numbers: no material and no angle makes them a direction without a density.
/// (`bsdfs` has all materials at ordinary angles; these are the flattest that f32 holds.)
#[test]
fn corners_of_the_square_at_the_flattest_angles() {
    for material in crate::support::materials::materials() {
        for z in [1.0f32, 1e-3, 1e-7, 1e-20, f32::MIN_POSITIVE, 1e-45, 0.0] {
            for side in [1.0, -1.0] {
                let wi = Vec3A::new((1.0 - z * z).sqrt(), 0.0, side * z);
                let corners = [0.0, crate::support::BELOW_ONE];
                for u in corners.into_iter().flat_map(|x| corners.map(|y| Vec2::new(x, y))) {
                    let Some(s) = material.sample(wi, u) else { continue };
                    let usable = (s.wo.length() - 1.0).abs() < 1e-6
                        && s.pdf > 0.0
                        && s.pdf.is_finite()
                        && s.weight.is_finite()
                        && s.weight.min_element() >= 0.0;
                    assert!(usable, "{} from {wi} with {u}: {s:?}", material.name());
                    assert!(material.eval(wi, s.wo).is_finite(), "{}", material.name());
                }
                assert!(material.albedo(wi).is_finite(), "{} from {wi}", material.name());
            }
        }
    }
}
