//! Integrators against closed forms: the furnace, the depth cap, Russian roulette, occlusion.

mod support;

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3A};
use support::rooms::{
    self, NO_ROULETTE, closed_cube, closed_sphere, furnace, furnace_radiance, object, scene,
};
use support::stats::Moments;
use telamon::bsdf::plastic::Coat;
use telamon::bsdf::{
    Blend, Bsdf, Conductor, Dielectric, Diffuse, Mask, Null, Plastic, ThinDielectric, TwoSided,
};
use telamon::emitter::{Area, ChoicePolicy, Constant, Emitter};
use telamon::integrator::{
    AmbientOcclusionSettings, BranchingSettings, DirectUniformSettings, DirectionSampling,
    IntegratorSettings, MisHeuristic, PathSettings, Roulette, RoulettePolicy, Strategy, Tracer,
    build,
};
use telamon::intersect::{self, Backend, Intersector};
use telamon::math::{Frame, Rgb};
use telamon::ray::Ray;
use telamon::sampler::{Independent, PathSampler};
use telamon::scene::Scene;
use telamon::shape::{Shape, Sphere, primitives};

const STRATEGIES: [Strategy; 4] = [
    Strategy::Bsdf,
    Strategy::Emitter,
    Strategy::Mis(MisHeuristic::Balance),
    Strategy::Mis(MisHeuristic::Power),
];

const DIRECTIONS: [DirectionSampling; 3] = [
    DirectionSampling::Bsdf,
    DirectionSampling::CosineHemisphere,
    DirectionSampling::UniformHemisphere,
];

fn engine(scene: &Scene, backend: Backend) -> Box<dyn Intersector> {
    intersect::build(backend, &scene.shapes()).expect("builds")
}

/// Estimates of the red channel in random directions from a point near the centre.
fn estimates(scene: &Scene, settings: &IntegratorSettings, count: u32) -> Vec<f64> {
    let engine = engine(scene, Backend::default());
    let from = Vec3A::new(0.1, -0.2, 0.05);
    rooms::estimates(scene, engine.as_ref(), settings, from, count)
}

fn path(settings: PathSettings) -> IntegratorSettings {
    IntegratorSettings::Path(settings)
}

/// Every strategy, every choice of directions, in a room of flat walls and in a round one. But for shadow rays alone between
/// flat walls: at their edges the square of cosθ cosθ'/d² has no integral, and an estimate without variance no test.
#[test]
fn furnace_is_as_bright_as_its_albedo_says() {
    let checks = 2 * (2 * STRATEGIES.len() - 1) * DIRECTIONS.len();
    for (albedo, expected) in [(0.5, 2.0), (0.8, 5.0)] {
        for (room, shape) in [("cube", closed_cube()), ("sphere", closed_sphere())] {
            let scene = furnace(shape, albedo);
            for strategy in STRATEGIES {
                if room == "cube" && strategy == Strategy::Emitter {
                    continue;
                }
                for directions in DIRECTIONS {
                    let settings =
                        path(PathSettings { strategy, directions, ..PathSettings::default() });
                    Moments::of(estimates(&scene, &settings, 40_000))
                        .has_mean(expected, checks)
                        .unwrap_or_else(|e| {
                            panic!("{room}, albedo {albedo}, {strategy:?}, {directions:?}: {e}")
                        });
                }
            }
        }
    }
}

/// The check above must be able to fail: a room that is 3 % darker than claimed.
#[test]
fn furnace_of_another_albedo_is_noticed() {
    let scene = furnace(closed_cube(), 0.5);
    let values = estimates(&scene, &path(PathSettings::default()), 40_000);
    assert!(Moments::of(values).has_mean(2.06, 1).is_err());
}

/// Without roulette and shadow rays every path is the same sum: 1 + a + … + a^(D−1) for D edges. Each of
/// up to 40 products and sums rounds once.
#[test]
fn furnace_with_a_depth_cap_has_no_noise() {
    for albedo in [0.2f32, 0.5, 0.8, 0.99] {
        for depth in [1u32, 2, 7, 40] {
            let settings = path(PathSettings {
                strategy: Strategy::Bsdf,
                roulette: NO_ROULETTE,
                max_depth: Some(depth),
                ..PathSettings::default()
            });
            let expected = furnace_radiance(albedo, depth);
            for value in estimates(&furnace(closed_cube(), albedo), &settings, 500) {
                let tolerance = expected * f64::from(depth) * f64::from(f32::EPSILON);
                assert!((value - expected).abs() <= tolerance, "{albedo} {depth}: {value}");
            }
        }
    }
}

