//! Lights: of a million triangles, tiny, blinding, seen from everywhere, and what a floor gets of them.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3A};
use telamon::bsdf::{Bsdf, Diffuse};
use telamon::emitter::{Area, ChoicePolicy, Emitter, EmitterChoice, Point, Receiver, Sight};
use telamon::integrator::{Integrator, MisHeuristic, Path, PathSettings, Strategy, Tracer};
use telamon::math::{Choice, Discrete, Rgb};
use telamon::ray::Ray;
use telamon::sampler::{Independent, PathSampler, Sampler};
use telamon::scene::Scene;
use telamon::shape::{Shape, primitives};

use crate::support::lights::{lambert, lights, sphere, square, triangle};
use crate::support::meshes::engines;
use crate::support::points_3d;
use crate::support::rays::trace;
use crate::support::rooms::object;
use crate::support::stats::{Moments, chi_squared};

/// How often the number that is left of a choice among `count` alike falls into each of 64 cells.
fn rests(count: usize, number: impl Fn(u32) -> f64) -> Vec<u64> {
    let alike = Discrete::new(&vec![1.0; count]).expect("positive weights");
    let mut cells = vec![0; 64];
    for i in 0..200_000 {
        let Choice { rest, .. } = alike.sample(number(i));
        cells[(rest * 64.0) as usize] += 1;
    }
    cells
}

/// A choice among a million leaves a number that is good for a coordinate: 20 bits of 40. Numbers of 24 bits
/// leave four of them, and choose some of a million 6 % more often than others.
#[test]
fn a_choice_among_a_million_leaves_a_number() {
    let sampler = Independent::new(501);
    let fine = |i| sampler.get_choice(sampler.path(0, i), 0).x;
    let expected = [200_000.0 / 64.0; 64];
    for count in [1, 3, 1_000, 1 << 20, 4_000_000] {
        let cells = rests(count, fine);
        chi_squared(&cells, &expected, 5).unwrap_or_else(|table| panic!("{count}: {table}"));
    }
    let coarse = |i| f64::from(sampler.get_1d(sampler.path(0, i), 0));
    assert!(chi_squared(&rests(1 << 20, coarse), &expected, 1).is_err());
}

const BOTH: Strategy = Strategy::Mis(MisHeuristic::Power);

/// A floor of albedo 1/2 in z = 0, of half side 1, under a light that shines `radiance`.
fn floor_under(light: Arc<dyn Shape>, radiance: f32) -> Scene {
    let floor: Arc<dyn Shape> = Arc::new(primitives::rectangle(DAffine3::IDENTITY, false).0);
    let area: Box<dyn Emitter> =
        Box::new(Area::new(light.clone(), Rgb::splat(radiance)).expect("an area"));
    let grey: Box<dyn Bsdf> = Box::new(Diffuse::new(Rgb::splat(0.5)));
    let black: Box<dyn Bsdf> = Box::new(Diffuse::new(Rgb::ZERO));
    let objects = vec![object(floor, 0, None), object(light, 1, Some(0))];
    Scene::new(objects, vec![grey, black], vec![area], None).expect("valid")
}

/// What is seen of the floor's middle, from just above it, so that no light is in the way: E / 2π for the
/// irradiance E.
fn seen(scene: &Scene, strategy: Strategy, count: u32) -> Vec<(String, Moments)> {
    let integrator =
        Path::new(&PathSettings { strategy, max_depth: Some(2), ..PathSettings::default() }, scene);
    let ray = Ray::new(Vec3A::Z * 1e-6, Vec3A::NEG_Z);
    let look = |engine: Box<dyn telamon::intersect::Intersector>| {
        let mut tracer = Tracer::new(scene, engine.as_ref());
        let sampler = Independent::new(7);
        let values = (0..count).map(|i| {
            let mut numbers = PathSampler::new(&sampler, i, 0);
            f64::from(integrator.estimate(&mut tracer, &ray, &mut numbers).radiance.x)
        });
        (engine.name(), Moments::of(values))
    };
    engines(&scene.shapes()).into_iter().map(look).collect()
}

