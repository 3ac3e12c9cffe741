//! Lights: what they send to a surface against closed forms, and their two densities, the one that
//! comes with a sample and the one that is asked for, against each other.

mod support;

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::sync::Arc;

use glam::{Affine2, DVec2, DVec3, Vec2, Vec3A};
use support::lights::{Light, emitters, lambert, lights, sphere, square, triangle};
use support::rays::trace;
use support::stats::{Moments, chi_squared, significance_each, welch};
use support::{corners, plugin_names, points};
use telamon::emitter::{
    Area, ChoicePolicy, Chosen, Constant, Emitter, EmitterChoice, EmitterSample, Point, Receiver,
    Sight,
};
use telamon::load::plugins::{Category, Plugin, supported};
use telamon::math::{Frame, warp};
use telamon::ray::{Hit, Ray};
use telamon::shape::{Shape, TriangleMesh};
use telamon::texture::{Checkerboard, Texture, Textured};

const SAMPLES: u32 = 100_000;

/// Irradiance at `from` on a surface that faces `normal`, one estimate for each sample.
fn irradiance(light: &dyn Emitter, from: Vec3A, normal: Vec3A, seed: u64) -> Moments {
    Moments::of(points(seed, SAMPLES).map(|u| {
        light.sample_toward(from.as_dvec3(), u.as_dvec2()).map_or(0.0, |s| {
            let cosine = s.direction.as_dvec3().dot(normal.as_dvec3()).max(0.0);
            f64::from(s.weight.x) * cosine
        })
    }))
}

/// Every light of the table, with the radiance 1, seen from `from` by a surface facing `normal`.
#[test]
fn irradiance_is_what_the_closed_forms_say() {
    let lights = lights();
    for (seed, light) in (1..).zip(&lights) {
        let Light { name, shape, from, normal, irradiance: expected, .. } = light;
        let area = Area::new(Arc::clone(shape), Vec3A::ONE).expect("has an area");
        let estimate = irradiance(&area, *from, *normal, seed);
        estimate
            .has_mean(*expected, lights.len())
            .unwrap_or_else(|figures| panic!("{name}: {figures}"));
        // 5 % more is noticed, or the estimate is too noisy to be called a test.
        assert!(estimate.has_mean(1.05 * expected, 1).is_err(), "{name}: {estimate:?}");
    }
}

