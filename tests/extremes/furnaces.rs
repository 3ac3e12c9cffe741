//! Closed rooms whose radiance is known: small, large, far away, and between mirrors.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3A};
use telamon::bsdf::{Bsdf, Conductor, Diffuse};
use telamon::emitter::{Area, Emitter};
use telamon::integrator::{
    Integrator, IntegratorSettings, MisHeuristic, Path, PathSettings, Roulette, RoulettePolicy,
    Strategy, Tracer,
};
use telamon::intersect::{Intersector, Recorder};
use telamon::math::{Frame, Rgb};
use telamon::ray::Ray;
use telamon::sampler::{Independent, PathSampler};
use telamon::scene::Scene;
use telamon::shape::{Shape, Sphere, TriangleMesh, primitives};

use crate::support::meshes::{engines, sphere_mesh_and_dropped};
use crate::support::rooms::{
    NO_ROULETTE, closed_cube, closed_sphere, estimates, furnace, furnace_radiance, object,
};
use crate::support::stats::Moments;

/// A room of half side or radius `size` around `center`, seen from inside: flat walls, a mesh of 4,560
/// triangles, an exact sphere.
fn rooms(center: DVec3, size: f64) -> [(&'static str, Arc<dyn Shape>); 3] {
    let at = DAffine3::from_translation(center) * DAffine3::from_scale(DVec3::splat(size));
    let (outside, _) = sphere_mesh_and_dropped(center, size, 39, 60);
    let inside = outside.triangles().iter().map(|&[a, b, c]| [a, c, b]).collect();
    let (mesh, _) = TriangleMesh::new(outside.positions().to_vec(), inside, Vec::new(), Vec::new())
        .expect("valid");
    let axes = Frame::from_normal(Vec3A::Z.into());
    let sphere = Sphere::new(center.as_vec3a(), size as f32, axes, true);
    [
        ("cube", Arc::new(primitives::cube(at, true).0)),
        ("mesh", Arc::new(mesh)),
        ("sphere", Arc::new(sphere)),
    ]
}

/// Without roulette and shadow rays every path of a furnace is the same sum, unless a ray gets out.
fn assert_no_path_is_cut(name: &str, shape: Arc<dyn Shape>, from: Vec3A) {
    const DEPTH: u32 = 20;
    let settings = IntegratorSettings::Path(PathSettings {
        strategy: Strategy::Bsdf,
        roulette: NO_ROULETTE,
        max_depth: Some(DEPTH),
        ..PathSettings::default()
    });
    let scene = furnace(shape, 0.8);
    let expected = furnace_radiance(0.8, DEPTH);
    // Up to DEPTH products and sums, each rounded once.
    let tolerance = expected * f64::from(DEPTH) * f64::from(f32::EPSILON);
    for engine in engines(&scene.shapes()) {
        for value in estimates(&scene, engine.as_ref(), &settings, from, 2_000) {
            let right = (value - expected).abs() <= tolerance;
            assert!(right, "{}, {name}: {value}, not {expected}", engine.name());
        }
    }
}

#[test]
fn paths_stay_in_rooms_of_all_sizes() {
    for exponent in [-10, -9, -6, -3, 0, 3, 6, 9, 12] {
        let size = 10f64.powi(exponent);
        for (name, shape) in rooms(DVec3::ZERO, size) {
            let from = (DVec3::new(0.1, -0.2, 0.05) * size).as_vec3a();
            assert_no_path_is_cut(&format!("{name} of 1e{exponent}"), shape, from);
        }
    }
}

/// Rooms of half side 1 as far away as their corners are exact, in one direction and in all three.
#[test]
fn paths_stay_in_rooms_far_away() {
    for power in [10, 14, 17, 20] {
        let far = f64::from(power).exp2();
        for center in [DVec3::X * far, DVec3::splat(-far)] {
            for (name, shape) in rooms(center, 1.0) {
                // The facets of a mesh do not survive a grid of their own size.
                if name == "mesh" && power > 17 {
                    continue;
                }
                let from = (center + DVec3::new(0.125, -0.25, 0.125)).as_vec3a();
                assert_no_path_is_cut(&format!("{name} at {center}"), shape, from);
            }
        }
    }
}

/// The whole machine in the same rooms: shadow rays, weights, roulette.
#[test]
fn furnaces_give_2_and_5_everywhere() {
    let places = [
        (DVec3::ZERO, 1e-6),
        (DVec3::ZERO, 1e6),
        (DVec3::ZERO, 1e-10),
        (DVec3::ZERO, 1e12),
        (DVec3::X * 1e6, 1e3),
        (DVec3::new(1e6, -1e6, 1e6), 1e4),
        (DVec3::splat(8192.0), 1.0),
    ];
    let settings = IntegratorSettings::Path(PathSettings {
        strategy: Strategy::Mis(MisHeuristic::Power),
        ..PathSettings::default()
    });
    for (albedo, expected) in [(0.5, 2.0), (0.8, 5.0)] {
        for (center, size) in places {
            for (name, shape) in rooms(center, size) {
                let scene = furnace(shape, albedo);
                let from = (center + DVec3::new(0.125, -0.25, 0.0625) * size).as_vec3a();
                for engine in engines(&scene.shapes()) {
                    let values = estimates(&scene, engine.as_ref(), &settings, from, 10_000);
                    // Checks: two albedos, seven places, three rooms, two engines.
                    Moments::of(values).has_mean(expected, 84).unwrap_or_else(|figures| {
                        panic!("{}, {name} of {size} at {center}: {figures}", engine.name())
                    });
                }
            }
        }
    }
}

/// Albedo 0.9 and 0.99: 10 and 100, by paths of a mean length of 10 and 100 edges.
#[test]
fn bright_furnaces_have_their_radiance() {
    for (albedo, expected) in [(0.9, 10.0), (0.99, 100.0)] {
        let roulette = Roulette {
            policy: RoulettePolicy::Throughput,
            factor: 1.0,
            min_depth: 0,
            max_survival: 0.999,
        };
        let settings = IntegratorSettings::Path(PathSettings {
            strategy: Strategy::Bsdf,
            roulette,
            ..PathSettings::default()
        });
        for (name, shape) in [("cube", closed_cube()), ("sphere", closed_sphere())] {
            let scene = furnace(shape, albedo);
            for engine in engines(&scene.shapes()) {
                let values = estimates(&scene, engine.as_ref(), &settings, Vec3A::ZERO, 20_000);
                Moments::of(values)
                    .has_mean(expected, 8)
                    .unwrap_or_else(|e| panic!("{}, {name}, {albedo}: {e}", engine.name()));
            }
        }
    }
}

/// A black room shows its own light to the last bit, whatever its strength.
#[test]
fn black_furnaces_show_their_light() {
    for radiance in [1e-30f32, 1.0, 1e30] {
        let black: Box<dyn Bsdf> = Box::new(Diffuse::new(Rgb::ZERO));
        let scene = crate::support::rooms::scene(vec![closed_cube()], black, radiance);
        let settings = IntegratorSettings::Path(PathSettings::default());
        for engine in engines(&scene.shapes()) {
            for value in estimates(&scene, engine.as_ref(), &settings, Vec3A::ZERO, 1_000) {
                assert_eq!(value, f64::from(radiance), "{}", engine.name());
            }
        }
    }
}

/// Two mirrors that face each other, at y = 0 and y = 1 before they are turned, with a lamp across the end of the
/// corridor between them. What the camera sees of it after `slope⁻¹` bounces a unit, and what was asked.
fn corridor(turn: DMat3, reflectance: f32, slope: f64) -> Vec<(String, f32, Vec<Ray>)> {
    let quad = |center: DVec3, u: DVec3, v: DVec3| -> Arc<dyn Shape> {
        let map = DMat3::from_cols(u, v, u.cross(v).normalize());
        let at = DAffine3::from_mat3_translation(turn * map, turn * center);
        Arc::new(primitives::rectangle(at, false).0)
    };
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let lower = quad(x * 0.5, z, x);
    let upper = quad(x * 0.5 + y, x, z);
    let lamp = quad(x * 1.25 + y * 0.5, z, y);
    let mirror: Box<dyn Bsdf> = Box::new(Conductor::mirror(Rgb::splat(reflectance)));
    let black: Box<dyn Bsdf> = Box::new(Diffuse::new(Rgb::ZERO));
    let emitter: Box<dyn Emitter> =
        Box::new(Area::new(Arc::clone(&lamp), Rgb::ONE).expect("an area"));
    let objects = vec![object(lower, 0, None), object(upper, 0, None), object(lamp, 1, Some(0))];
    let scene = Scene::new(objects, vec![mirror, black], vec![emitter], None).expect("valid");
    let settings = PathSettings { roulette: NO_ROULETTE, ..PathSettings::default() };
    let integrator = Path::new(&settings, &scene);
    let direction = turn * (x * slope + y).normalize();
    let ray = Ray::new((turn * (y * 0.5)).as_vec3a(), direction.as_vec3a());
    let look = |engine: Box<dyn Intersector>| {
        let recorder = Recorder::new(engine.as_ref());
        let mut tracer = Tracer::new(&scene, &recorder);
        let sampler = Independent::new(1);
        let mut numbers = PathSampler::new(&sampler, 0, 0);
        let value = integrator.estimate(&mut tracer, &ray, &mut numbers).radiance.x;
        let rays = recorder.take().iter().map(|q| q.ray).collect();
        (engine.name(), value, rays)
    };
    engines(&scene.shapes()).into_iter().map(look).collect()
}

/// The path meets the mirrors 10,000 times on its way and carries r^10,000 of the lamp's light. Each bounce
/// rounds its place by u, a 2000th of the way to the next: five bounces more or less. The product rounds once
/// for each: 6e-4 at most.
#[test]
fn mirrors_face_each_other_for_ten_thousand_bounces() {
    const BOUNCES: i32 = 10_000;
    let reflectance = 0.9999f32;
    // From the middle between the mirrors half a leap is left for the first and a quarter for the last.
    let slope = 1.25 / (f64::from(BOUNCES) + 0.25);
    for (engine, value, rays) in corridor(DMat3::IDENTITY, reflectance, slope) {
        let bounces = rays.len() as i32 - 1;
        assert!((bounces - BOUNCES).abs() <= 5, "{engine}: {bounces}");
        let expected = f64::from(reflectance).powi(bounces);
        let tolerance = expected * f64::from(BOUNCES) * f64::from(crate::ULP);
        assert!((f64::from(value) - expected).abs() <= tolerance, "{engine}: {value}");
    }
}

/// Turned by an odd angle, every direction is rounded: each bounce turns it by up to u, which over so many
/// moves the end, but its length stays 1 and the lamp is reached.
#[test]
fn directions_keep_their_length_between_mirrors() {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 1.0);
    for (engine, value, rays) in corridor(turn, 1.0, 1.25e-4) {
        assert_eq!(value, 1.0, "{engine}: the lamp is not reached");
        assert!(rays.len() > 5_000, "{engine}: {}", rays.len());
        let longest = |ray: &Ray| (ray.direction.as_dvec3().length() - 1.0).abs();
        let worst = rays.iter().map(longest).fold(0.0, f64::max);
        // Three roundings.
        assert!(worst < 3.0 * f64::from(crate::ULP), "{engine}: {worst}");
    }
}
