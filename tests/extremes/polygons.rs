//! Polygons that light a point on an edge of the floor: Lambert's formula, and where a ray onto the edge lands.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};
use telamon::emitter::{Area, Emitter};
use telamon::math::Rgb;
use telamon::ray::Ray;
use telamon::shape::{Shape, TriangleMesh};

use crate::support::meshes::{engines, mesh};
use crate::support::points_3d;

/// Irradiance at `point` with the unit normal `normal` from a polygon of radiance 1 above its horizon: half the sum of the
/// angles under which its sides are seen, each times the cosine between `normal` and the normal of the plane through the
/// side and the point (Lambert, Photometria, 1760).
fn lambert(corners: &[DVec3], point: DVec3, normal: DVec3) -> f64 {
    let toward: Vec<_> = corners.iter().map(|c| (*c - point).normalize()).collect();
    let side = |i: usize| {
        let (a, b) = (toward[i], toward[(i + 1) % toward.len()]);
        let across = a.cross(b);
        // Loses nothing for small angles.
        let angle = across.length().atan2(a.dot(b));
        angle * across.normalize().dot(normal)
    };
    0.5 * (0..toward.len()).map(side).sum::<f64>().abs()
}

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
                        [256, 512].map(|side| irradiance(&light, point, normal, side));
                    worst = worst.max((found - expected).abs());
                    let figures = format!("{found} {expected}");
                    let name = format!("{name}, {}, {lamp:?}", engine.name());
                    assert!((found - expected).abs() < 1e-5, "{name}, {times}: {figures}");
                    assert!((found - coarse).abs() < 3e-5, "{name}, {times}: {coarse} {found}");
                    // From a point 1e-4 beside it, as f32 weights would have it, that shows.
                    let beside =
                        irradiance(&light, point + lamp[0].cross(normal) * 1e-4, normal, 512);
                    assert!((beside - expected).abs() > 1e-6 || expected < 0.05, "{name}");
                }
            }
        }
    }
    assert!(worst > 0.0, "nothing was compared");
}

/// The mean over a grid of `side`² samples.
fn irradiance(light: &dyn Emitter, point: DVec3, normal: DVec3, side: u32) -> f64 {
    let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
    let samples = (0..side * side).map(|i| DVec2::new(middle(i % side), middle(i / side)));
    let arriving = samples.filter_map(|u| light.sample_toward(point, u)).map(|sample| {
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