/// Five triangles somewhere above the floor, each seen from the floor.
#[test]
fn triangles_agree_with_lambert() {
    let corners: Vec<Vec3A> =
        support::points_3d(301, 15).map(|u| u * 2.0 - Vec3A::new(1.0, 1.0, -0.2)).collect();
    for (seed, corners) in (302..).zip(corners.chunks(3)) {
        let mut corners = [corners[0], corners[1], corners[2]];
        if (corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(corners[0]) > 0.0 {
            corners.swap(1, 2);
        }
        let expected = lambert(&corners.map(|c| c.as_dvec3()), DVec3::ZERO, DVec3::Z);
        let area = Area::new(triangle(corners), Vec3A::ONE).expect("has an area");
        let estimate = irradiance(&area, Vec3A::ZERO, Vec3A::Z, seed);
        estimate.has_mean(expected, 5).unwrap_or_else(|figures| panic!("{corners:?}: {figures}"));
        assert!(estimate.has_mean(1.02 * expected, 1).is_err(), "{corners:?}: {estimate:?}");
    }
}

/// From above, a sphere of any apparent size: π (r/d)². All its directions have the same density, so
/// this one needs few samples.
#[test]
fn spheres_of_all_sizes_send_what_they_should() {
    let sizes = (1..=7).map(|k| 10f64.powi(-k));
    for (seed, size) in (401..).zip(sizes) {
        for (radius, distance) in [(size as f32, 1.0), (1.0, (1.0 / size) as f32)] {
            let ratio = f64::from(radius) / f64::from(distance);
            let light =
                Area::new(sphere(Vec3A::Z * distance, radius), Vec3A::ONE).expect("has an area");
            irradiance(&light, Vec3A::ZERO, Vec3A::Z, seed)
                .has_mean(PI * ratio * ratio, 14)
                .unwrap_or_else(|figures| panic!("{radius} at {distance}: {figures}"));
            let s = light.sample_toward(DVec3::ZERO, DVec2::splat(0.5)).expect("seen");
            // 1 − cos = s²/(1 + c); six roundings.
            let solid_angle = 2.0 * PI * ratio * ratio / (1.0 + (1.0 - ratio * ratio).sqrt());
            let relative = f64::from(s.weight.x) / solid_angle - 1.0;
            assert!(relative.abs() < 4e-7, "{radius} at {distance}: off by {relative}");
            assert!((f64::from(s.pdf) * solid_angle - 1.0).abs() < 4e-7, "{}", s.pdf);
        }
    }
}

/// The points that a small or distant sphere is sampled at cover the half that is seen, evenly in
/// solid angle. The axis is oblique, so that no coordinate of a direction is exact.
#[test]
fn the_seen_side_of_a_sphere_is_covered() {
    let axis = DVec3::new(1.0, 2.0, 3.0).normalize();
    let across = axis.any_orthonormal_vector();
    for (seed, ratio) in (411..).zip([0.5f32, 1e-2, 1e-4, 1e-6, 1e-7]) {
        let sphere = sphere(axis.as_vec3a(), ratio);
        let light = Area::new(Arc::clone(&sphere), Vec3A::ONE).expect("has an area");
        let mut counts = [0; 20];
        let mut lost = 0;
        for u in points(seed, SAMPLES) {
            if light.sample_toward(DVec3::ZERO, u.as_dvec2()).is_none() {
                lost += 1;
                continue;
            }
            let s = sphere.sample_primitive(0, DVec3::ZERO, u).expect("as the light has it");
            let normal = s.point.geometric_normal.as_dvec3();
            // The angle at the eye from the normal's, by the plane triangle of eye, centre and point.
            let ratio = f64::from(ratio);
            let along = 1.0 + ratio * normal.dot(axis);
            let tan = ratio * normal.reject_from_normalized(axis).length() / along;
            let one_minus_cos = |sin2: f64| sin2 / (1.0 + (1.0 - sin2).sqrt());
            let share = one_minus_cos(tan * tan / (1.0 + tan * tan)) / one_minus_cos(ratio * ratio);
            let ring = ((share * 10.0) as usize).min(9);
            counts[ring * 2 + usize::from(normal.dot(across) > 0.0)] += 1;
        }
        // The outermost of them, where the cosine on the sphere is within the rounding 1e-7 of 0,
        // is a share of 1e-14.
        assert_eq!(lost, 0, "ratio {ratio}");
        let expected = [f64::from(SAMPLES) / 20.0; 20];
        chi_squared(&counts, &expected, 5).unwrap_or_else(|table| panic!("ratio {ratio}: {table}"));
    }
}

/// What a ray from `from` sees of a light, and the density that the light claims for it.
fn density_seen(
    area: &Area,
    shape: &dyn Shape,
    from: Vec3A,
    direction: Vec3A,
) -> Option<(f32, f64)> {
    let ray = Ray::new(from, direction);
    let hit = trace(shape, &ray)?;
    let point = shape.surface(&ray, &hit);
    let cosine = f64::from(point.geometric_normal.dot(direction).abs());
    let (from, surface) = (from.as_dvec3(), Some((&hit, &point)));
    Some((area.pdf_toward(&Sight { from, direction, surface }), cosine))
}

#[test]
fn both_densities_are_one() {
    for (seed, light) in (501..).zip(&lights()) {
        let area = Area::new(Arc::clone(&light.shape), Vec3A::ONE).expect("has an area");
        let (mut seen, mut missed) = (0, 0);
        for u in corners() {
            let usable = |s: EmitterSample| s.pdf > 0.0 && s.weight.is_finite();
            assert!(
                area.sample_toward(light.from.as_dvec3(), u.as_dvec2()).is_none_or(usable),
                "{} {u}",
                light.name
            );
        }
        for u in points(seed, 10_000) {
            let Some(s) = area.sample_toward(light.from.as_dvec3(), u.as_dvec2()) else {
                continue;
            };
            // The unit vector and the two positions carry 4 roundings each, which a flat view
            // divides by its cosine.
            let Some((pdf, cosine)) =
                density_seen(&area, light.shape.as_ref(), light.from, s.direction)
            else {
                missed += 1;
                continue;
            };
            seen += 1;
            // Points of a mesh are moved off its edges by 32 u of their size, which counts three times.
            let tolerance = 2e-6 / cosine + 2e-5 + light.direction_error(cosine);
            let off = f64::from(pdf / s.pdf - 1.0).abs();
            assert!(off <= tolerance, "{}: pdf {pdf}, sample {s:?}", light.name);
            // Radiance over density is the weight.
            assert!((s.weight.x * s.pdf - 1.0).abs() < 1e-6, "{}: {s:?}", light.name);
        }
        // Only the rim may be missed.
        let inside = light.direction_error(1.0) >= 1e-5;
        assert!(missed * 100 <= seen || inside, "{}: {missed}", light.name);
    }
}

/// Light that varies over a shape, by points of the shape and by directions that happen to hit it: one mean by
/// Welch's test, and another one if the colours change places.
#[test]
fn textured_lights_send_what_is_seen() {
    let board = |colors: [f32; 2]| {
        let colors = colors.map(|c| Textured::Uniform(Vec3A::splat(c)));
        let to_uv = Affine2::from_scale_angle_translation(Vec2::splat(0.6), 0.3, Vec2::splat(0.1));
        Textured::Varying(Arc::new(Checkerboard::new(colors, to_uv)) as Arc<dyn Texture>)
    };
    let lights = lights();
    // Directions in a hundred thousand do not find the smallest ones.
    let lights: Vec<_> = lights.iter().filter(|l| l.irradiance > 1e-2).collect();
    let mut noticed = 0;
    for (seed, light) in (511..).zip(&lights) {
        let [area, swapped] = [[3.0, 1.0], [1.0, 3.0]]
            .map(|c| Area::new(Arc::clone(&light.shape), board(c)).expect("has an area"));
        let frame = Frame::from_normal(light.normal.into());
        let by_directions = Moments::of(points(seed + 100, SAMPLES).map(|u| {
            let direction =
                Vec3A::from(frame.to_world(warp::square_to_cosine_hemisphere(u.into())));
            let ray = Ray::new(light.from, direction);
            trace(light.shape.as_ref(), &ray).map_or(0.0, |hit| {
                let point = light.shape.surface(&ray, &hit);
                let (from, surface) = (light.from.as_dvec3(), Some((&hit, &point)));
                PI * f64::from(area.radiance(&Sight { from, direction, surface }).x)
            })
        }));
        let by_points = |area| irradiance(area, light.from, light.normal, seed);
        let p_value = welch(&by_points(&area), &by_directions, 0.0);
        assert!(p_value >= significance_each(lights.len()), "{}: p = {p_value}", light.name);
        noticed += usize::from(welch(&by_points(&swapped), &by_directions, 0.0) < 0.01);
    }
    // Some are seen so that both colours send the same.
    assert!(2 * noticed > lights.len(), "{noticed} of {}", lights.len());
}

/// Two triangles alike, of which a texture makes one black: 19 of 20 samples go to the other, and both densities
/// say so.
#[test]
fn the_bright_part_of_a_mesh_is_sampled_more() {
    let colors = [3.0, 0.0].map(|c| Textured::Uniform(Vec3A::splat(c)));
    let board: Arc<dyn Texture> = Arc::new(Checkerboard::new(colors, Affine2::IDENTITY));
    let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, 0.0), (0.0, 1.0)];
    let positions = corners.map(|(x, y)| Vec3A::new(x, y, 0.0)).to_vec();
    let uvs = [[Vec2::splat(0.25); 3], [Vec2::new(0.75, 0.25); 3]].concat();
    let (mesh, _) = TriangleMesh::new(
        positions.into_iter().collect(),
        vec![[0, 1, 2], [3, 4, 5]],
        Vec::new(),
        uvs,
    )
    .expect("valid");
    let shape: Arc<dyn Shape> = Arc::new(mesh);
    let light = Area::new(Arc::clone(&shape), Textured::Varying(board)).expect("has an area");
    // A tenth of each guess is the mean of 1.5: 2.85 and 0.15.
    assert!((light.power().expect("inside the scene") - PI * 1.5).abs() < 1e-5);
    let from = Vec3A::new(0.0, 0.4, 1.0);
    let (mut bright, mut all) = (0, 0);
    for u in points(621, 10_000) {
        let s = light.sample_toward(from.as_dvec3(), u.as_dvec2()).expect("all of it is seen");
        let (pdf, _) = density_seen(&light, shape.as_ref(), from, s.direction).expect("hit");
        assert!((pdf / s.pdf - 1.0).abs() < 1e-4, "{pdf} {s:?}");
        all += 1;
        bright += u64::from(s.weight.x > 0.0);
    }
    let expected = [0.95, 0.05].map(|share| share * all as f64);
    chi_squared(&[bright, all - bright], &expected, 1).unwrap_or_else(|table| panic!("{table}"));
    assert!(chi_squared(&[bright, all - bright], &[0.5 * all as f64; 2], 1).is_err());
}

