//! The density of a direction, as the shadow ray and as the scattered ray have it: from the same point, wherever that is.

use std::sync::Arc;

use glam::{Affine2, DAffine3, DMat3, DVec3, Mat3A, Vec3A};
use telamon::emitter::{
    Area, ChoicePolicy, Constant, Emitter, EmitterChoice, EnvironmentMap, LightOrigin,
    LightSampler, Receiver, Sight,
};
use telamon::math::{Frame, Rgb, luminance};
use telamon::ray::Ray;
use telamon::shape::{Cylinder, Disk, Shape, Sphere, TriangleMesh, primitives};
use telamon::texture::bitmap::{BitmapFilter, BitmapSettings, Encoding, Wrap};
use telamon::texture::image::Texels;
use telamon::texture::{Bitmap, Image};

use crate::ULP;
use crate::support::meshes::{engines, sphere_mesh};
use crate::support::points;

/// A floor and lights of each kind around it, about one unit large and away.
fn lit_floor(center: DVec3) -> (Arc<dyn Shape>, Vec<Arc<dyn Shape>>) {
    let at = |x: f64, y: f64, z: f64| center + DVec3::new(x, y, z);
    let place = |position: DVec3, size: f64| {
        DAffine3::from_translation(position) * DAffine3::from_scale(DVec3::splat(size))
    };
    let floor = Arc::new(primitives::rectangle(place(at(0.0, 0.0, -0.3), 0.2), false).0);
    let axes = Frame::from_normal(Vec3A::Y.into());
    // Seen from inside, and from outside in a cone.
    let around = Sphere::new(center.as_vec3a(), 3.0, axes, true);
    let ball = Sphere::new(at(1.0, 0.5, 0.6).as_vec3a(), 0.3, axes, false);
    let down = DMat3::from_diagonal(DVec3::new(0.4, 0.7, -1.0));
    let disk = DAffine3::from_mat3_translation(down, at(-0.5, 0.6, 1.0));
    let disk = Disk::new(disk, false).expect("not singular");
    let tube = [DVec3::X * 0.2, DVec3::Z * 0.2, DVec3::NEG_Y * 0.8];
    let tube = Cylinder::new(at(-1.0, 0.0, 0.5), tube, false).expect("an area");
    let square = primitives::rectangle(place(at(0.3, -1.0, 0.9), 0.3), true).0;
    let mesh: TriangleMesh = sphere_mesh(at(0.2, 1.3, 0.8), 0.2, 6, 9);
    let lights: Vec<Arc<dyn Shape>> = vec![
        Arc::new(around),
        Arc::new(ball),
        Arc::new(disk),
        Arc::new(tube),
        Arc::new(square),
        Arc::new(mesh),
    ];
    (floor, lights)
}

/// A rounding of the direction moves the point that is hit by up to its distance over the cosine there, and turns the
/// normal of a curved light by that over its radius, both less than ten to one here; the density is divided
/// by the cosine once more. Its own roundings are a few.
fn tolerance(cosine: f64) -> f64 {
    f64::from(ULP) * (16.0 + 20.0 / (cosine * cosine))
}