/// The lecture's tracers see the same room: one bounce is 1 + a, `branching` the capped sum.
#[test]
fn simple_tracers_agree_with_the_furnace() {
    let scene = furnace(closed_cube(), 0.5);
    let direct = IntegratorSettings::DirectUniform(DirectUniformSettings { hide_emitters: false });
    Moments::of(estimates(&scene, &direct, 40_000)).has_mean(1.5, 3).expect("direct_uniform");
    for directions in [DirectionSampling::Bsdf, DirectionSampling::UniformHemisphere] {
        let branching = IntegratorSettings::Branching(BranchingSettings {
            branches: 3,
            max_depth: 4,
            directions,
            hide_emitters: false,
        });
        Moments::of(estimates(&scene, &branching, 10_000))
            .has_mean(1.875, 3)
            .unwrap_or_else(|e| panic!("branching, {directions:?}: {e}"));
    }
}

/// Roulette in a furnace, where the walk is known: with w = a/p the estimate of n edges is
/// (1 − wⁿ)/(1 − w), and n is geometric. Its mean is 1/(1 − a) for every p, and its second moment
/// 1/(1 − w²p) + 2/(w − 1)·(1/(1 − w²p) − 1/(1 − wp)), finite if a² < p; for w = 1 the variance is
/// a/(1 − a)².
#[test]
fn roulette_keeps_the_mean_and_has_the_variance_of_theory() {
    let cases = [
        (0.2, RoulettePolicy::Throughput, 0.2),
        (0.5, RoulettePolicy::Throughput, 0.5),
        (0.8, RoulettePolicy::Throughput, 0.8),
        (0.5, RoulettePolicy::Fixed(0.7), 0.7),
        (0.5, RoulettePolicy::Fixed(0.95), 0.95),
        (0.8, RoulettePolicy::Fixed(0.9), 0.9),
    ];
    for (albedo, policy, p) in cases {
        let roulette = Roulette { policy, factor: 1.0, min_depth: 0, max_survival: 0.99 };
        let settings =
            path(PathSettings { strategy: Strategy::Bsdf, roulette, ..PathSettings::default() });
        let values = estimates(&furnace(closed_sphere(), albedo as f32), &settings, 200_000);
        let n = values.len() as f64;
        let moments = Moments::of(values.iter().copied());
        moments
            .has_mean(1.0 / (1.0 - albedo), cases.len())
            .unwrap_or_else(|e| panic!("albedo {albedo}, {policy:?}: {e}"));
        let mean = 1.0 / (1.0 - albedo);
        // After each survival the throughput is exactly 1 where roulette follows it, since w = 1.
        let w = albedo / p;
        let expected = if (w - 1.0).abs() < 1e-9 {
            albedo / (1.0 - albedo).powi(2)
        } else {
            let second = 1.0 / (1.0 - w * w * p);
            second + 2.0 / (w - 1.0) * (second - 1.0 / (1.0 - w * p)) - mean * mean
        };
        // The error of a sample variance is that of the mean of squared deviations.
        let squares = Moments::of(values.iter().map(|v| (v - mean).powi(2) * n / (n - 1.0)));
        squares
            .has_mean(expected, cases.len())
            .unwrap_or_else(|e| panic!("variance, albedo {albedo}, {policy:?}: {e}"));
    }
}

