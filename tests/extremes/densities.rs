//! The density of a direction, as the shadow ray and as the scattered ray have it: from the same point, wherever that is.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3A};
use telamon::emitter::{Area, ChoicePolicy, Emitter, EmitterChoice, LightOrigin, Receiver, Sight};
use telamon::math::{Frame, Rgb};
use telamon::ray::Ray;
use telamon::shape::{Cylinder, Disk, Shape, Sphere, TriangleMesh, primitives};

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
            let receiver =
                Receiver { position: surface.position, normal: Vec3A::Z, both_sides: false };
            for policy in [ChoicePolicy::Bvh, ChoicePolicy::Power] {
                let choice = EmitterChoice::new(policy, &emitters);
                let mut seen = vec![0u32; lights.len()];
                let mut noticed = 0;
                for u in points(421, 20_000) {
                    let Some(s) = choice.sample_toward(&emitters, &receiver, u.as_dvec2()) else {
                        continue;
                    };
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
                    let pdf = |from: DVec3| {
                        let receiver = Receiver { position: from, ..receiver };
                        let surface = Some((&hit, &point));
                        let sight = Sight { from, direction: s.direction, surface };
                        choice.pdf_toward(&emitters, hit.shape as usize, &receiver, &sight)
                    };
                    let off = |pdf: f32| f64::from(pdf / s.pdf - 1.0).abs();
                    let here = off(pdf(surface.position));
                    assert!(
                        here <= tolerance(cosine),
                        "{}, {policy:?}, {} at {center}: {here} at {cosine}",
                        engine.name(),
                        lights[hit.shape as usize].kind(),
                    );
                    seen[hit.shape as usize] += 1;
                    noticed += usize::from(off(pdf(surface.position + DVec3::Z * 1e-2)) > 1e-3);
                }
                // Far away, all of a mesh is next to its edges.
                let counts = |kind: &str| center == DVec3::ZERO || kind != "TriangleMesh";
                let enough = |(n, light): (&u32, &Arc<dyn Shape>)| *n > 30 || !counts(light.kind());
                assert!(seen.iter().zip(&lights).all(enough), "{policy:?} at {center}: {seen:?}");
                assert!(noticed > 5_000, "densities of another point are not told apart");
            }
        }
    }
}
