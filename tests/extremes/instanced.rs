//! Closed rooms and bodies that are instances: how rays leave them next to their edges, in the scene's roundings and in those
//! of the group.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3A};
use telamon::bsdf::{Bsdf, Diffuse, TwoSided};
use telamon::emitter::{Area, Constant, Emitter};
use telamon::integrator::{Integrator, Path, PathSettings, Strategy, Tracer};
use telamon::math::{Frame, Motion, Rgb};
use telamon::ray::Ray;
use telamon::sampler::{Independent, PathSampler};
use telamon::scene::Scene;
use telamon::shape::{Group, Instance, Shape, Sphere, TriangleMesh};

use crate::ULP;
use crate::support::meshes::{corners_of, engines, mesh, sphere_mesh};
use crate::support::points_3d;
use crate::support::rooms::{NO_ROULETTE, object};

/// Paths in each room by each engine; a million on demand.
const PATHS: u32 = 6_000;

/// An instance of a mesh that is seen whole from `inside`, a point of the group.
struct Room {
    name: &'static str,
    mesh: TriangleMesh,
    inside: DVec3,
    instance: Arc<Instance>,
}

/// Where groups are put: turned, mirrored, drawn out and sheared, tiny, huge, far from the origin.
fn placements() -> [(&'static str, DAffine3); 8] {
    let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(0.6, 0.48, 0.64), 0.9));
    let by = |x, y, z| DMat3::from_diagonal(DVec3::new(x, y, z));
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.7, 1.0, 0.0), DVec3::new(-0.3, 0.4, 1.0));
    [
        ("in place", DAffine3::IDENTITY),
        ("turned", DAffine3::from_mat3(turn)),
        ("mirrored", DAffine3::from_mat3(turn * by(1.0, -1.0, 1.0))),
        ("drawn out", DAffine3::from_mat3_translation(turn * by(1.0, 0.2, 2.0), DVec3::X)),
        ("sheared", DAffine3::from_mat3(turn * shear * by(-2.0, 0.5, 1.0))),
        ("tiny", DAffine3::from_mat3(turn * 1e-8)),
        ("huge", DAffine3::from_mat3(turn * 1e8)),
        ("far away", DAffine3::from_mat3_translation(turn, DVec3::new(7e2, -2e3, 9e2))),
    ]
}

/// A turn by a radian, a shift and a shrinking while the shutter is open.
fn motion() -> Motion {
    let key = |i: i32| {
        let part = f64::from(i) / 8.0;
        let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(0.6, 0.48, 0.64), part));
        let moved = DVec3::new(0.1 * part, -0.2 * part, 0.5);
        (part, DAffine3::from_mat3_translation(turn * (1.0 - 0.5 * part), moved))
    };
    Motion::new((0..=8).map(key).collect()).expect("ascending")
}

fn rooms(mesh: &TriangleMesh, inside: DVec3) -> Vec<Room> {
    let group = |mesh: &TriangleMesh| {
        Arc::new(Group::new(vec![Arc::new(mesh.clone())]).expect("no instances"))
    };
    let room = |name, mesh: &TriangleMesh, inside, instance| Room {
        name,
        mesh: mesh.clone(),
        inside,
        instance: Arc::new(instance),
    };
    let still = |(name, map)| {
        let instance = Instance::new(group(mesh), map).expect("not singular");
        room(name, mesh, inside, instance)
    };
    let mut rooms: Vec<_> = placements().into_iter().map(still).collect();
    let moving = Instance::moving(group(mesh), motion()).expect("not singular");
    rooms.push(room("moving", mesh, inside, moving));
    // Far from the group's origin, and brought back to that of the scene: the group's roundings are the larger.
    let away = DVec3::new(30.0, -70.0, 50.0);
    let moved = |p: &Vec3A| (p.as_dvec3() + away).as_vec3a();
    let (far, _) = TriangleMesh::new(
        mesh.positions().iter().map(moved).collect(),
        mesh.triangles().to_vec(),
        Vec::new(),
        Vec::new(),
    )
    .expect("valid");
    let back = DAffine3::from_translation(-away);
    let instance = Instance::new(group(&far), back).expect("not singular");
    rooms.push(room("far in its group", &far, inside + away, instance));
    rooms
}

/// A ray from inside onto an edge of the mesh, within a few roundings of the scene's coordinates, for numbers of the unit cube.
fn onto_edge(room: &Room, u: Vec3A, time: f32) -> Ray {
    let place = room.instance.to_world(time);
    let count = room.mesh.triangles().len() as f32;
    let primitive = (u.x * count) as u32;
    let part = u.x * count - primitive as f32;
    let [a, b, c] = corners_of(&room.mesh, primitive);
    let [a, b] = [[a, b], [b, c], [c, a]][(part * 3.0) as usize % 3];
    let along = f64::from(u.y);
    let target = place.transform_point3(a.lerp(b, along));
    let off = DVec3::new(
        (u.z * 7.0).fract().into(),
        (u.z * 31.0).fract().into(),
        (u.z * 127.0).fract().into(),
    ) - 0.5;
    let target = target + off * (8.0 * f64::from(ULP) * target.abs().max_element());
    let origin = place.transform_point3(room.inside).as_vec3a();
    let direction = (target - origin.as_dvec3()).normalize().as_vec3a();
    Ray { time, ..Ray::new(origin, direction) }
}

