//! The choice among lights, many or few: every policy gives the same picture, none leaves out what can be of use, and the
//! densities of the choice are those of its samples.

mod support;

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{Affine2, DAffine3, DVec2, DVec3, Mat3A, Vec3A};
use support::meshes::{engines, sphere_mesh};
use support::points_3d;
use support::rays::trace;
use support::rooms::{NO_ROULETTE, closed_cube, estimates, furnace_radiance, object, scene};
use support::stats::{Moments, chi_squared, significance_each, welch};
use telamon::bsdf::conductor::Metal;
use telamon::bsdf::microfacet::{Distribution, Roughness};
use telamon::bsdf::{Bsdf, Diffuse, RoughConductor, RoughDielectric, TwoSided};
use telamon::emitter::spot::SpotSettings;
use telamon::emitter::{
    Area, ChoicePolicy, Constant, Directional, Emitter, EmitterChoice, EnvironmentMap, LightOrigin,
    Point, Receiver, Sight, Spot,
};
use telamon::integrator::{IntegratorSettings, PathSettings, Strategy};
use telamon::math::{Frame, Rgb};
use telamon::property::Named;
use telamon::ray::Ray;
use telamon::scene::{Object, Scene};
use telamon::shape::{Disk, Shape, Sphere, TriangleMesh, primitives};
use telamon::texture::bitmap::{BitmapFilter, BitmapSettings, Encoding, Wrap};
use telamon::texture::image::Texels;
use telamon::texture::{Bitmap, Checkerboard, Image, Texture, Textured};

const POLICIES: [ChoicePolicy; 4] =
    [ChoicePolicy::Uniform, ChoicePolicy::Power, ChoicePolicy::Bvh, ChoicePolicy::Ris];

/// A field of lights between the heights 0.3 and 1.3 over the square from (-2, -2) to (2, 2).
struct Field {
    lamps: Vec<(Arc<dyn Shape>, Box<dyn Emitter>)>,
    others: Vec<Box<dyn Emitter>>,
}

/// Triangles of one mesh that face all ways, and as many spheres, disks, points and spots.
fn field(count: usize) -> Field {
    let place = |u: Vec3A| Vec3A::new(4.0 * u.x - 2.0, 4.0 * u.y - 2.0, 0.3 + u.z);
    let of = |seed: u64| points_3d(seed, count as u32).collect::<Vec<_>>();
    let (places, turns, colors) = (of(1), of(2), of(3));
    let power = |i: usize| colors[i] * (2.0 * turns[i].z).exp();
    let mut field = Field { lamps: Vec::new(), others: Vec::new() };
    let axis = |i: usize| (turns[i] - 0.5).normalize();
    let corners = (0..count).flat_map(|i| {
        let Frame { s, t, .. } = Frame::from_normal(axis(i).into());
        [s, t, -s - t].map(|side| place(places[i]) + 0.02 * Vec3A::from(side))
    });
    let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let (mesh, _) =
        TriangleMesh::new(corners.collect(), triangles, Vec::new(), Vec::new()).expect("valid");
    let mesh: Arc<dyn Shape> = Arc::new(mesh);
    let colors_of_board = [3.0, 40.0].map(|c| Textured::Uniform(Vec3A::splat(c)));
    let board: Arc<dyn Texture> = Arc::new(Checkerboard::new(colors_of_board, Affine2::IDENTITY));
    let light = Area::new(Arc::clone(&mesh), Textured::Varying(board)).expect("an area");
    field.lamps.push((mesh, Box::new(light)));
    for i in 0..count / 4 {
        let from = place(places[(7 * i + 3) % count]);
        let shape: Arc<dyn Shape> = match i % 2 {
            0 => Arc::new(Sphere::new(from, 0.01, Frame::from_normal(Vec3A::Z.into()), false)),
            _ => Arc::new(
                Disk::new(
                    DAffine3::from_translation(from.as_dvec3())
                        * DAffine3::from_mat3(
                            glam::DMat3::from_axis_angle(axis(i).as_dvec3(), 2.0) * 0.02,
                        ),
                    false,
                )
                .expect("an area"),
            ),
        };
        let light = Area::new(Arc::clone(&shape), 20.0 * power(i)).expect("an area");
        field.lamps.push((shape, Box::new(light)));
        field.others.push(if i % 3 == 0 {
            Box::new(Point::new(from + 0.1, 0.02 * power(i)))
        } else {
            let z = axis(i + 1);
            let Frame { s, t, .. } = Frame::from_normal(z.into());
            let cutoff_angle = [0.1, 0.7, 0.5 * PI][i % 3];
            Box::new(Spot::new(SpotSettings {
                position: from + 0.1,
                axes: Mat3A::from_cols(s.into(), t.into(), z),
                intensity: 0.1 * power(i),
                cutoff_angle,
                beam_width: cutoff_angle * f64::from(turns[i].x),
                texture: Textured::Uniform(Vec3A::ONE),
            }))
        });
    }
    field
}

