//! Where the rays of a path start: at the point that was hit, to its rounding, beside surfaces of any size.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3A};
use telamon::bsdf::{Bsdf, Diffuse, TwoSided};
use telamon::emitter::{Area, Constant, Emitter};
use telamon::integrator::{Integrator, Path, PathSettings, Tracer};
use telamon::math::{Frame, Rgb, warp};
use telamon::ray::Ray;
use telamon::sampler::{Independent, PathSampler};
use telamon::scene::Scene;
use telamon::shape::{Shape, Sphere, TriangleMesh, primitives};

use crate::ULP;
use crate::support::meshes::{corners_of, engines, mesh, sphere_mesh};
use crate::support::rooms::object;
use crate::support::stats::Moments;
use crate::support::{points, points_3d};

/// Estimates along one ray, of direct light only.
fn radiance(scene: &Scene, ray: &Ray, seed: u64, count: u32) -> Vec<(String, Moments)> {
    let settings = PathSettings { max_depth: Some(2), ..PathSettings::default() };
    let path = Path::new(&settings, scene);
    let estimates = |engine: &dyn telamon::intersect::Intersector| {
        let mut tracer = Tracer::new(scene, engine);
        let sampler = Independent::new(seed);
        let values = (0..count).map(|i| {
            let mut numbers = PathSampler::new(&sampler, i, 0);
            f64::from(path.estimate(&mut tracer, ray, &mut numbers).radiance.x)
        });
        Moments::of(values)
    };
    engines(&scene.shapes()).iter().map(|e| (e.name(), estimates(e.as_ref()))).collect()
}

/// A rectangle between two corners of a plane that is given by its origin and two axes of length 1.
fn wall(place: DAffine3, origin: DVec3, x: DVec3, y: DVec3) -> Arc<dyn Shape> {
    let to_world =
        DAffine3::from_mat3_translation(DMat3::from_cols(x, y, x.cross(y).normalize()), origin);
    Arc::new(primitives::rectangle(place * to_world, false).0)
}

/// The walls at x = -0.6, x = 1.4, y = -1, y = 1 of a box, black on both sides, with a lamp inside, over a grey ground
/// of this half side in z = 0; without the walls from `walls` on. The walls go on below the ground.
fn lit_box(place: DAffine3, ground: f64, walls: usize) -> Scene {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let middle = DVec3::new(0.4, 0.0, 0.9);
    let sides = [middle - x, middle + x, middle - y, middle + y];
    let up = z * 1.1;
    let along = [y, y, x, x];
    let mut objects = vec![object(wall(place, DVec3::ZERO, x * ground, y * ground), 0, None)];
    let of_side = |i: usize| object(wall(place, sides[i], along[i], up), 1, None);
    objects.extend((0..walls).map(of_side));
    objects.push(object(wall(place, middle + up, x, y), 1, None));
    let scale = place.matrix3.x_axis.length();
    let center = place.transform_point3(middle).as_vec3a();
    let lamp =
        Sphere::new(center, (0.2 * scale) as f32, Frame::from_normal(Vec3A::Z.into()), false);
    let lamp: Arc<dyn Shape> = Arc::new(lamp);
    let light = Area::new(Arc::clone(&lamp), Rgb::splat(100.0)).expect("an area");
    objects.push(object(lamp, 1, Some(0)));
    let black = TwoSided::new(Box::new(Diffuse::new(Rgb::ZERO)), None).expect("reflects only");
    let bsdfs: Vec<Box<dyn Bsdf>> = vec![Box::new(Diffuse::new(Rgb::splat(0.5))), Box::new(black)];
    Scene::new(objects, bsdfs, vec![Box::new(light)], None).expect("indices in range")
}