#[test]
fn both_ends_agree_on_the_density_of_a_direction() {
    for center in [DVec3::ZERO, DVec3::new(12_345.67, 54_321.9, -999.0)] {
        let (floor, lights) = lit_floor(center);
        let area = |shape: &Arc<dyn Shape>| -> Box<dyn Emitter> {
            Box::new(Area::new(Arc::clone(shape), Rgb::ONE).expect("an area"))
        };
        let emitters: Vec<_> = lights.iter().map(area).collect();
        let shapes: Vec<_> = lights.iter().chain([&floor]).cloned().collect();
        for engine in engines(&shapes) {
            let above = (center + DVec3::new(0.05, -0.03, 0.4)).as_vec3a();
            let ray = Ray::new(above, Vec3A::NEG_Z);
            let hit = engine.closest_hit(&ray).expect("the floor");
            let surface = shapes[hit.shape as usize].surface(&ray, &hit);
            let receiver = Receiver {
                position: surface.position,
                normal: Vec3A::Z,
                both_sides: false,
                is_diffuse: false,
            };
            for (policy, first) in [
                (ChoicePolicy::Bvh, true),
                (ChoicePolicy::Power, true),
                (ChoicePolicy::Ris, true),
                (ChoicePolicy::Ris, false),
            ] {
                let sampler = LightSampler::new(policy, &emitters, true);
                let candidates = sampler.candidates::<f32>(&receiver.into(), first);
                let candidates = candidates.and_then(|(all, here)| here.then_some(all));
                assert_eq!(candidates.is_some(), policy == ChoicePolicy::Ris && first);
                let mut seen = vec![0u32; lights.len()];
                let (mut noticed, mut told) = (0, 0);
                for (i, u) in points(421, 20_000).enumerate() {
                    let u = u.as_dvec2();
                    let sample = match candidates {
                        Some(all) => {
                            let light = i % all.count();
                            let from = receiver.into();
                            all.sample_each::<f32>(light, &emitters, &from, u.into(), true).lane(0)
                        }
                        None => sampler.choice().sample_toward(&emitters, &receiver, u),
                    };
                    let Some(s) = sample else { continue };
                    let LightOrigin::Surface(end) = s.origin else { unreachable!("area lights") };
                    let scattered = surface.spawn(s.direction);
                    let Some(hit) = engine.closest_hit(&scattered) else { continue };
                    let point = shapes[hit.shape as usize].surface(&scattered, &hit);
                    let cosine = f64::from(point.geometric_normal.dot(s.direction).abs());
                    // Not what is in front, nor a neighbour of the triangle, nor what is seen so flat that rounding
                    // decides on the place.
                    let turned = (point.geometric_normal - Vec3A::from(end.normal)).length();
                    let same = (point.position - end.point).length() < 1e-3 && turned < 1e-3;
                    // Next to an edge, an engine's ray, whose start is rounded, may meet the neighbour.
                    let same = same && point.near_edge.is_none();
                    if cosine < 1e-2 || !same || hit.shape as usize >= lights.len() {
                        continue;
                    }
                    let pdf = |from: DVec3, first: bool| {
                        let receiver = Receiver { position: from, ..receiver };
                        let surface = Some((&hit, &point));
                        let sight = Sight { from, direction: s.direction, surface };
                        let light = hit.shape as usize;
                        sampler.pdf_toward(&emitters, light, &receiver, first, &sight)
                    };
                    let off = |pdf: f32| f64::from(pdf / s.pdf - 1.0).abs();
                    let here = off(pdf(surface.position, first));
                    assert!(
                        here <= tolerance(cosine),
                        "{}, {policy:?}, {} at {center}: {here} at {cosine}",
                        engine.name(),
                        lights[hit.shape as usize].kind(),
                    );
                    seen[hit.shape as usize] += 1;
                    let beside = pdf(surface.position + DVec3::Z * 1e-2, first);
                    noticed += usize::from(off(beside) > 1e-3);
                    // By the rule of the other surfaces of a path.
                    told += usize::from(off(pdf(surface.position, !first)) > 0.1);
                }
                // Far away, all of a mesh is next to its edges.
                let counts = |kind: &str| center == DVec3::ZERO || kind != "TriangleMesh";
                let enough = |(n, light): (&u32, &Arc<dyn Shape>)| *n > 30 || !counts(light.kind());
                let case = format!("{policy:?} at {center}");
                assert!(seen.iter().zip(&lights).all(enough), "{case}: {seen:?}");
                assert!(noticed > 4_000, "{case}: densities of another point are not told apart");
                let two_rules = policy == ChoicePolicy::Ris;
                assert_eq!(told > 4_000, two_rules, "{case}: {told} tell the rules apart");
            }
        }
    }
}

/// A sky with a sun of one pixel, 10⁵ times as bright as the rest, and a black part.
fn sunny(to_world: Mat3A) -> EnvironmentMap {
    const SIZE: [u32; 2] = [64, 32];
    let pixel = |i: u32| match (i % SIZE[0], i / SIZE[0]) {
        (40, 5) => Rgb::new(1e5, 9e4, 7e4),
        (_, 24..) => Rgb::ZERO,
        (x, y) => Rgb::new(0.3, 0.5, 0.9) * (1.0 + 0.2 * (x as f32 * 0.3).sin() + y as f32 * 0.01),
    };
    let texels = Texels::Float((0..SIZE[0] * SIZE[1]).flat_map(|i| pixel(i).to_array()).collect());
    let image = Image::new(SIZE[0], SIZE[1], 3, texels).expect("as many as there are");
    let settings = BitmapSettings {
        filter: BitmapFilter::Bilinear,
        wrap: Wrap::Repeat,
        to_uv: Affine2::IDENTITY,
        encoding: Encoding::Linear,
    };
    EnvironmentMap::new(Bitmap::new(Arc::new(image), settings), 2.0, to_world).expect("finite")
}

/// An environment that stands in the scene as this says.
type MakeSky = fn(Mat3A) -> Box<dyn Emitter>;

