//! Environments by pictures: what each direction shows, and that directions are drawn with the density that
//! is claimed for them, for pictures of all shapes and contrasts.

mod support;

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{Affine2, DVec2, DVec3, Mat3A, Vec3A};
use support::meshes::engines;
use support::quadrature::SphereGrid;
use support::rooms::object;
use support::stats::{Moments, chi_squared};
use support::{corners, points};
use telamon::bsdf::{Bsdf, Diffuse};
use telamon::emitter::{Emitter, EnvironmentMap, Sight};
use telamon::integrator::{Integrator, MisHeuristic, Path, PathSettings, Strategy, Tracer};
use telamon::math::{Rgb, luminance};
use telamon::ray::Ray;
use telamon::sampler::{Independent, PathSampler};
use telamon::scene::Scene;
use telamon::shape::{Shape, primitives};
use telamon::texture::bitmap::{BitmapFilter, BitmapSettings, Encoding, Wrap};
use telamon::texture::image::Texels;
use telamon::texture::{Bitmap, Image};

const SAMPLES: u32 = 100_000;

fn map(width: u32, texels: Vec<f32>, to_world: Mat3A) -> EnvironmentMap {
    let height = texels.len() as u32 / (3 * width);
    let image = Image::new(width, height, 3, Texels::Float(texels)).expect("of this size");
    let settings = BitmapSettings {
        encoding: Encoding::Linear,
        filter: BitmapFilter::Bilinear,
        wrap: Wrap::Clamp,
        to_uv: Affine2::IDENTITY,
    };
    EnvironmentMap::new(Bitmap::new(Arc::new(image), settings), 2.0, to_world).expect("finite")
}

/// A rotation that keeps no axis, with a mirror.
fn oblique() -> Mat3A {
    Mat3A::from_axis_angle(glam::Vec3::new(1.0, 2.0, 3.0).normalize(), 0.7)
        * Mat3A::from_diagonal(glam::Vec3::new(-1.0, 1.0, 1.0))
}

/// Unrelated colours.
fn noise(width: u32, height: u32) -> Vec<f32> {
    points(9, 3 * width * height).map(|u| u.x).collect()
}

/// A dim sky in which one pixel of the sun is a million times as bright.
fn sun() -> Vec<f32> {
    let mut texels = vec![1.0; 3 * 16 * 9];
    texels[3 * (16 * 2 + 5)..][..3].fill(1e6);
    texels
}

/// Every other pixel black, also three of four around a place, and the pole.
fn holes() -> Vec<f32> {
    let bright = |i: usize| (i % 8 + 2 * (i / 8)) % 4 == 1 && i >= 8;
    (0..8 * 5).flat_map(|i| [f32::from(u8::from(bright(i))); 3]).collect()
}

fn maps() -> Vec<(&'static str, EnvironmentMap)> {
    vec![
        ("noise", map(7, noise(7, 5), oblique())),
        ("one row", map(5, noise(5, 1), oblique())),
        ("two rows", map(3, noise(3, 2), Mat3A::IDENTITY)),
        ("one column", map(1, noise(1, 6), oblique())),
        ("one pixel", map(1, vec![0.2, 0.5, 0.1], oblique())),
        ("sun", map(16, sun(), oblique())),
        ("holes", map(8, holes(), Mat3A::IDENTITY)),
    ]
}

fn sight(direction: Vec3A) -> Sight<'static> {
    Sight { from: DVec3::ZERO, direction, surface: None }
}

const GRID: SphereGrid = SphereGrid { rows: 10, columns: 20 };