/// Sums of what is seen of the ground outside of the box, at these distances from its walls and where its diagonal
/// meets them.
fn seen_outside(scene: &Scene, place: DAffine3, distances: &[f64]) -> Vec<(String, f64)> {
    let path = Path::new(&PathSettings::default(), scene);
    let see = |engine: &dyn telamon::intersect::Intersector| {
        let mut tracer = Tracer::new(scene, engine);
        let sampler = Independent::new(3);
        let mut sum = 0.0;
        for (i, u) in (0..).zip(points(361, 400)) {
            let along = if i % 4 == 0 { 1.0 } else { 2.0 * f64::from(u.x) - 1.0 };
            for &d in distances {
                let feet = [
                    DVec3::new(-0.6 - d, along, 0.0),
                    DVec3::new(1.4 + d, along, 0.0),
                    DVec3::new(0.4 + along, -1.0 - d, 0.0),
                    DVec3::new(0.4 + along, 1.0 + d, 0.0),
                    // On the ground's diagonal.
                    DVec3::new(1.0 + d * f64::from(u.y), 1.0 + d, 0.0),
                ];
                for foot in feet {
                    // Straight down, or from outside.
                    let away = (foot - DVec3::new(0.4, 0.0, 0.0)) * f64::from(i % 2);
                    let origin = place.transform_point3(foot + away + DVec3::Z * 0.5).as_vec3a();
                    let to = place.transform_point3(foot) - origin.as_dvec3();
                    let ray = Ray::new(origin, to.normalize().as_vec3a());
                    let mut numbers = PathSampler::new(&sampler, i, 0);
                    sum += f64::from(path.estimate(&mut tracer, &ray, &mut numbers).radiance.x);
                }
            }
        }
        sum
    };
    engines(&scene.shapes()).iter().map(|engine| (engine.name(), see(engine.as_ref()))).collect()
}

/// Nothing of a lamp in a closed box is seen outside, however large the ground is that the box stands on: a point that is
/// hit is not moved through a wall. The nearest points are 8 spacings of f32 from the wall, whose own corners
/// are rounded where the box is turned.
#[test]
fn the_ground_outside_a_lit_box_is_black() {
    let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.48, 0.64), 0.9);
    for scale in [1e-8, 1.0, 1e8] {
        for (turn, nearest) in [(DMat3::IDENTITY, 1e-6), (turn, 2e-6)] {
            let place = DAffine3::from_mat3(turn * scale);
            for ground in [2.0, 30.0, 1000.0] {
                // A ground that is turned lies where its corners are rounded to.
                let nearest: f64 =
                    if turn == DMat3::IDENTITY { nearest } else { nearest.max(1e-6 * ground) };
                let scene = lit_box(place, ground, 4);
                for (engine, sum) in
                    seen_outside(&scene, place, &[nearest, nearest.max(1e-5), 1e-3])
                {
                    assert_eq!(sum, 0.0, "{engine}, {turn}, scale {scale}, ground {ground}");
                }
            }
        }
    }
    let open = lit_box(DAffine3::IDENTITY, 30.0, 3);
    for (engine, sum) in seen_outside(&open, DAffine3::IDENTITY, &[1e-3]) {
        assert!(sum > 1.0, "{engine}: an open box would not be noticed");
    }
}

