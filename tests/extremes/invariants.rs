//! What must not change a picture: how a mesh is cut into triangles, in what order, which way they are wound,
//! and where the scene lies. (`rendering.rs` has scale and exposure, which change no digit.)

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3A};
use telamon::bsdf::{Bsdf, Diffuse, TwoSided};
use telamon::emitter::{Area, Emitter};
use telamon::integrator::{Integrator, Path, PathSettings, Tracer};
use telamon::math::Rgb;
use telamon::ray::Ray;
use telamon::sampler::{Independent, PathSampler};
use telamon::scene::Scene;
use telamon::shape::{Shape, TriangleMesh, primitives};

use crate::support::meshes::{engines, mesh, sphere_mesh};
use crate::support::rooms::object;
use crate::support::stats::Moments;

/// A ball of 760 triangles whose corners are multiples of 1/64, and so are floats up to 2^17 from the origin.
fn ball() -> TriangleMesh {
    let fine = sphere_mesh(DVec3::ZERO, 0.75, 20, 20);
    let coarse = fine.positions().iter().map(|&p| (p * 64.0).round() / 64.0).collect();
    mesh(coarse, fine.triangles().to_vec())
}

/// An engine's name, and estimates with it.
type Seen = (String, Vec<f64>);

/// What is seen of a ball that scatters on both sides, in a room with a lamp under the ceiling, at `center`.
fn seen(ball: &TriangleMesh, center: DVec3) -> Vec<Seen> {
    let at = |matrix: DMat3, place: DVec3| DAffine3::from_mat3_translation(matrix, place + center);
    let identity = DMat3::IDENTITY;
    let room: Arc<dyn Shape> = Arc::new(primitives::cube(at(identity * 2.0, DVec3::ZERO), true).0);
    let down = DMat3::from_cols(DVec3::X * 0.5, DVec3::NEG_Z * 0.5, DVec3::Y);
    let lamp: Arc<dyn Shape> = Arc::new(primitives::rectangle(at(down, DVec3::Y * 1.75), true).0);
    let moved = ball.positions().iter().map(|&p| p + center.as_vec3a()).collect();
    let ball: Arc<dyn Shape> = Arc::new(mesh(moved, ball.triangles().to_vec()));
    let emitter: Box<dyn Emitter> =
        Box::new(Area::new(lamp.clone(), Rgb::splat(10.0)).expect("an area"));
    let walls: Box<dyn Bsdf> = Box::new(Diffuse::new(Rgb::splat(0.6)));
    let grey = Box::new(Diffuse::new(Rgb::splat(0.7)));
    let both: Box<dyn Bsdf> = Box::new(TwoSided::new(grey, None).expect("reflects only"));
    let objects = vec![object(room, 0, None), object(ball, 1, None), object(lamp, 0, Some(0))];
    let scene = Scene::new(objects, vec![walls, both], vec![emitter], None).expect("valid");
    let integrator = Path::new(&PathSettings::default(), &scene);
    let origin = center.as_vec3a() + Vec3A::new(0.25, 0.5, 1.75);
    let look = |engine: Box<dyn telamon::intersect::Intersector>| {
        let mut tracer = Tracer::new(&scene, engine.as_ref());
        let sampler = Independent::new(1);
        let values = (0..30_000).map(|i| {
            let mut numbers = PathSampler::new(&sampler, i, 0);
            let u = numbers.next_2d() * 1.2 - 0.6;
            let ray = Ray::new(origin, Vec3A::new(u.x, u.y - 0.3, -1.0).normalize());
            f64::from(integrator.estimate(&mut tracer, &ray, &mut numbers).radiance.x)
        });
        (engine.name(), values.collect())
    };
    engines(&scene.shapes()).into_iter().map(look).collect()
}

/// Student's paired test, with the same numbers for both, that a ball has the mean of the ball as it is.
fn same_mean(plain: &[Seen], other: &[Seen], checks: usize) -> Result<(), String> {
    plain.iter().zip(other).try_for_each(|((engine, a), (_, b))| {
        let mean = Moments::of(a.iter().copied()).mean();
        // Around the mean and not around 0, so that roundings are forgiven in proportion to it.
        Moments::of(a.iter().zip(b).map(|(a, b)| mean + b - a))
            .has_mean(mean, checks)
            .map_err(|figures| format!("{engine}: {figures}"))
    })
}

#[test]
fn the_triangles_of_a_mesh_do_not_show() {
    let ball = ball();
    let (positions, triangles) = (ball.positions(), ball.triangles());
    let split = {
        // Each into three around its centroid.
        let mut positions = positions.to_vec();
        let mut parts = Vec::new();
        for &[a, b, c] in triangles {
            let center = positions.len() as u32;
            let sum = [a, b, c].iter().fold(Vec3A::ZERO, |sum, &i| sum + positions[i as usize]);
            positions.push(sum / 3.0);
            parts.extend([[a, b, center], [b, c, center], [c, a, center]]);
        }
        mesh(positions, parts)
    };
    let unshared = {
        let corners = triangles.iter().flatten().map(|&i| positions[i as usize]).collect();
        mesh(corners, (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
    };
    let reordered = {
        let mut triangles = triangles.to_vec();
        triangles.reverse();
        triangles.iter_mut().for_each(|t| t.rotate_left(1));
        mesh(positions.to_vec(), triangles)
    };
    let flipped = mesh(positions.to_vec(), triangles.iter().map(|&[a, b, c]| [a, c, b]).collect());
    let twice = mesh(positions.to_vec(), [triangles, triangles].concat());
    let plain = seen(&ball, DVec3::ZERO);
    for (name, other) in [
        ("split", split),
        ("unshared", unshared),
        ("reordered", reordered),
        ("flipped", flipped),
        ("every triangle twice", twice),
    ] {
        same_mean(&plain, &seen(&other, DVec3::ZERO), 10)
            .unwrap_or_else(|figures| panic!("{name}: {figures}"));
    }
}

/// All corners are floats at every place; what grows with the distance is the rounding of points between
/// them.
#[test]
fn the_place_of_a_scene_does_not_show() {
    let plain = seen(&ball(), DVec3::ZERO);
    for power in [10, 12, 14] {
        let far = f64::from(power).exp2();
        for center in [DVec3::X * far, DVec3::new(-far, far, far)] {
            same_mean(&plain, &seen(&ball(), center), 12)
                .unwrap_or_else(|figures| panic!("at {center}: {figures}"));
        }
    }
}

/// The tests above notice a ball that is a tenth smaller.
#[test]
fn another_ball_is_noticed() {
    let smaller = ball().positions().iter().map(|&p| p * 0.9).collect();
    let other = seen(&mesh(smaller, ball().triangles().to_vec()), DVec3::ZERO);
    for (plain, other) in seen(&ball(), DVec3::ZERO).into_iter().zip(other) {
        assert!(same_mean(&[plain], &[other], 12).is_err());
    }
}
