//! Polygons that light a point on an edge of the floor: Lambert's formula, and where a ray onto the edge lands.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3};
use telamon::emitter::{Area, Emitter, EmitterSample};
use telamon::math::Rgb;
use telamon::ray::Ray;
use telamon::shape::{Shape, TriangleMesh, primitives};

use crate::support::lights::lambert;
use crate::support::meshes::{corners_of, engines, mesh};
use crate::support::points_3d;

/// Triangles above the plane y = 0 that face the origin at more than 12 degrees, near and far.
fn lamps() -> Vec<[DVec3; 3]> {
    let numbers: Vec<_> = points_3d(80, 300).map(|u| u.as_dvec3()).collect();
    let lamp = |(i, numbers): (usize, &[DVec3; 3])| {
        let lift = if i % 2 == 0 { 0.3 } else { 0.05 };
        let [a, b, c] = numbers.map(|u| {
            // In f32, as the mesh has them.
            let corner = (u * DVec3::new(2.0, 1.0, 2.0) + DVec3::new(-1.0, lift, -1.0)).as_vec3();
            corner.as_dvec3()
        });
        let normal = (b - a).cross(c - a).normalize();
        let facing = normal.dot(a.normalize());
        let corners = if facing < 0.0 { [a, b, c] } else { [a, c, b] };
        (facing.abs() > 0.2).then_some(corners)
    };
    numbers.as_chunks::<3>().0.iter().enumerate().filter_map(lamp).take(6).collect()
}

/// The same triangle as sixteen, by the middles of sides.
fn divided(corners: [DVec3; 3], times: u32) -> Vec<[DVec3; 3]> {
    if times == 0 {
        return vec![corners];
    }
    let [a, b, c] = corners;
    let [ab, bc, ca] = [a + b, b + c, c + a].map(|sum| 0.5 * sum);
    let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
    parts.into_iter().flat_map(|part| divided(part, times - 1)).collect()
}

fn triangles(triangles: &[[DVec3; 3]]) -> TriangleMesh {
    let positions = triangles.iter().flatten().map(|p| p.as_vec3a()).collect();
    mesh(positions, (0..triangles.len() as u32).map(|i| [0, 1, 2].map(|k| 3 * i + k)).collect())
}

/// Floors through the origin, where their triangles meet: on the diagonal of a square 20 units wide, at the hub of a fan of
/// 32 triangles, and on the diagonal of a square that leans; each with its unit normal.
fn floors() -> Vec<(&'static str, Arc<dyn Shape>, DVec3)> {
    let square = [(-10.0, -10.0), (-10.0, 10.0), (10.0, 10.0), (10.0, -10.0)]
        .map(|(x, z)| DVec3::new(x, 0.0, z));
    let halves = |[a, b, c, d]: [DVec3; 4]| triangles(&[[a, b, c], [a, c, d]]);
    // Opposite corners are opposite numbers, so that the rounded diagonal still passes through the origin.
    let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.48, 0.64), 0.9);
    let leaning = square.map(|corner| (turn * corner).as_vec3().as_dvec3());
    let normal = (leaning[1] - leaning[0]).cross(leaning[2] - leaning[0]).normalize();
    let rim = |i: u32| {
        let (sin, cos) = (f64::from(i % 32) * PI / 16.0).sin_cos();
        let radius = 3.0 + f64::from(i % 32 * 7 % 28);
        DVec3::new(radius * cos, 0.0, -radius * sin)
    };
    let fan: Vec<_> = (0..32).map(|i| [DVec3::ZERO, rim(i), rim(i + 1)]).collect();
    vec![
        ("diagonal", Arc::new(halves(square)), DVec3::Y),
        ("fan", Arc::new(triangles(&fan)), DVec3::Y),
        ("leaning", Arc::new(halves(leaning)), normal),
    ]
}

/// A ray onto the edge lands where it is aimed, within two roundings, and what lights the point there is what lights the
/// edge.
///
/// The mean over the middles of 512² cells stands for the integral over the lamp; nothing is random. Its error falls with the
/// square of a cell's side, so it is a third of the difference to the mean over 256² cells: less than 1e-5.
#[test]
fn polygons_light_an_edge_as_they_should() {
    let mut worst: f64 = 0.0;
    for (name, floor, normal) in floors() {
        for engine in engines(std::slice::from_ref(&floor)) {
            let origin = (normal * 0.01).as_vec3a();
            let ray = Ray::new(origin, (-normal).as_vec3a().normalize());
            let hit = engine.closest_hit(&ray).expect("a floor");
            let point = floor.surface(&ray, &hit).position;
            // Where the rounded ray meets the plane.
            let (from, direction) = (origin.as_dvec3(), ray.direction.as_dvec3());
            let aimed = from - direction * (from.dot(normal) / direction.dot(normal));
            let roundings = (point - aimed).length() / (0.01 * f64::from(f32::EPSILON) / 2.0);
            assert!(roundings <= 2.0, "{name}, {}: {roundings} roundings", engine.name());
            for lamp in lamps() {
                // The lamps of the floor that leans lean with it.
                let turn = glam::DQuat::from_rotation_arc(DVec3::Y, normal);
                let lamp = lamp.map(|corner| (turn * corner).as_vec3().as_dvec3());
                let expected = lambert(&lamp, DVec3::ZERO, normal);
                for times in [0, 2] {
                    let shape: Arc<dyn Shape> = Arc::new(triangles(&divided(lamp, times)));
                    let light = Area::new(shape, Rgb::ONE).expect("an area");
                    let [coarse, found] =
                        [256, 512].map(|side| irradiance(&light, point, normal, side, |_| true));
                    worst = worst.max((found - expected).abs());
                    let figures = format!("{found} {expected}");
                    let name = format!("{name}, {}, {lamp:?}", engine.name());
                    assert!((found - expected).abs() < 1e-5, "{name}, {times}: {figures}");
                    assert!((found - coarse).abs() < 3e-5, "{name}, {times}: {coarse} {found}");
                    // From a point 1e-4 beside it, as f32 weights would have it, that shows.
                    let beside = irradiance(
                        &light,
                        point + lamp[0].cross(normal) * 1e-4,
                        normal,
                        512,
                        |_| true,
                    );
                    assert!((beside - expected).abs() > 1e-6 || expected < 0.05, "{name}");
                }
            }
        }
    }
    assert!(worst > 0.0, "nothing was compared");
}