/// Floors in z = 0 of this half side, each with something else at the origin: the diagonal of a rectangle, an edge
/// between two meshes, a vertex of 64 triangles.
fn floors(half: f64) -> [(&'static str, Vec<Arc<dyn Shape>>); 3] {
    let s = half as f32;
    let square = primitives::rectangle(DAffine3::from_scale(DVec3::new(half, half, 1.0)), false).0;
    let corner = |x: f32, y: f32| Vec3A::new(x * s, y * s, 0.0);
    let strip = |x: f32| {
        let corners = [corner(0.0, -1.0), corner(x, -0.7), corner(0.0, 1.0)];
        let order = if x > 0.0 { [0, 1, 2] } else { [0, 2, 1] };
        let shape: Arc<dyn Shape> = Arc::new(mesh(corners.to_vec(), vec![order]));
        shape
    };
    let rim = |i: u32| {
        let angle = f64::from(i) / 64.0 * 2.0 * PI;
        corner(angle.cos() as f32, angle.sin() as f32)
    };
    let fan = mesh(
        (0..64).map(rim).chain([Vec3A::ZERO]).collect(),
        (0..64).map(|i| [64, i, (i + 1) % 64]).collect(),
    );
    [
        ("diagonal", vec![Arc::new(square)]),
        ("edge", vec![strip(1.0), strip(-1.0)]),
        ("vertex", vec![Arc::new(fan)]),
    ]
}

/// A square lamp close above a floor, whose half side is half of its height: E = 4A atan A with A = 1/√5, at any height.
#[test]
fn a_lamp_close_to_the_floor_is_seen_whole() {
    let a = 0.2f64.sqrt();
    let expected = 0.5 / PI * 4.0 * a * a.atan();
    for (size, height) in [1e-2, 1e-3, 1e-4, 1e-5].map(|h| (1.0, h)).into_iter().chain([
        (1e-8, 1e-12),
        (1e8, 1e4),
        (1e8, 1e3),
    ]) {
        for (name, floor) in floors(size) {
            let down = DAffine3::from_translation(DVec3::Z * height)
                * DAffine3::from_scale(DVec3::splat(0.5 * height));
            let lamp: Arc<dyn Shape> = Arc::new(primitives::rectangle(down, true).0);
            let light = Area::new(Arc::clone(&lamp), Rgb::ONE).expect("an area");
            let mut objects: Vec<_> = floor.into_iter().map(|s| object(s, 0, None)).collect();
            objects.push(object(lamp, 0, Some(0)));
            let bsdfs: Vec<Box<dyn Bsdf>> = vec![Box::new(Diffuse::new(Rgb::splat(0.5)))];
            let scene = Scene::new(objects, bsdfs, vec![Box::new(light)], None).expect("valid");
            let ray = Ray::new(Vec3A::Z * (0.5 * height) as f32, Vec3A::NEG_Z);
            for (engine, moments) in radiance(&scene, &ray, 371, 40_000) {
                moments.has_mean(expected, 7 * 3 * 2).unwrap_or_else(|figures| {
                    panic!("{engine}, {name}, {height} above {size}: {figures}")
                });
                assert!((moments.mean() / expected - 1.0).abs() < 2e-3, "{engine}, {name}");
            }
        }
    }
}

/// A black ball of radius r under a white sky rests on a ground: at the distance a from where it touches, its cone
/// touches the horizon, and it takes sin³ of its half angle from the irradiance, with sin = r/√(a² + r²). On
/// spheres from 1 to 10⁶ and on a plane.
fn under_ball(radius: f64, ground: Arc<dyn Shape>, at: f64, lifted: f64) -> Vec<(String, Moments)> {
    let center = Vec3A::Z * (radius + lifted) as f32;
    let axes = Frame::from_normal(Vec3A::Z.into());
    let ball: Arc<dyn Shape> = Arc::new(Sphere::new(center, radius as f32, axes, false));
    let bsdfs: Vec<Box<dyn Bsdf>> =
        vec![Box::new(Diffuse::new(Rgb::splat(0.5))), Box::new(Diffuse::new(Rgb::ZERO))];
    let objects = vec![object(ground, 0, None), object(ball, 1, None)];
    let sky: Vec<Box<dyn Emitter>> = vec![Box::new(Constant::new(Rgb::ONE))];
    let scene = Scene::new(objects, bsdfs, sky, Some(0)).expect("valid");
    let foot = DVec3::new(at * radius, 0.0, 0.0);
    let origin = (foot + DVec3::new(3.0, 1.0, 2.0) * radius).as_vec3a();
    let to = foot - origin.as_dvec3();
    radiance(&scene, &Ray::new(origin, to.normalize().as_vec3a()), 381, 40_000)
}

#[test]
fn a_small_ball_casts_its_shadow_on_a_large_ground() {
    let plane = |half: f64| -> Arc<dyn Shape> {
        Arc::new(primitives::rectangle(DAffine3::from_scale(DVec3::splat(half)), false).0)
    };
    let globe = |radius: f32| -> Arc<dyn Shape> {
        let center = Vec3A::NEG_Z * radius;
        Arc::new(Sphere::new(center, radius, Frame::from_normal(Vec3A::Z.into()), false))
    };
    let expected = |at: f64| 0.5 * (1.0 - (1.0 / (at * at + 1.0).sqrt()).powi(3));
    let radius = 5e-4;
    for at in [0.5, 1.0, 2.0] {
        for size in [1.0, 100.0, 1e4, 1e6] {
            for ground in [plane(size), globe(size as f32)] {
                let kind = ground.kind();
                for (engine, moments) in under_ball(radius, ground, at, 0.0) {
                    // A ground of radius 1 is curved by 1e-3 under the ball.
                    moments.has_mean(expected(at), 3 * 4 * 2 * 2).unwrap_or_else(|figures| {
                        panic!("{engine}, {at} radii away on a {kind} of {size}: {figures}")
                    });
                }
            }
        }
    }
    for (engine, moments) in under_ball(radius, plane(1e6), 0.5, radius) {
        assert!(
            moments.has_mean(expected(0.5), 1).is_err(),
            "{engine}: a lifted ball is not noticed"
        );
    }
}

/// Rays aimed at the edges of large squares, turned or not: the point that is hit lies on the ray's line and on the
/// square, to the rounding of its coordinates, of which positions keep none.
#[test]
fn rays_onto_edges_land_on_their_point() {
    let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.48, 0.64), 0.9);
    for (half, center) in
        [(10.0, DVec3::ZERO), (1e3, DVec3::ZERO), (10.0, DVec3::new(7e3, 2e3, -5e3))]
    {
        let to_world = DAffine3::from_mat3_translation(turn * half, center);
        let square = primitives::rectangle(to_world, false).0;
        let [a, b, c] = square.triangles()[0].map(|i| square.positions()[i as usize].as_dvec3());
        let shapes: [Arc<dyn Shape>; 1] = [Arc::new(square.clone())];
        for engine in engines(&shapes) {
            let mut hits = 0;
            for u in points_3d(391, 4_000) {
                // On one of the edges of a triangle, the diagonal among them.
                let [from, to] = [[a, b], [b, c], [c, a]][(u.z * 3.0) as usize % 3];
                let target = from.lerp(to, f64::from(u.x) * 0.01 + 0.495);
                let away = DVec3::new(u.y.into(), f64::from(u.z) - 0.5, 1.0);
                let origin = (target + turn * away * 0.01 * half).as_vec3a();
                let direction = (target - origin.as_dvec3()).normalize().as_vec3a();
                let ray = Ray::new(origin, direction);
                let Some(hit) = engine.closest_hit(&ray) else { continue };
                hits += 1;
                let position = shapes[0].surface(&ray, &hit).position;
                let along = direction.as_dvec3().normalize();
                let off = (position - origin.as_dvec3()).reject_from_normalized(along).length();
                // Less than one rounding; an engine that is off by more takes the triangle beyond the edge, and the
                // point is on the edge, which is as near to the line as the aim, two roundings.
                let rounding =
                    f64::from(ULP) * (position.abs().max_element() + target.abs().max_element());
                let aim = f64::from(ULP) * origin.as_dvec3().distance(target);
                assert!(off <= rounding + 4.0 * aim, "{}: {off} beside, {position}", engine.name());
            }
            assert!(hits > 2_000, "{}: {hits}", engine.name());
        }
    }
}