/// A flat light from behind, from its own plane, from its own points: nothing, and no NaN.
#[test]
fn lights_are_dark_where_they_must_be() {
    let light = Area::new(square(1.0, Vec3A::ZERO), Vec3A::ONE).expect("has an area");
    // The square faces −z.
    for from in [Vec3A::Z, Vec3A::new(3.0, 0.0, 0.0), Vec3A::new(0.5, 0.25, 0.0), Vec3A::ZERO] {
        for u in points(601, 1_000).chain(corners()) {
            assert!(light.sample_toward(from.as_dvec3(), u.as_dvec2()).is_none(), "from {from}");
        }
    }
    let shape = square(1.0, Vec3A::ZERO);
    let (pdf, _) = density_seen(&light, shape.as_ref(), Vec3A::Z, Vec3A::NEG_Z).expect("hit");
    assert_eq!(pdf, 0.0, "the back is never sampled");
    let point = Point::new(Vec3A::ONE, Vec3A::ONE);
    assert!(point.sample_toward(DVec3::ONE, DVec2::ZERO).is_none());
}

/// A square of side 1e-10 at a distance of 1e10: a solid angle of 1e-40.
#[test]
fn tiny_and_distant_lights_stay_finite() {
    let light =
        Area::new(square(0.5e-10, Vec3A::Z * 1e10), Vec3A::splat(1e20)).expect("has an area");
    irradiance(&light, Vec3A::ZERO, Vec3A::Z, 602).has_mean(1e-20, 1).expect("Le A / d²");
    let blinding =
        Area::new(square(1.0, Vec3A::Z * 10.0), Vec3A::splat(1e30)).expect("has an area");
    let s = blinding.sample_toward(DVec3::ZERO, DVec2::splat(0.3)).expect("seen");
    assert!(s.weight.is_finite() && s.pdf.is_finite(), "{s:?}");
}