/// What a shadow ray is sent to outside of the scene has the density that a scattered ray of the same direction finds
/// when it leaves, alone and beside area lights, over which the choice goes: the same function of the same 32-bit
/// direction, so no more than the roundings of the products with the choice's probability apart, two on each side, and
/// one of their quotient. The radiance that is weighted with it is that which the scattered ray sees.
#[test]
fn both_ends_agree_on_the_density_of_an_environment() {
    let turn = Mat3A::from_rotation_y(0.7) * Mat3A::from_rotation_x(0.4);
    let skies: [(&str, MakeSky); 2] = [
        ("constant", |_| Box::new(Constant::new(Rgb::new(0.2, 0.5, 1.0)))),
        ("picture", |turn| Box::new(sunny(turn))),
    ];
    for (name, sky) in skies {
        for center in [DVec3::ZERO, DVec3::new(12_345.67, 54_321.9, -999.0)] {
            let (floor, lights) = lit_floor(center);
            // All but the sphere around it all.
            for lights in [&lights[..0], &lights[1..]] {
                let mut emitters: Vec<Box<dyn Emitter>> = vec![sky(turn)];
                emitters.extend(lights.iter().map(|shape| -> Box<dyn Emitter> {
                    Box::new(Area::new(Arc::clone(shape), Rgb::ONE).expect("an area"))
                }));
                let shapes: Vec<_> = lights.iter().chain([&floor]).cloned().collect();
                for engine in engines(&shapes) {
                    environment_densities(name, engine.as_ref(), &shapes, &emitters, center);
                }
            }
        }
    }
}

fn environment_densities(
    name: &str,
    engine: &dyn telamon::intersect::Intersector,
    shapes: &[Arc<dyn Shape>],
    emitters: &[Box<dyn Emitter>],
    center: DVec3,
) {
    let above = (center + DVec3::new(0.05, -0.03, 0.4)).as_vec3a();
    let ray = Ray::new(above, Vec3A::NEG_Z);
    let hit = engine.closest_hit(&ray).expect("the floor");
    let surface = shapes[hit.shape as usize].surface(&ray, &hit);
    for both_sides in [false, true] {
        let receiver =
            Receiver { position: surface.position, normal: Vec3A::Z, both_sides, is_diffuse: true };
        for policy in [ChoicePolicy::Bvh, ChoicePolicy::Power] {
            let case = || format!("{name}, {}, {policy:?}, at {center}", engine.name());
            let choice = EmitterChoice::new(policy, emitters);
            let (mut seen, mut noticed) = (0, 0);
            for u in points(431, 20_000) {
                let sample = choice.sample_toward(emitters, &receiver, u.as_dvec2());
                let Some(s) = sample.filter(|s| matches!(s.origin, LightOrigin::Infinity)) else {
                    continue;
                };
                let shadow = s.shadow_ray(&surface).expect("to the side of the light");
                let scattered = surface.spawn(s.direction);
                assert_eq!(shadow.direction, scattered.direction, "{}", case());
                let leaves = engine.closest_hit(&scattered).is_none();
                assert_eq!(leaves, !engine.occluded(&shadow), "{}: {shadow:?}", case());
                let along = |direction| Sight { from: surface.position, direction, surface: None };
                let sight = along(scattered.direction);
                let pdf = choice.pdf_toward(emitters, 0, &receiver, &sight);
                let off = f64::from(pdf / s.pdf - 1.0).abs();
                assert!(off <= 5.0 * f64::from(ULP), "{}: {} and {pdf}", case(), s.pdf);
                // Another product, and the rounding of its quotient by the density.
                let sees = emitters[0].radiance(&sight);
                let weighted = luminance(s.weight) * s.pdf;
                let off = f64::from(weighted / luminance(sees) - 1.0).abs();
                assert!(off <= 16.0 * f64::from(ULP), "{}: {weighted} of {sees}", case());
                // The density of a direction a hundredth beside it, and without the choice.
                let beside = along((s.direction + Vec3A::new(7e-3, 5e-3, 5e-3)).normalize());
                let wrong = choice.pdf_toward(emitters, 0, &receiver, &beside);
                let alone = emitters[0].pdf_toward(&sight);
                let told = |pdf: f32| f64::from(pdf / s.pdf - 1.0).abs() > 1e-4;
                let other = if emitters.len() > 1 { told(alone) } else { told(wrong) };
                noticed += usize::from(other);
                seen += 1;
            }
            assert!(seen > 2_000, "{}: {seen}", case());
            let can_fail = name == "picture" || emitters.len() > 1;
            assert!(!can_fail || noticed > seen / 2, "{}: {noticed} of {seen}", case());
        }
    }
}