impl Field {
    /// Over a floor of this material, with more emitters. No wall is so near to a lamp that its noise hides all else.
    fn scene(self, bsdf: Box<dyn Bsdf>, more: Vec<Box<dyn Emitter>>, sky: bool) -> Scene {
        let black: Box<dyn Bsdf> = Box::new(Diffuse::new(Rgb::ZERO));
        let floor = primitives::rectangle(DAffine3::from_scale(DVec3::splat(2.0)), false).0;
        let mut objects = vec![object(Arc::new(floor), 0, None)];
        let mut emitters: Vec<Box<dyn Emitter>> = Vec::new();
        for (shape, light) in self.lamps {
            objects.push(Object { emitter: Some(emitters.len()), ..object(shape, 1, None) });
            emitters.push(light);
        }
        emitters.extend(self.others);
        emitters.extend(more);
        let environment = sky.then(|| emitters.len() - 1);
        Scene::new(objects, vec![bsdf, black], emitters, environment).expect("valid")
    }
}

fn grey() -> Box<dyn Bsdf> {
    let grey = Box::new(Diffuse::new(Rgb::splat(0.6)));
    Box::new(TwoSided::new(grey, None).expect("neither side transmits"))
}

fn glass() -> Box<dyn Bsdf> {
    let roughness = Roughness::new(Distribution::Ggx, 1.0);
    Box::new(RoughDielectric::new(1.3, roughness, Rgb::ONE, Rgb::ONE).expect("refracts"))
}

fn outside() -> Vec<Box<dyn Emitter>> {
    vec![
        Box::new(Directional::new(Vec3A::new(0.6, 0.0, -0.8), Rgb::splat(0.5))),
        Box::new(Constant::new(Rgb::splat(0.3))),
    ]
}

/// Light that arrives in the middle of the field, by each policy, on both engines. A scene whose lights are 15 %
/// stronger is told from it.
#[test]
fn policies_agree() {
    let scenes: [(&str, f32, &dyn Fn() -> Scene); 3] = [
        ("matt", 0.5, &|| field(400).scene(grey(), Vec::new(), false)),
        // Seen from the side where the lamps are not.
        ("glass", -0.5, &|| field(40).scene(glass(), Vec::new(), false)),
        ("sun and sky", 0.5, &|| field(100).scene(grey(), outside(), true)),
    ];
    let (mut noticed, mut compared) = (0, 0);
    for (name, height, scene) in &scenes {
        let from = Vec3A::new(0.1, -0.2, *height);
        let scene = scene();
        for engine in engines(&scene.shapes()) {
            // Of so many lights, `ris` chooses as `bvh`.
            let few = [ChoicePolicy::Uniform, ChoicePolicy::Power, ChoicePolicy::Bvh];
            let means = few.map(|emitter_choice| {
                // Which lamps are in sight no policy decides.
                let hidden = PathSettings { hide_emitters: true, ..PathSettings::default() };
                let settings = PathSettings { emitter_choice, max_depth: Some(3), ..hidden };
                let settings = IntegratorSettings::Path(settings);
                Moments::of(estimates(&scene, engine.as_ref(), &settings, from, 400_000))
            });
            let [uniform, power, bvh] = &means;
            for (other, policy) in [(uniform, "uniform"), (power, "power")] {
                let p_value = welch(bvh, other, 0.0);
                let figures = format!("{bvh:?} {other:?}");
                let level = significance_each(4 * scenes.len());
                assert!(
                    p_value >= level,
                    "{name}, {}, {policy}: {p_value} {figures}",
                    engine.name()
                );
                compared += 1;
                noticed += usize::from(bvh.has_mean(1.15 * other.mean(), 1).is_err());
            }
        }
    }
    assert_eq!(noticed, compared, "15 % more light would not be noticed");
}