/// One triangle of area ½ among 999,999 of area 1e-12 and, in another mesh, of area 1e-50, which is 0
/// in f32.
#[test]
fn slivers_do_not_disturb_a_mesh_light() {
    for leg in [1.414e-6f32, 1.414e-25] {
        let mut positions = vec![Vec3A::ZERO, Vec3A::X * leg, Vec3A::Y * leg];
        positions.extend([Vec3A::ZERO, Vec3A::X, Vec3A::Y]);
        let mut triangles = vec![[0, 1, 2]; 999_999];
        triangles.push([3, 4, 5]);
        let positions = positions.into_iter().collect();
        let (mesh, dropped) =
            TriangleMesh::new(positions, triangles, Vec::new(), Vec::new()).expect("valid");
        assert_eq!(dropped.degenerate, 0);
        let mesh = Arc::new(mesh);
        let light = Area::new(mesh.clone(), Vec3A::ONE).expect("has an area");
        let from = Vec3A::new(0.2, 0.2, 1.0);
        let polygon = [DVec3::ZERO, DVec3::X, DVec3::Y];
        // The small ones add 1e-6 of the power at most.
        let expected = lambert(&polygon, from.as_dvec3(), DVec3::NEG_Z);
        irradiance(&light, from, Vec3A::NEG_Z, 603).has_mean(expected, 2).expect("Lambert");
        // u = 0 chooses the first of the small ones.
        let from = from.as_dvec3();
        let s = light.sample_toward(from, DVec2::ZERO).expect("seen");
        let point = mesh.sample_primitive(0, from, Vec2::ZERO).expect("as the light has it").point;
        let hit = Hit { t: 1.0, u: 0.0, v: 0.0, shape: 0, primitive: 0, member: 0 };
        let surface = Some((&hit, &point));
        let pdf = light.pdf_toward(&Sight { from, direction: s.direction, surface });
        assert!((pdf / s.pdf - 1.0).abs() < 1e-5, "{pdf} {s:?}");
        assert!((s.pdf * s.weight.x - 1.0).abs() < 1e-5, "{s:?}");
    }
}