/// A closed mesh around the origin of edges that are as often concave as convex.
fn star() -> TriangleMesh {
    let round = sphere_mesh(DVec3::ZERO, 1.0, 8, 11);
    let place = |(p, u): (&Vec3A, Vec3A)| *p * (0.75 + 0.25 * u.x);
    let numbers = points_3d(441, round.positions().len() as u32);
    mesh(round.positions().iter().zip(numbers).map(place).collect(), round.triangles().to_vec())
}

/// Radiance along rays onto edges, from inside, by each engine; nothing ends paths by chance.
fn seen(room: &Room, scene: &Scene, max_depth: Option<u32>, paths: u32, check: impl Fn(&str, f32)) {
    let settings = PathSettings {
        strategy: Strategy::Bsdf,
        roulette: NO_ROULETTE,
        max_depth,
        ..PathSettings::default()
    };
    let path = Path::new(&settings, scene);
    for engine in engines(&scene.shapes()) {
        let mut tracer = Tracer::new(scene, engine.as_ref());
        let sampler = Independent::new(7);
        for (i, u) in (0..).zip(points_3d(431, paths)) {
            let mut numbers = PathSampler::new(&sampler, i, 0);
            let ray = onto_edge(room, u, (u.z * 3.0).fract());
            let radiance = path.estimate(&mut tracer, &ray, &mut numbers).radiance.x;
            check(&format!("{}, {}: path {i}", engine.name(), room.name), radiance);
        }
    }
}

/// Walls that reflect on both sides.
fn walls(reflectance: f32) -> Box<dyn Bsdf> {
    let diffuse = Diffuse::new(Rgb::splat(reflectance));
    Box::new(TwoSided::new(Box::new(diffuse), None).expect("reflects"))
}

fn no_light_gets_in(paths: u32) {
    for room in rooms(&star(), DVec3::ZERO) {
        let sky: Vec<Box<dyn Emitter>> = vec![Box::new(Constant::new(Rgb::ONE))];
        let objects = vec![object(room.instance.clone(), 0, None)];
        let scene = Scene::new(objects, vec![walls(0.8)], sky, Some(0)).expect("valid");
        seen(&room, &scene, Some(12), paths, |what, value| assert_eq!(value, 0.0, "{what}"));
    }
}

/// Under a white sky it is exactly black inside, though all paths begin on an edge.
#[test]
fn no_light_gets_into_an_instanced_room() {
    no_light_gets_in(PATHS);
}

#[test]
#[ignore = "minutes: cargo test --test extremes instanced -- --ignored"]
fn no_light_gets_into_an_instanced_room_in_a_million_paths() {
    no_light_gets_in(1_000_000);
}

/// White walls around a black lamp that emits 1: whatever way a path takes, it ends there with all that it carries.
fn no_path_gets_out(paths: u32) {
    for room in rooms(&star(), DVec3::ZERO) {
        // Where the room is at all times.
        let place = room.instance.to_world(0.5);
        let columns = place.matrix3;
        let least = [columns.x_axis, columns.y_axis, columns.z_axis].map(DVec3::length);
        let radius = 0.2 * least.into_iter().fold(f64::INFINITY, f64::min);
        let beside = DVec3::new(0.3, -0.2, 0.1);
        let center = place.transform_point3(room.inside + beside).as_vec3a();
        let axes = Frame::from_normal(Vec3A::Z.into());
        let lamp: Arc<dyn Shape> = Arc::new(Sphere::new(center, radius as f32, axes, false));
        let light = Area::new(Arc::clone(&lamp), Rgb::ONE).expect("an area");
        let objects = vec![object(room.instance.clone(), 0, None), object(lamp, 1, Some(0))];
        let bsdfs = vec![walls(1.0), walls(0.0)];
        let scene = Scene::new(objects, bsdfs, vec![Box::new(light)], None).expect("valid");
        seen(&room, &scene, None, paths, |what, value| {
            assert!((value - 1.0).abs() < 1e-4, "{what}: {value}");
        });
    }
}

#[test]
fn no_path_gets_out_of_an_instanced_room() {
    no_path_gets_out(PATHS / 4);
}

#[test]
#[ignore = "minutes: cargo test --test extremes instanced -- --ignored"]
fn no_path_gets_out_of_an_instanced_room_in_a_million_paths() {
    no_path_gets_out(1_000_000);
}