/// Rays onto the diagonal of a square of half side 10 under small triangles of light: irradiances are those of the points that they
/// are aimed at, to 1e-5. A point that were 1e-5 of the square beside its place would see the nearest lamp, at a height of 1/50, under
/// an angle that is off by 1/200. The midpoint rule errs by a multiple of 1/side², which two sides remove; the rest is less than their
/// difference.
#[test]
fn the_irradiance_on_a_diagonal_is_that_of_the_point() {
    let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.48, 0.64), 0.9);
    for (scale, turn) in [(1.0, DMat3::IDENTITY), (1.0, turn), (1e-8, turn), (1e8, turn)] {
        let place = DAffine3::from_mat3(turn * scale);
        let floor = DAffine3::from_scale(DVec3::new(10.0, 10.0, 1.0));
        let floor = Arc::new(primitives::rectangle(place * floor, false).0);
        let [a, b, c] = corners_of(&floor, 0);
        // The longest edge.
        let edges = [(a, b), (b, c), (c, a)];
        let longest =
            edges.into_iter().max_by(|p, q| p.0.distance(p.1).total_cmp(&q.0.distance(q.1)));
        let (from, to) = longest.expect("three");
        let normal = (b - a).cross(c - a).normalize();
        let side = (to - from).normalize().cross(normal);
        for (i, height) in (0..).zip([0.02, 0.1, 0.5, 2.0]) {
            let target = from.lerp(to, 0.37 + 0.06 * f64::from(i));
            // Seen from below, and wholly to one side of the point.
            let corner = |along: f64, beside: f64, up: f64| {
                let along = (to - from).normalize() * along;
                target + (along + side * beside + normal * up) * (height * scale)
            };
            let corners = [corner(0.3, 0.4, 1.0), corner(1.2, 0.2, 1.1), corner(0.9, 1.1, 1.3)];
            let lamp = Arc::new(mesh(corners.map(DVec3::as_vec3a).into(), vec![[0, 1, 2]]));
            let corners = corners_of(&lamp, 0);
            let faces_down = (corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(normal);
            assert!(faces_down < 0.0, "seen from above");
            let shapes: [Arc<dyn Shape>; 2] = [floor.clone(), lamp.clone()];
            let light = Area::new(lamp, Rgb::ONE).expect("an area");
            let expected = lambert(&corners, target, normal);
            let origin = (target + (normal - side * 0.3) * (0.3 * height * scale)).as_vec3a();
            let aim = (target - origin.as_dvec3()).normalize().as_vec3a();
            let ray = Ray::new(origin, aim);
            for engine in engines(&shapes) {
                let hit = engine.closest_hit(&ray).filter(|hit| hit.shape == 0);
                let surface = floor.surface(&ray, &hit.expect("the floor"));
                let is_free = |sample: &EmitterSample| {
                    sample.shadow_ray(&surface).is_some_and(|shadow| !engine.occluded(&shadow))
                };
                let [coarse, fine] = [128, 256]
                    .map(|side| irradiance(&light, surface.position, normal, side, is_free));
                let found = fine + (fine - coarse) / 3.0;
                let case = format!("{}, {height} at {scale}: {found}", engine.name());
                assert!(
                    ((fine - coarse) / expected).abs() < 2e-5,
                    "{case}: not converged, {coarse}"
                );
                assert!((found / expected - 1.0).abs() < 1e-5, "{case}, not {expected}");
                // It would be seen if the point were where an offset of 1e-5 of the square had moved it.
                let moved = target + side * (1e-4 * scale);
                let moved = lambert(&corners, moved, normal) / expected - 1.0;
                assert!(moved.abs() > 1e-5, "{case}: {moved} is not told");
            }
        }
    }
}

/// The mean over a grid of `side`² samples of those that are free.
fn irradiance(
    light: &dyn Emitter,
    point: DVec3,
    normal: DVec3,
    side: u32,
    is_free: impl Fn(&EmitterSample) -> bool,
) -> f64 {
    let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
    let samples = (0..side * side).map(|i| DVec2::new(middle(i % side), middle(i / side)));
    let arriving = samples.filter_map(|u| light.sample_toward(point, u)).filter(is_free);
    let arriving = arriving.map(|sample| {
        let cosine = sample.direction.as_dvec3().dot(normal).max(0.0);
        f64::from(sample.weight.x) * cosine
    });
    arriving.sum::<f64>() / f64::from(side * side)
}

/// The formula itself: of a square of half side 1 at height 1 above the point it is the closed form of `lights`.
#[test]
fn lamberts_formula_is_that_of_a_square() {
    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
    let corners = corners.map(|(x, z)| DVec3::new(x, 1.0, z));
    let a = 0.5f64.sqrt();
    let expected = 4.0 * a * a.atan();
    assert!((lambert(&corners, DVec3::ZERO, DVec3::Y) - expected).abs() < 1e-14);
}