/// The sphere that a point sees from inside: directions follow the density that is claimed.
#[test]
fn directions_inside_a_sphere_follow_their_density() {
    let grid = support::quadrature::SphereGrid { rows: 10, columns: 20 };
    let shape: Arc<dyn Shape> = Arc::new(telamon::shape::Sphere::new(
        Vec3A::ZERO,
        2.0,
        Frame::from_normal(Vec3A::Z.into()),
        true,
    ));
    let light = Area::new(Arc::clone(&shape), Vec3A::ONE).expect("has an area");
    let from = DVec3::new(0.9, -0.4, 0.5);
    let mut counts = vec![0; grid.cells()];
    for u in points(604, SAMPLES) {
        counts[grid.cell(
            light.sample_toward(from, u.as_dvec2()).expect("all of it is seen").direction,
        )] += 1;
    }
    let seen = |w: Vec3A| {
        density_seen(&light, shape.as_ref(), from.as_vec3a(), w).map_or(0.0, |(pdf, _)| pdf.into())
    };
    let expected: Vec<f64> =
        grid.integrals(1, seen).iter().map(|p| p * f64::from(SAMPLES)).collect();
    chi_squared(&counts, &expected, 1).unwrap_or_else(|table| panic!("{table}"));
    let uniform = vec![f64::from(SAMPLES) / grid.cells() as f64; grid.cells()];
    assert!(chi_squared(&counts, &uniform, 1).is_err(), "a uniform density would do as well");
}

#[test]
fn every_emitter_lights_a_plane() {
    let emitters = emitters();
    let tested: BTreeSet<_> = emitters.iter().map(|(plugin, ..)| *plugin).collect();
    assert_eq!(tested, plugin_names(Category::Emitter), "each has a row of the table");
    for (seed, (plugin, emitter, expected)) in (605..).zip(&emitters) {
        let estimate = irradiance(emitter.as_ref(), Vec3A::ZERO, Vec3A::Z, seed);
        estimate
            .has_mean(*expected, emitters.len())
            .unwrap_or_else(|figures| panic!("{plugin}: {figures}"));
        assert!(estimate.has_mean(1.05 * expected, 1).is_err(), "{plugin}: {estimate:?}");
    }
}

#[test]
fn every_shape_is_tested_as_a_light() {
    let tested: BTreeSet<_> = lights().iter().flat_map(|l| l.plugins).copied().collect();
    let emits = |p: &&Plugin| p.parts.iter().any(|part| part.category == Category::Emitter);
    let shapes = supported().filter(|p| p.category() == Category::Shape);
    assert_eq!(tested, shapes.filter(emits).map(|p| p.name).collect());
}

#[test]
fn both_densities_of_the_environment_are_one() {
    let sky = Constant::new(Vec3A::new(1.0, 2.0, 3.0));
    let s = sky.sample_toward(DVec3::ZERO, DVec2::splat(0.2)).expect("seen from everywhere");
    let sight = Sight { from: DVec3::ZERO, direction: s.direction, surface: None };
    assert_eq!(s.pdf, sky.pdf_toward(&sight));
    assert!((s.weight * s.pdf - sky.radiance(&sight)).abs().max_element() < 1e-6);
}