/// A room with one small light, grey walls, a mirror, glass, and materials that have delta lobes beside
/// others: no closed form, one mean.
fn varied_room() -> Scene {
    let sphere = |x, y, radius| -> Arc<dyn Shape> {
        Arc::new(Sphere::new(
            Vec3A::new(x, y, 0.0),
            radius,
            Frame::from_normal(Vec3A::Z.into()),
            false,
        ))
    };
    let at = DAffine3::from_translation(DVec3::new(0.0, 0.95, 0.0))
        * DAffine3::from_rotation_x(std::f64::consts::FRAC_PI_2)
        * DAffine3::from_scale(DVec3::splat(0.4));
    let light: Arc<dyn Shape> = Arc::new(primitives::rectangle(at, false).0);
    let emitter = Area::new(Arc::clone(&light), Rgb::splat(10.0)).expect("an area");
    let grey = |albedo| -> Box<dyn Bsdf> { Box::new(Diffuse::new(Rgb::splat(albedo))) };
    let plastic = Plastic::new(Coat::new(1.5, 1.0, Rgb::splat(0.7), Rgb::ONE, false));
    let bsdfs: Vec<Box<dyn Bsdf>> = vec![
        grey(0.6),
        Box::new(Conductor::mirror(Rgb::splat(0.9))),
        Box::new(Dielectric::new(1.5, 1.0, Rgb::ONE, Rgb::ONE)),
        Box::new(Mask::new(0.6, Box::new(plastic))),
        Box::new(Blend::new(0.4, [grey(0.8), Box::new(Conductor::mirror(Rgb::splat(0.9)))])),
    ];
    let objects = vec![
        object(closed_cube(), 0, None),
        object(sphere(-0.6, -0.6, 0.3), 1, None),
        object(sphere(0.6, -0.6, 0.3), 2, None),
        object(sphere(-0.6, 0.5, 0.3), 3, None),
        object(sphere(0.6, 0.5, 0.3), 4, None),
        object(light, 0, Some(0)),
    ];
    Scene::new(objects, bsdfs, vec![Box::new(emitter)], None).expect("indices in range")
}

/// Roulette of every kind, every strategy and both choices of an emitter have the mean of long paths
/// that nothing cuts short. 40 edges at albedo 0.9 and below leave out less than 1e-3 of the light of
/// this room, below a standard error of these samples.
#[test]
fn policies_and_strategies_have_one_mean() {
    let scene = varied_room();
    let long =
        PathSettings { roulette: NO_ROULETTE, max_depth: Some(40), ..PathSettings::default() };
    let policy =
        |policy, min_depth| Roulette { policy, factor: 3.0, min_depth, max_survival: 0.99 };
    let variants = [
        PathSettings { roulette: policy(RoulettePolicy::Throughput, 0), ..long },
        PathSettings { roulette: policy(RoulettePolicy::Throughput, 5), ..long },
        PathSettings { roulette: policy(RoulettePolicy::Fixed(0.8), 2), ..long },
        PathSettings { strategy: Strategy::Emitter, ..long },
        PathSettings { strategy: Strategy::Bsdf, ..long },
        PathSettings { strategy: Strategy::Mis(MisHeuristic::Balance), ..long },
        PathSettings { directions: DirectionSampling::UniformHemisphere, ..long },
        PathSettings { emitter_choice: ChoicePolicy::Power, ..long },
    ];
    // Other numbers for the reference, so that the two means are independent.
    let reference = Moments::of(estimates(&scene, &path(long), 240_000).split_off(120_000));
    for variant in variants {
        let moments = Moments::of(estimates(&scene, &path(variant), 120_000));
        let difference = moments.mean() - reference.mean();
        let error = moments.standard_error().hypot(reference.standard_error());
        // 0.01 shared by eight two-sided tests: 3.2 standard errors.
        assert!(difference.abs() < 3.2 * error, "{variant:?}: {difference} ± {error}");
    }
}

/// Several shadow rays at each surface and several paths from the first have the mean of one of each, for all
/// strategies: the counts are in the weights.
#[test]
fn several_samples_have_the_mean_of_one() {
    let scene = varied_room();
    let short =
        PathSettings { roulette: NO_ROULETTE, max_depth: Some(5), ..PathSettings::default() };
    // Other numbers for the reference, so that the two means are independent.
    let reference = Moments::of(estimates(&scene, &path(short), 240_000).split_off(60_000));
    for strategy in STRATEGIES {
        for (emitter_samples, bsdf_samples) in [(4, 1), (1, 3), (5, 2)] {
            let variant = PathSettings { strategy, emitter_samples, bsdf_samples, ..short };
            let moments = Moments::of(estimates(&scene, &path(variant), 60_000));
            let difference = moments.mean() - reference.mean();
            let error = moments.standard_error().hypot(reference.standard_error());
            // 0.01 shared by twelve two-sided tests: 3.35 standard errors.
            assert!(difference.abs() < 3.35 * error, "{variant:?}: {difference} ± {error}");
            // It can fail, except where directions alone find a small lamp: 10 % more light is seen.
            let wrong = difference + 0.1 * moments.mean();
            let seen = wrong.abs() > 3.35 * error;
            assert!(seen || strategy == Strategy::Bsdf, "{variant:?}: {wrong} ± {error}");
        }
    }
}