/// A closed mesh around the origin, whose edges are as often concave as convex, and the points between two of its
/// corners for numbers of the unit cube.
fn star_and_edges(seed: u64, count: u32) -> (TriangleMesh, Vec<DVec3>) {
    let round = sphere_mesh(DVec3::ZERO, 1.0, 8, 11);
    let place = |(p, u): (&Vec3A, Vec3A)| *p * (0.5 + 0.5 * u.x);
    let numbers = points_3d(seed, round.positions().len() as u32);
    let corners = round.positions().iter().zip(numbers).map(place).collect();
    let star = mesh(corners, round.triangles().to_vec());
    let on_edge = |u: Vec3A| {
        let corners = corners_of(&star, (u.x * star.triangles().len() as f32) as u32);
        let first = (u.y * 3.0) as usize % 3;
        corners[first].lerp(corners[(first + 1) % 3], u.z.into())
    };
    let targets = points_3d(seed + 1, count).map(on_edge).collect();
    (star, targets)
}

/// Rays between walls, onto edges of what is seen from there: the surface is where the engine met it, and not where the same
/// line meets another triangle at the edge's ends, such as the one that the ray leaves.
#[test]
fn surfaces_next_to_edges_are_where_they_are_met() {
    let (star, targets) = star_and_edges(451, 20_000);
    let shapes: [Arc<dyn Shape>; 1] = [Arc::new(star)];
    for engine in engines(&shapes) {
        let mut met = 0;
        for pair in targets.windows(2) {
            // From a point beside an edge to another edge.
            let to = (pair[0] * 0.98 + pair[1] * 0.02).normalize().as_vec3a();
            let first = Ray::new(Vec3A::ZERO, to);
            let hit = engine.closest_hit(&first).expect("a closed room");
            let start = shapes[0].surface(&first, &hit);
            let direction = (pair[1] - start.position).normalize().as_vec3a();
            if direction.dot(start.geometric_normal) > -0.05 {
                continue;
            }
            let ray = start.spawn(direction);
            let Some(hit) = engine.closest_hit(&ray) else { continue };
            let position = shapes[0].surface(&ray, &hit).position;
            let along = (position - ray.origin.as_dvec3()).dot(direction.as_dvec3());
            // An engine errs where it sees a triangle from the side.
            let off = (along - f64::from(hit.t)).abs();
            assert!(off < 1e-2, "{}: {off} beside, {ray:?} {hit:?}", engine.name());
            met += 1;
        }
        assert!(met > 5_000, "{}: {met}", engine.name());
    }
}