/// A box of glossy and matt walls, open to the front, with the first so many lights of all kinds; the last two are a sun
/// and a sky that is brighter on one side.
fn lit_room(count: usize, sun_and_sky: bool) -> Scene {
    let at = |x: f64, y: f64, z: f64| DAffine3::from_translation(DVec3::new(x, y, z));
    let place = |x, y, z, size: f64| at(x, y, z) * DAffine3::from_scale(DVec3::splat(size));
    let down = DAffine3::from_rotation_x(PI);
    let shapes: Vec<Arc<dyn Shape>> = vec![
        Arc::new(sphere_mesh(DVec3::new(-0.8, 0.3, 0.5), 0.2, 4, 6)),
        Arc::new(
            primitives::rectangle(at(0.2, 0.0, 1.6) * down * place(0.0, 0.0, 0.0, 0.3), false).0,
        ),
        Arc::new(Sphere::new(
            Vec3A::new(0.7, -0.5, 0.3),
            0.1,
            Frame::from_normal(Vec3A::Z.into()),
            false,
        )),
    ];
    let wall = at(0.0, 1.2, 1.0) * DAffine3::from_rotation_x(0.5 * PI);
    let mut objects = vec![
        object(Arc::new(primitives::rectangle(place(0.0, 0.0, 0.0, 1.5), false).0), 0, None),
        object(Arc::new(primitives::rectangle(wall, false).0), 1, None),
    ];
    let mut emitters: Vec<Box<dyn Emitter>> = Vec::new();
    for (shape, power) in shapes.into_iter().zip([4.0, 2.0, 30.0]).take(count) {
        let area = Area::new(Arc::clone(&shape), Rgb::splat(power)).expect("an area");
        objects.push(object(shape, 1, Some(emitters.len())));
        emitters.push(Box::new(area));
    }
    if count > 3 {
        emitters.push(Box::new(Point::new(Vec3A::new(-0.5, -0.9, 0.8), Rgb::splat(0.4))));
    }
    if sun_and_sky {
        emitters.push(Box::new(Directional::new(Vec3A::new(0.3, 0.5, -0.8), Rgb::splat(0.5))));
        let pixels = (0..8 * 4).flat_map(|i| [0.1 + f32::from(i % 8 == 2) * 3.0; 3]);
        let image = Image::new(8, 4, 3, Texels::Float(pixels.collect())).expect("as many");
        let settings = BitmapSettings {
            filter: BitmapFilter::Bilinear,
            wrap: Wrap::Repeat,
            to_uv: Affine2::IDENTITY,
            encoding: Encoding::Linear,
        };
        let picture = Bitmap::new(Arc::new(image), settings);
        let upright = Mat3A::from_rotation_x(0.5 * std::f32::consts::PI);
        emitters.push(Box::new(EnvironmentMap::new(picture, 1.0, upright).expect("finite")));
    }
    let sky = sun_and_sky.then(|| emitters.len() - 1);
    let glossy = RoughConductor::new(
        Metal::new(None, Rgb::splat(0.8)),
        Roughness::new(Distribution::Ggx, 0.3),
    );
    let glossy = Box::new(TwoSided::new(Box::new(glossy), None).expect("does not transmit"));
    Scene::new(objects, vec![glossy, grey()], emitters, sky).expect("valid")
}