/// Along one ray direct light has the variance of one sample, divided by their number, if there is one technique; by
/// two it is less than by one sample of each.
#[test]
fn several_samples_have_less_variance() {
    const COUNT: u32 = 40_000;
    let scene = varied_room();
    let engine = engine(&scene, Backend::default());
    let variance = |strategy, emitter_samples, bsdf_samples| {
        let direct = PathSettings { strategy, max_depth: Some(2), ..PathSettings::default() };
        let settings = path(PathSettings { emitter_samples, bsdf_samples, ..direct });
        let integrator = build(&settings, &scene).0.expect("makes a picture");
        let (sampler, mut tracer) = (Independent::new(6), Tracer::new(&scene, engine.as_ref()));
        let values = (0..COUNT).map(|i| {
            let ray = Ray::new(Vec3A::new(0.1, -0.2, 0.05), Vec3A::new(0.3, -1.0, 0.2).normalize());
            let mut numbers = PathSampler::new(&sampler, i, 0);
            f64::from(integrator.estimate(&mut tracer, &ray, &mut numbers).radiance.x)
        });
        Moments::of(values).standard_error().powi(2) * f64::from(COUNT)
    };
    // A sample variance of values between 0 and a few means is off by 2 % or less here.
    let about = |found: f64, expected: f64| (found / expected - 1.0).abs() < 0.1;
    let by_lights = variance(Strategy::Emitter, 1, 1);
    assert!(about(variance(Strategy::Emitter, 4, 1), by_lights / 4.0));
    let by_materials = variance(Strategy::Bsdf, 1, 1);
    assert!(about(variance(Strategy::Bsdf, 1, 4), by_materials / 4.0));
    assert!(!about(variance(Strategy::Bsdf, 1, 3), by_materials / 4.0), "cannot fail");
    let by_both = Strategy::Mis(MisHeuristic::Power);
    assert!(variance(by_both, 4, 4) < 0.3 * variance(by_both, 1, 1));
}

/// A white sphere under a white sky vanishes: every path carries exactly 1, whatever it meets.
#[test]
fn white_things_vanish_in_a_white_sky() {
    let white = || -> Box<dyn Bsdf> { Box::new(Diffuse::new(Rgb::ONE)) };
    let mirror = || -> Box<dyn Bsdf> { Box::new(Conductor::mirror(Rgb::ONE)) };
    let materials: [Box<dyn Bsdf>; 7] = [
        white(),
        mirror(),
        Box::new(Dielectric::new(1.5, 1.0, Rgb::ONE, Rgb::ONE)),
        Box::new(ThinDielectric::new(1.5, 1.0, Rgb::ONE, Rgb::ONE)),
        Box::new(Null),
        Box::new(Mask::new(0.5, Box::new(TwoSided::new(white(), None).expect("reflects")))),
        Box::new(Blend::new(0.3, [white(), mirror()])),
    ];
    for bsdf in materials {
        let name = format!("{bsdf:?}");
        let outward = |center: Vec3A| -> Arc<dyn Shape> {
            Arc::new(Sphere::new(center, 0.5, Frame::from_normal(Vec3A::Z.into()), false))
        };
        let spheres = [Vec3A::X, Vec3A::NEG_X * 2.0];
        let objects = spheres.map(|center| object(outward(center), 0, None)).into();
        let sky: Box<dyn Emitter> = Box::new(Constant::new(Rgb::ONE));
        let scene = Scene::new(objects, vec![bsdf], vec![sky], Some(0)).expect("indices in range");
        let settings = path(PathSettings {
            strategy: Strategy::Bsdf,
            roulette: NO_ROULETTE,
            max_depth: Some(1000),
            ..PathSettings::default()
        });
        for value in estimates(&scene, &settings, 20_000) {
            // Each refraction divides by the squared index and multiplies by it again.
            assert!((value - 1.0).abs() < 1e-5, "{name}: {value}");
        }
    }
}