/// Rays from outside, as close to the edges of a closed mesh as f32 aims: what they meet first is seen from in front. At
/// an edge at which the mesh turns away, its front and its back are met at the same f32.
#[test]
fn what_turns_away_is_not_met_from_behind() {
    let (star, targets) = star_and_edges(461, 60_000);
    let shapes: [Arc<dyn Shape>; 1] = [Arc::new(star.clone())];
    // Embree itself takes triangles to be met a rounding beyond their edges.
    for engine in engines(&shapes).into_iter().filter(|engine| engine.name().contains("Rust")) {
        let mut met = 0;
        for (target, u) in targets.iter().zip(points_3d(471, 60_000)) {
            let origin: Vec3A =
                warp::square_to_uniform_sphere(glam::Vec2::new(u.x, u.y).into()).into();
            let origin = origin * 3.0;
            let to = target - origin.as_dvec3();
            let ray = Ray::new(origin, to.normalize().as_vec3a());
            let Some(hit) = engine.closest_hit(&ray) else { continue };
            let [a, b, c] = corners_of(&star, hit.primitive);
            let facing = (b - a).cross(c - a).dot(ray.direction.as_dvec3());
            assert!(facing < 0.0, "{}: {ray:?} meets {hit:?} from behind", engine.name());
            met += 1;
        }
        assert!(met > 30_000, "{}: {met}", engine.name());
    }
}