/// A candidate from each of few lights gives the picture of a choice by power, at the first surface and deeper, alone and
/// beside directions. 20 % more light would be noticed.
#[test]
fn candidates_agree_with_choices() {
    let rooms = [(2, false), (3, false), (4, false), (1, true), (3, true)];
    let strategies = [Strategy::ALL[0].1, Strategy::Emitter];
    let (mut noticed, mut compared) = (0, 0);
    for (count, sun_and_sky) in rooms {
        let scene = lit_room(count, sun_and_sky);
        let engine = &engines(&scene.shapes())[0];
        for strategy in strategies {
            let of = |emitter_choice, emitter_samples, bsdf_samples, count| {
                let path = PathSettings { hide_emitters: true, ..PathSettings::default() };
                let path = PathSettings { strategy, max_depth: Some(4), emitter_choice, ..path };
                let path = PathSettings { emitter_samples, bsdf_samples, ..path };
                let from = Vec3A::new(0.1, -0.6, 0.7);
                let settings = IntegratorSettings::Path(path);
                estimates(&scene, engine.as_ref(), &settings, from, count)
            };
            // Other numbers for the reference.
            let reference = Moments::of(of(ChoicePolicy::Power, 1, 1, 100_000).split_off(50_000));
            let counts: &[_] =
                if strategy == Strategy::Emitter { &[(1, 1)] } else { &[(1, 1), (2, 2)] };
            for &(emitter_samples, bsdf_samples) in counts {
                let resampled =
                    Moments::of(of(ChoicePolicy::Ris, emitter_samples, bsdf_samples, 50_000));
                let p_value = welch(&resampled, &reference, 0.0);
                let case = format!("{count} lamps, sun and sky: {sun_and_sky}, {strategy:?}");
                let level = significance_each(3 * rooms.len());
                assert!(p_value >= level, "{case}: {p_value} {resampled:?} {reference:?}");
                compared += 1;
                noticed += usize::from(reference.has_mean(1.2 * resampled.mean(), 1).is_err());
            }
        }
    }
    assert_eq!(noticed, compared, "20 % more light would not be noticed");
}

/// A closed room that emits, and lamps of the same radiance in it: weights that do not sum to one would show as more light
/// or less, whether all lights are asked for candidates or one is chosen.
#[test]
fn weights_of_candidates_sum_to_one() {
    const ALBEDO: f32 = 0.5;
    const DEPTH: u32 = 4;
    for lamps in [1, 2, 4] {
        let ball = |i: usize| -> Arc<dyn Shape> {
            let center = Vec3A::new(0.5, -0.2, 0.1) - 0.35 * i as f32 * Vec3A::new(1.0, 0.2, -1.0);
            Arc::new(Sphere::new(center, 0.15, Frame::from_normal(Vec3A::Z.into()), false))
        };
        let shapes = std::iter::once(closed_cube()).chain((0..lamps).map(ball)).collect();
        let scene = scene(shapes, Box::new(Diffuse::new(Rgb::splat(ALBEDO))), 1.0);
        let path = PathSettings { roulette: NO_ROULETTE, ..PathSettings::default() };
        let settings = PathSettings { max_depth: Some(DEPTH), ..path }.into();
        let engine = &engines(&scene.shapes())[0];
        let from = Vec3A::new(-0.3, 0.6, -0.6);
        let found = Moments::of(estimates(&scene, engine.as_ref(), &settings, from, 60_000));
        let expected = furnace_radiance(ALBEDO, DEPTH);
        found.has_mean(expected, 3).unwrap_or_else(|figures| panic!("{lamps} lamps: {figures}"));
        assert!(found.has_mean(1.02 * expected, 1).is_err(), "{lamps} lamps: {found:?}");
    }
}