/// What paths pass straight through is not part of the picture; light that they meet behind it is. Mitsuba
/// 3.9.1 has the same alpha for these materials.
#[test]
fn what_is_passed_through_is_transparent() {
    let mask = |opacity: f32| Mask::new(opacity, Box::new(Diffuse::new(Rgb::ONE)));
    for (bsdf, sky, hide_emitters, expected) in [
        (Box::new(Null) as Box<dyn Bsdf>, false, false, 0.0),
        (Box::new(Null), true, false, 1.0),
        (Box::new(Null), true, true, 0.0),
        (Box::new(mask(0.4)), false, false, 0.4),
        (Box::new(mask(0.4)), true, false, 1.0),
        (Box::new(mask(0.4)), true, true, 0.4),
    ] {
        let name = format!("{bsdf:?} {sky} {hide_emitters}");
        let emitters: Vec<Box<dyn Emitter>> =
            if sky { vec![Box::new(Constant::new(Rgb::ONE))] } else { Vec::new() };
        let wall = primitives::rectangle(DAffine3::IDENTITY, false).0;
        let objects = vec![object(Arc::new(wall), 0, None)];
        let scene = Scene::new(objects, vec![bsdf], emitters, sky.then_some(0)).expect("valid");
        let engine = engine(&scene, Backend::default());
        let settings = path(PathSettings { hide_emitters, ..PathSettings::default() });
        let (integrator, _) = build(&settings, &scene);
        let integrator = integrator.expect("makes a picture");
        let (sampler, mut tracer) = (Independent::new(5), Tracer::new(&scene, engine.as_ref()));
        let alphas = (0..10_000).map(|i| {
            let ray = Ray::new(Vec3A::new(0.1, 0.2, 3.0), Vec3A::NEG_Z);
            let mut numbers = PathSampler::new(&sampler, i, 0);
            f64::from(integrator.estimate(&mut tracer, &ray, &mut numbers).alpha)
        });
        Moments::of(alphas).has_mean(expected, 6).unwrap_or_else(|told| panic!("{name}: {told}"));
    }
}

/// From a point of the floor below a square of half side 1 at height 1 the free part of the hemisphere is
/// 1 − 0.554126: one minus the form factor 4A·atan(A)/π·… of a centred square, twice 0.277063.
#[test]
fn ambient_occlusion_is_one_minus_the_form_factor() {
    let at = |height: f64, scale: f64| {
        DAffine3::from_translation(DVec3::new(0.0, 0.0, height))
            * DAffine3::from_scale(DVec3::splat(scale))
    };
    let floor: Arc<dyn Shape> = Arc::new(primitives::rectangle(at(0.0, 1e-3), false).0);
    let roof: Arc<dyn Shape> = Arc::new(primitives::rectangle(at(1.0, 1.0), false).0);
    let scene = scene(vec![floor, roof], Box::new(Diffuse::new(Rgb::ONE)), 0.0);
    let engine = engine(&scene, Backend::default());
    let sampler = Independent::new(5);
    for (ray_length, expected) in [(f32::INFINITY, 1.0 - 0.554_126), (0.5, 1.0)] {
        let settings =
            IntegratorSettings::AmbientOcclusion(AmbientOcclusionSettings { ray_length });
        let (integrator, _) = build(&settings, &scene);
        let integrator = integrator.expect("makes a picture");
        let mut tracer = Tracer::new(&scene, engine.as_ref());
        let ray = Ray::new(Vec3A::new(0.0, 0.0, 0.5), Vec3A::NEG_Z);
        let values = (0..100_000).map(|i| {
            let mut numbers = PathSampler::new(&sampler, i, 0);
            f64::from(integrator.estimate(&mut tracer, &ray, &mut numbers).radiance.x)
        });
        Moments::of(values).has_mean(expected, 2).expect("the fraction that is free");
    }
}