/// What is the same all around is left to the directions of surfaces, but not if there is nothing else.
#[test]
fn a_uniform_sky_beside_a_lamp_is_never_chosen() {
    let floor =
        Receiver { position: DVec3::X, normal: Vec3A::Z, both_sides: true, is_diffuse: true };
    let sky = || Box::new(Constant::new(Vec3A::ONE)) as Box<dyn Emitter>;
    let mut emitters = two_lights([1.0, 3.0]);
    emitters.push(sky());
    for policy in [ChoicePolicy::Power, ChoicePolicy::Uniform, ChoicePolicy::Bvh] {
        let shares = |choice: EmitterChoice| [0, 1, 2].map(|i| choice.probability(&floor, i));
        let [a, b, outside] = shares(EmitterChoice::beside_directions(policy, &emitters));
        assert_eq!((a + b, outside), (1.0, 0.0), "{policy:?}");
        assert!(a > 0.0 && b > 0.0, "{policy:?}");
        assert!(shares(EmitterChoice::new(policy, &emitters))[2] > 0.0, "{policy:?}");
        let alone = EmitterChoice::beside_directions(policy, &[sky()]);
        assert_eq!(alone.probability(&floor, 0), 1.0, "{policy:?}");
    }
}

fn two_lights(powers: [f32; 2]) -> Vec<Box<dyn Emitter>> {
    powers
        .map(|power| Box::new(Point::new(Vec3A::ZERO, Vec3A::splat(power))) as Box<dyn Emitter>)
        .into()
}

#[test]
fn one_emitter_is_always_chosen() {
    let floor =
        Receiver { position: DVec3::X, normal: Vec3A::Z, both_sides: true, is_diffuse: true };
    for policy in [ChoicePolicy::Power, ChoicePolicy::Uniform, ChoicePolicy::Bvh] {
        for powers in [[1.0, 3.0], [1e20, 1.0], [0.0, 2.0], [1e30, 1e30]] {
            let choice = EmitterChoice::new(policy, &two_lights(powers));
            let total = choice.probability(&floor, 0) + choice.probability(&floor, 1);
            // One rounding of each share.
            assert!((total - 1.0).abs() <= f64::EPSILON, "{policy:?} {powers:?}: {total}");
            let mut counts = [0; 2];
            for u in points(701, SAMPLES) {
                let chosen = choice.sample(&floor, u.x.into()).expect("one emits");
                let Chosen { emitter, probability, rest, .. } = chosen;
                assert_eq!(probability, choice.probability(&floor, emitter));
                assert!(probability > 0.0 && (0.0..1.0).contains(&rest));
                counts[emitter] += 1;
            }
            let expected = [0, 1].map(|i| choice.probability(&floor, i) * f64::from(SAMPLES));
            if expected.iter().all(|&e| e > 1.0) {
                chi_squared(&counts, &expected, 12).unwrap_or_else(|table| panic!("{table}"));
            }
        }
    }
    let power = EmitterChoice::new(ChoicePolicy::Power, &two_lights([1.0, 3.0]));
    assert!((power.probability(&floor, 0) - 0.25).abs() < 1e-7);
    let uniform = EmitterChoice::new(ChoicePolicy::Uniform, &two_lights([1.0, 3.0]));
    assert_eq!(uniform.probability(&floor, 0), 0.5);
    // An environment has half of the choices, whatever the others' power; all if they are dark.
    let mut with_sky = two_lights([1.0, 3.0]);
    with_sky.push(Box::new(Constant::new(Vec3A::ONE)));
    let power = EmitterChoice::new(ChoicePolicy::Power, &with_sky);
    assert_eq!([0, 1, 2].map(|i| power.probability(&floor, i)), [0.125, 0.375, 0.5]);
    let dark = EmitterChoice::new(ChoicePolicy::Uniform, &two_lights([0.0, 0.0]));
    assert!(dark.sample(&floor, 0.5).is_none() && dark.probability(&floor, 0) == 0.0);
}