/// A square of side a at height h: E = 4A·atan(A), A = s/√(s² + h²), s = a/2. By shadow rays, by directions and
/// by both, where the variance allows: no direction in a million meets the smallest solid angles, down to
/// 1e-8, and shadow rays to a light that nearly touches the floor rarely go where its light comes from.
#[test]
fn squares_of_all_sizes_light_a_floor() {
    let (bsdf, emitter) = (Strategy::Bsdf, Strategy::Emitter);
    let cases: [(f64, f64, &[Strategy]); 6] = [
        (2.0, 1.0, &[bsdf, emitter, BOTH]),
        (0.2, 1.0, &[bsdf, emitter, BOTH]),
        (0.002, 1.0, &[emitter, BOTH]),
        (1e-4, 1.0, &[emitter, BOTH]),
        (2.0, 0.001, &[bsdf, BOTH]),
        (2.0, 1000.0, &[emitter, BOTH]),
    ];
    for (side, height, strategies) in cases {
        let a = 0.5 * side / (0.5 * side).hypot(height);
        let expected = 4.0 * a * a.atan() / (2.0 * PI);
        let light = square(0.5 * side, Vec3A::Z * height as f32);
        for radiance in [1.0, 1e30, 1e-30] {
            let scene = floor_under(light.clone(), radiance);
            let expected = expected * f64::from(radiance);
            for &strategy in strategies {
                for (engine, values) in seen(&scene, strategy, 100_000) {
                    // Checks: fourteen pairs of a square and a strategy, three radiances, two engines.
                    values.has_mean(expected, 84).unwrap_or_else(|figures| {
                        panic!("{engine}, {side} at {height}, {strategy:?}, {radiance}: {figures}")
                    });
                    assert!(values.has_mean(1.1 * expected, 1).is_err(), "{side} {strategy:?}");
                }
            }
        }
    }
}