#[test]
fn directions_follow_their_density() {
    let maps = maps();
    for (seed, (name, map)) in (1..).zip(&maps) {
        let mut counts = vec![0; GRID.cells()];
        for u in points(seed, SAMPLES) {
            let sample = map.sample_toward(DVec3::ZERO, u.as_dvec2()).expect("not black");
            counts[GRID.cell(sample.direction)] += 1;
        }
        let shares = GRID.integrals(2, |w| map.pdf_toward(&sight(w)).into());
        // Half a count in each cell, which the quadrature may be off by.
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-3, "{name}");
        let expected: Vec<f64> = shares.iter().map(|p| p * f64::from(SAMPLES)).collect();
        chi_squared(&counts, &expected, maps.len()).unwrap_or_else(|t| panic!("{name}: {t}"));
        let uniform = vec![f64::from(SAMPLES) / GRID.cells() as f64; GRID.cells()];
        assert!(*name == "one pixel" || chi_squared(&counts, &uniform, 1).is_err(), "{name}");
    }
}

/// The density that comes with a sample is the one that is asked for, to the bit, and weight and density make
/// the radiance; also where all numbers are 0 or nearly 1.
#[test]
fn both_densities_are_one() {
    for (name, map) in maps() {
        for u in points(21, 20_000).chain(corners()) {
            let Some(sample) = map.sample_toward(DVec3::ZERO, u.as_dvec2()) else {
                // A corner may be the centre of a black pixel.
                assert!(name == "holes" && corners().any(|c| c == u), "{name}: nothing for {u}");
                continue;
            };
            assert!((sample.direction.length() - 1.0).abs() < 1e-6, "{name}: {sample:?}");
            let sight = sight(sample.direction);
            assert_eq!(sample.pdf, map.pdf_toward(&sight), "{name}");
            let radiance = map.radiance(&sight);
            let off = (sample.weight * sample.pdf - radiance).abs();
            // A quotient and a product.
            assert!(off.cmple(radiance * 2e-7).all(), "{name}: {sample:?}, {radiance}");
        }
    }
}

/// The density follows the luminance but for the cosine, so weights have a mean square of at most 1.3 times that
/// of equal ones. It would be 16/9 for the sun if all directions of a cell were alike.
#[test]
fn weights_are_nearly_equal() {
    for (name, map) in maps() {
        let mean = |value: &dyn Fn(Vec3A) -> f64| GRID.integrals(2, value).iter().sum::<f64>();
        let total = mean(&|w| luminance(map.radiance(&sight(w))).into());
        let second = Moments::of(points(22, SAMPLES).map(|u| {
            let sample = map.sample_toward(DVec3::ZERO, u.as_dvec2()).expect("not black");
            (f64::from(luminance(sample.weight)) / total).powi(2)
        }));
        assert!(second.mean() < 1.3, "{name}: {second:?}");
    }
}

/// A last row that is chosen once in some ten million times, by numbers with 24 bits: not never, nor twice as
/// often as it should be.
#[test]
fn rows_that_are_hardly_ever_chosen_are_chosen() {
    let bright = 3e7;
    let map = map(1, [[bright; 3], [bright; 3], [0.0; 3], [0.0; 3], [1.0; 3]].concat(), oblique());
    let share = GRID.integrals(4, |w| {
        let dim = luminance(map.radiance(&sight(w))) <= 2.0;
        if dim { map.pdf_toward(&sight(w)).into() } else { 0.0 }
    });
    let share: f64 = share.iter().sum();
    // The last of all numbers with 24 bits, and what stands behind its end.
    let y = 1.0 - (-24f64).exp2();
    let hits = (0..1000).filter(|i| {
        let x = (12345.0 + f64::from(*i) / 1000.0) / 24f64.exp2();
        let sample = map.sample_toward(DVec3::ZERO, DVec2::new(x, y)).expect("not black");
        luminance(sample.weight * sample.pdf) <= 2.0
    });
    let expected = share * 24f64.exp2() * 1000.0;
    assert!(expected < 900.0 && (hits.count() as f64 - expected).abs() < 0.01 * expected + 2.0);
}

#[test]
fn black_maps_are_never_chosen() {
    let black = map(4, vec![0.0; 3 * 4 * 3], oblique());
    assert_eq!(black.power(), Some(0.0));
    assert!(black.sample_toward(DVec3::ZERO, DVec2::splat(0.5)).is_none());
    assert_eq!(black.radiance(&sight(Vec3A::Y)), Rgb::ZERO);
    assert_eq!(black.pdf_toward(&sight(Vec3A::Y)), 0.0);
}