/// Receivers all over the field, some of them on a lamp or almost.
fn receivers(field: &[Box<dyn Emitter>]) -> Vec<Receiver> {
    let numbers = points_3d(31, 300).zip(points_3d(32, 300)).enumerate();
    let receiver = |(i, (a, b)): (usize, (Vec3A, Vec3A))| {
        let beside = field[i % field.len()].parts().first().map(|part| Vec3A::from(part.space.min));
        let position = match (i % 3, beside) {
            (0, Some(place)) => place + 1e-5 * (a - 0.5),
            _ => a * Vec3A::new(4.0, 4.0, 2.0) - Vec3A::new(2.0, 2.0, 0.0),
        };
        let both_sides = i % 2 == 0;
        Receiver {
            position: position.as_dvec3(),
            normal: (b - 0.5).normalize(),
            both_sides,
            is_diffuse: i % 4 < 2,
        }
    };
    numbers.map(receiver).collect()
}

/// A sample that brings light has an emitter that can be chosen, whichever emitter was asked.
#[test]
fn what_can_be_of_use_can_be_chosen() {
    let Field { lamps, mut others } = field(200);
    let mut emitters: Vec<_> = lamps.into_iter().map(|(_, light)| light).collect();
    emitters.append(&mut others);
    emitters.extend(outside());
    for policy in POLICIES {
        let choice = EmitterChoice::new(policy, &emitters);
        let mut found = 0;
        for (seed, receiver) in (41..).zip(receivers(&emitters)) {
            let total: f64 = (0..emitters.len()).map(|i| choice.probability(&receiver, i)).sum();
            assert!(total <= 1.0 + 1e-12, "{policy:?}: {total}");
            // Light from outside is always a choice.
            assert!(total > 0.6, "{policy:?}: {total}");
            for (index, emitter) in emitters.iter().enumerate() {
                let mut samples = points_3d(seed, 8).filter_map(|u| {
                    emitter.sample_toward(receiver.position, u.truncate().as_dvec2())
                });
                let of_use = samples.any(|s| {
                    let above = s.direction.dot(receiver.normal) > 1e-6;
                    s.weight != Rgb::ZERO && (receiver.both_sides || above)
                });
                let probability = choice.probability(&receiver, index);
                assert!(!of_use || probability > 0.0, "{policy:?}: {emitter:?} for {receiver:?}");
                found += usize::from(of_use);
            }
        }
        assert!(found > 10_000, "{found}");
    }
}

/// The density of a direction that the choice returns is the one that is asked for when the lamp is hit.
#[test]
fn both_densities_of_a_choice_are_one() {
    let Field { lamps, others: _ } = field(200);
    let (shapes, emitters): (Vec<_>, Vec<_>) = lamps.into_iter().unzip();
    for policy in POLICIES {
        let choice = EmitterChoice::new(policy, &emitters);
        let mut seen = 0;
        for (seed, receiver) in
            (51..).zip(receivers(&emitters).into_iter().filter(|r| r.both_sides))
        {
            for u in points_3d(seed, 20).map(|u| u.truncate().as_dvec2()) {
                let chosen = choice.sample(&receiver, u.x);
                let sample = choice.sample_toward(&emitters, &receiver, u);
                let (Some(chosen), Some(sample)) = (chosen, sample) else { continue };
                let shape = shapes[chosen.emitter].as_ref();
                let ray = Ray::from_exact(receiver.position, sample.direction);
                let Some(hit) = trace(shape, &ray) else { continue };
                let point = shape.surface(&ray, &hit);
                let LightOrigin::Surface(end) = sample.origin else { continue };
                // Another triangle of the same mesh may be in front.
                if (end.point - point.position).length() > 1e-3 {
                    continue;
                }
                let cosine = f64::from(point.geometric_normal.dot(sample.direction).abs());
                let (from, direction) = (receiver.position, sample.direction);
                let sight = Sight { from, direction, surface: Some((&hit, &point)) };
                let pdf = choice.pdf_toward(&emitters, chosen.emitter, &receiver, &sight);
                // Lamps of 0.02 seen from up to 5 units: a rounding of 2⁻²⁴ of the direction moves the point by up
                // to 2e-5 of its distance over the cosine, next to a lamp by as much of the place's own size.
                let distance = f64::from(hit.t);
                let tolerance = 1e-4 + 4e-6 / cosine / cosine / distance.min(1.0);
                let off = f64::from(pdf / sample.pdf - 1.0).abs();
                assert!(off <= tolerance, "{policy:?}: {pdf}, {sample:?} at {distance}, {cosine}");
                seen += 1;
            }
        }
        assert!(seen > 1000, "{seen}");
    }
}