/// Five triangles somewhere above the floor, by each strategy, against Lambert's sum over their edges.
#[test]
fn triangles_light_a_floor() {
    let corners: Vec<Vec3A> = points_3d(511, 15)
        .map(|u| Vec3A::new(1.6 * u.x - 0.8, 1.6 * u.y - 0.8, 0.2 + 2.0 * u.z))
        .collect();
    for corners in corners.chunks(3) {
        let mut corners = [corners[0], corners[1], corners[2]];
        if (corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(corners[0]) > 0.0 {
            corners.swap(1, 2);
        }
        let irradiance = lambert(&corners.map(|c| c.as_dvec3()), DVec3::ZERO, DVec3::Z);
        let scene = floor_under(triangle(corners), 1.0);
        for strategy in [Strategy::Bsdf, Strategy::Emitter, BOTH] {
            for (engine, values) in seen(&scene, strategy, 100_000) {
                values.has_mean(irradiance / (2.0 * PI), 30).unwrap_or_else(|figures| {
                    panic!("{engine}, {corners:?}, {strategy:?}: {figures}")
                });
            }
        }
    }
}

/// A sphere of every apparent size, down to one that is a point to an f32: E = π (r/d)².
#[test]
fn spheres_of_all_sizes_light_a_floor() {
    for exponent in 1..=7 {
        let ratio = 10f64.powi(-exponent);
        for (radius, distance) in [(ratio as f32, 1.0f32), (1.0, (1.0 / ratio) as f32)] {
            let ratio = f64::from(radius) / f64::from(distance);
            let scene = floor_under(sphere(Vec3A::Z * distance, radius), 1.0);
            for (engine, values) in seen(&scene, BOTH, 10_000) {
                values
                    .has_mean(0.5 * ratio * ratio, 28)
                    .unwrap_or_else(|f| panic!("{engine}, {radius} at {distance}: {f}"));
            }
        }
    }
    // So small that its solid angle is no f32.
    let light = Area::new(sphere(Vec3A::Z * 1e12, 1e-10), Rgb::splat(1e30)).expect("an area");
    let s = light.sample_toward(DVec3::ZERO, glam::DVec2::splat(0.5)).expect("seen");
    let expected = PI * 1e-44 * 1e30;
    assert!((f64::from(s.weight.x) / expected - 1.0).abs() < 1e-6, "{s:?}");
}

/// The weights of both techniques for one direction sum to 1, as nearly as their densities agree: those of the
/// light differ by 2e-6 over the cosine there and by 2e-5 where a mesh moves points off its edges, which the
/// weights' slope of at most 1/2 halves.
#[test]
fn weights_of_both_techniques_sum_to_one() {
    let lights = lights();
    let count = 100_000 / lights.len() as u32;
    for light in &lights {
        let area = Area::new(Arc::clone(&light.shape), Rgb::ONE).expect("an area");
        for u in crate::support::points(521, count) {
            let Some(s) = area.sample_toward(light.from.as_dvec3(), u.as_dvec2()) else { continue };
            let ray = Ray::new(light.from, s.direction);
            let Some(hit) = trace(light.shape.as_ref(), &ray) else { continue };
            let point = light.shape.surface(&ray, &hit);
            let surface = Some((&hit, &point));
            let sight = Sight { from: light.from.as_dvec3(), direction: s.direction, surface };
            let cosine = f64::from(point.geometric_normal.dot(s.direction).abs());
            let bsdf = s.direction.dot(light.normal).max(0.0) / std::f32::consts::PI;
            for heuristic in [MisHeuristic::Balance, MisHeuristic::Power] {
                let sum =
                    heuristic.weight(s.pdf, bsdf) + heuristic.weight(bsdf, area.pdf_toward(&sight));
                let tolerance = 1e-6 + 2e-6 / cosine + 2e-5 + light.direction_error(cosine);
                let off = f64::from(sum - 1.0).abs();
                // Straight along the floor no direction is chosen, and the light has it all.
                assert!(bsdf == 0.0 || off <= tolerance, "{}: {sum}, {s:?}", light.name);
            }
        }
    }
}

/// A light of 1e20 W behind a wall and one of 1 W in sight, chosen by power: all that is seen comes from the dim
/// one, a thousandth of whose share is left to it.
#[test]
fn a_dim_light_is_seen_beside_a_blinding_one() {
    let lights: Vec<Box<dyn Emitter>> = vec![
        Box::new(Point::new(Vec3A::NEG_Z, Rgb::splat(1e20))),
        Box::new(Point::new(Vec3A::Z, Rgb::ONE)),
    ];
    let choice = EmitterChoice::new(ChoicePolicy::Power, &lights);
    let below =
        Receiver { position: DVec3::ZERO, normal: Vec3A::Z, both_sides: false, is_diffuse: true };
    let dim = choice.probability(&below, 1);
    assert!((dim - 5e-4).abs() < 1e-6, "{dim}");
    let floor: Arc<dyn Shape> = Arc::new(primitives::rectangle(DAffine3::IDENTITY, false).0);
    let grey: Box<dyn Bsdf> = Box::new(Diffuse::new(Rgb::splat(0.5)));
    let objects = vec![object(floor, 0, None)];
    let scene = Scene::new(objects, vec![grey], lights, None).expect("valid");
    let settings = |emitter_choice| PathSettings { emitter_choice, ..PathSettings::default() };
    for policy in [ChoicePolicy::Power, ChoicePolicy::Uniform, ChoicePolicy::Bvh] {
        let integrator = Path::new(&settings(policy), &scene);
        for engine in engines(&scene.shapes()) {
            let mut tracer = Tracer::new(&scene, engine.as_ref());
            let sampler = Independent::new(8);
            let ray = Ray::new(Vec3A::new(0.3, 0.2, 0.1), Vec3A::NEG_Z);
            let values = (0..400_000).map(|i| {
                let mut numbers = PathSampler::new(&sampler, i, 0);
                f64::from(integrator.estimate(&mut tracer, &ray, &mut numbers).radiance.x)
            });
            // I cosθ / d² · albedo / π with d² = 1.13 and cosθ = 1/d.
            let expected = 1.13f64.powf(-1.5) * 0.5 / PI;
            Moments::of(values)
                .has_mean(expected, 6)
                .unwrap_or_else(|f| panic!("{}, {policy:?}: {f}", engine.name()));
        }
    }
}