/// What counts as 0 is neither seen nor drawn.
#[test]
fn pixels_below_zero_count_as_zero() {
    let texels = |low: f32| [[1.0; 9], [low; 9], [0.5; 9]].concat();
    let (negative, zero) = (map(3, texels(-2.0), oblique()), map(3, texels(0.0), oblique()));
    assert!(negative.has_negative() && !zero.has_negative());
    for u in points(23, 1000) {
        let [a, b] = [&negative, &zero].map(|m| m.sample_toward(DVec3::ZERO, u.as_dvec2()));
        let (a, b) = (a.expect("not black"), b.expect("not black"));
        assert_eq!((a.direction, a.weight, a.pdf), (b.direction, b.weight, b.pdf));
    }
}

#[test]
fn what_no_f32_can_hold_is_no_map() {
    let image = Image::new(1, 1, 1, Texels::Float(vec![1e30])).expect("one pixel");
    let settings = BitmapSettings {
        encoding: Encoding::Linear,
        filter: BitmapFilter::Nearest,
        wrap: Wrap::Repeat,
        to_uv: Affine2::IDENTITY,
    };
    let bitmap = Bitmap::new(Arc::new(image), settings);
    assert!(EnvironmentMap::new(bitmap.clone(), 1e9, Mat3A::IDENTITY).is_none());
    assert!(EnvironmentMap::new(bitmap, 1e8, Mat3A::IDENTITY).is_some());
}

/// A floor of albedo 1/2 under each map: by shadow rays, by directions and by both, E / 2π for the irradiance E.
#[test]
fn floors_get_what_the_sky_sends() {
    let maps = maps();
    let mut checks = Vec::new();
    for (name, map) in maps {
        let irradiance: f64 =
            GRID.integrals(2, |w| f64::from(map.radiance(&sight(w)).x * w.z.max(0.0))).iter().sum();
        let floor: Arc<dyn Shape> =
            Arc::new(primitives::rectangle(glam::DAffine3::IDENTITY, false).0);
        let grey: Box<dyn Bsdf> = Box::new(Diffuse::new(Rgb::splat(0.5)));
        let sky: Box<dyn Emitter> = Box::new(map);
        let scene = Scene::new(vec![object(floor, 0, None)], vec![grey], vec![sky], Some(0));
        let scene = scene.expect("valid");
        for strategy in [Strategy::Bsdf, Strategy::Emitter, Strategy::Mis(MisHeuristic::Power)] {
            // No direction in a thousand finds the sun.
            if (name, strategy) != ("sun", Strategy::Bsdf) {
                for (engine, values) in seen(&scene, strategy) {
                    let label = format!("{engine}, {name}, {strategy:?}");
                    checks.push((label, values, irradiance / (2.0 * PI)));
                }
            }
        }
    }
    for (label, values, expected) in &checks {
        values.has_mean(*expected, checks.len()).unwrap_or_else(|f| panic!("{label}: {f}"));
        assert!(values.has_mean(1.1 * expected, 1).is_err(), "{label}");
    }
}

/// Estimates of the floor's middle on every engine.
fn seen(scene: &Scene, strategy: Strategy) -> Vec<(String, Moments)> {
    let settings = PathSettings { strategy, max_depth: Some(2), ..PathSettings::default() };
    let integrator = Path::new(&settings, scene);
    let ray = Ray::new(Vec3A::Z, Vec3A::NEG_Z);
    let look = |engine: Box<dyn telamon::intersect::Intersector>| {
        let mut tracer = Tracer::new(scene, engine.as_ref());
        let sampler = Independent::new(7);
        let values = (0..20_000).map(|i| {
            let mut numbers = PathSampler::new(&sampler, i, 0);
            f64::from(integrator.estimate(&mut tracer, &ray, &mut numbers).radiance.x)
        });
        (engine.name(), Moments::of(values))
    };
    engines(&scene.shapes()).into_iter().map(look).collect()
}