/// What a tree takes and how often, with lights outside; more often than it says would be noticed.
#[test]
fn choices_follow_their_probabilities() {
    let Field { lamps, mut others } = field(60);
    let mut emitters: Vec<_> = lamps.into_iter().map(|(_, light)| light).collect();
    emitters.append(&mut others);
    emitters.extend(outside());
    let choice = EmitterChoice::new(ChoicePolicy::Bvh, &emitters);
    let receivers = receivers(&emitters);
    let receivers = &receivers[..20];
    for (seed, receiver) in (61..).zip(receivers) {
        const SAMPLES: u32 = 200_000;
        let mut counts = vec![0; emitters.len() + 1];
        for u in points_3d(seed, SAMPLES) {
            let chosen = choice.sample(receiver, u.x.into());
            counts[chosen.map_or(emitters.len(), |c| c.emitter)] += 1;
        }
        let mut expected: Vec<_> =
            (0..emitters.len()).map(|i| choice.probability(receiver, i)).collect();
        // A sum of 61 shares that is 1 may round below.
        expected.push((1.0 - expected.iter().sum::<f64>()).max(1e-12));
        expected.iter_mut().for_each(|p| *p *= f64::from(SAMPLES));
        chi_squared(&counts, &expected, receivers.len()).unwrap_or_else(|table| panic!("{table}"));
        let last = emitters.len() - 1;
        // Sun, sky and the tree: a third each.
        assert!((choice.probability(receiver, last) - 1.0 / 3.0).abs() < 1e-12);
        expected[last] *= 1.05;
        assert!(chi_squared(&counts, &expected, 1).is_err());
    }
}

/// A receiver that is no surface of its own kind: lights right at it, in a lamp's plane, at the end of all numbers.
#[test]
fn no_place_is_too_odd() {
    let Field { lamps, mut others } = field(60);
    let mut emitters: Vec<_> = lamps.into_iter().map(|(_, light)| light).collect();
    emitters.append(&mut others);
    let choice = EmitterChoice::new(ChoicePolicy::Bvh, &emitters);
    for position in [0.0, 1e-30, 1.0, 1e10, 1e18].map(DVec3::splat) {
        for normal in [Vec3A::X, Vec3A::NEG_Z] {
            let receiver = Receiver { position, normal, both_sides: true, is_diffuse: false };
            let total: f64 = (0..emitters.len()).map(|i| choice.probability(&receiver, i)).sum();
            assert!((0.0..=1.0 + 1e-12).contains(&total), "{position}: {total}");
            for u in support::points(71, 100).map(|u| u.as_dvec2()).chain([DVec2::ZERO]) {
                if let Some(s) = choice.sample_toward(&emitters, &receiver, u) {
                    assert!(s.weight.is_finite() && s.pdf.is_finite(), "{position}: {s:?}");
                }
            }
        }
    }
}
