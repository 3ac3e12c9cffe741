//! Motion within the shutter, against closed forms, still pictures and itself at rest.

mod support;

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec3A};
use support::meshes::{engines, mesh, sphere_mesh};
use support::pictures::{parse, picture};
use support::stats::{Moments, significance_each, welch};
use support::{points, points_3d};
use telamon::intersect::{Backend, Intersector};
use telamon::math::{Motion, warp};
use telamon::ray::Ray;
use telamon::render::requirements::Feature;
use telamon::render::{Description, Requirements};
use telamon::shape::{DeformingMesh, Group, Instance, Shape, primitives};

fn moving(shape: Arc<dyn Shape>, keys: Vec<(f64, DAffine3)>) -> Arc<dyn Shape> {
    let group = Arc::new(Group::new(vec![shape]).expect("not an instance"));
    let motion = Motion::new(keys).expect("ascending");
    Arc::new(Instance::moving(group, motion).expect("not singular"))
}

fn shift(x: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::X * x)
}

/// The share of `COUNT` moments, in the middle of equal parts of the shutter, at which a ray along +z through
/// (x, y) is blocked. Each end of an interval of time moves it by half a moment at most.
fn covered(engine: &dyn Intersector, x: f64, y: f64) -> f64 {
    let from = DVec3::new(x, y, -1.0).as_vec3a();
    let blocked = |i: &u32| {
        let time = (*i as f32 + 0.5) / COUNT as f32;
        engine.occluded(&Ray { time, ..Ray::new(from, Vec3A::Z) })
    };
    f64::from((0..COUNT).filter(blocked).count() as u32) / f64::from(COUNT)
}

const COUNT: u32 = 1000;

/// A unit square that moves by four of its sides: as far as it goes alone the coverage is a ramp of slope 1/4
/// per side, and a plateau of 1/4 between.
#[test]
fn a_moving_edge_makes_a_linear_ramp() {
    let half = DAffine3::from_scale(DVec3::splat(0.5));
    let square = Arc::new(primitives::rectangle(half, false).0);
    let shapes = [moving(square, vec![(0.0, shift(0.5)), (1.0, shift(4.5))])];
    for engine in engines(&shapes) {
        for i in 0..200 {
            let x = -0.5 + 6.0 * (f64::from(i) + 0.5) / 200.0;
            let expected = (0.25 * x).min(0.25 * (5.0 - x)).clamp(0.0, 0.25);
            let found = covered(engine.as_ref(), x, 0.2);
            let off = (found - expected).abs();
            assert!(off <= 1.0 / f64::from(COUNT) + 1e-6, "{} {x}: {found}", engine.name());
        }
    }
}

/// A strip of half width w that turns by 90 degrees about the origin: a point at distance r is in it while the
/// strip's angle is within asin(w/r) of the point's.
#[test]
fn a_turning_strip_covers_what_it_sweeps() {
    const KEYS: u32 = 90;
    let width = 0.05;
    let map = DAffine3::from_scale(DVec3::new(2.0, width, 1.0));
    let strip = Arc::new(primitives::rectangle(map, false).0);
    let angle = |part: f64| DAffine3::from_rotation_z(part * std::f64::consts::FRAC_PI_2);
    let key = |i: u32| f64::from(i) / f64::from(KEYS);
    let shapes = [moving(strip, (0..=KEYS).map(|i| (key(i), angle(key(i)))).collect())];
    for engine in engines(&shapes) {
        for i in 0..100 {
            let radius = 0.2 + 1.6 * f64::from(i % 10) / 10.0;
            // So far from both ends that the strip passes all of the point.
            let reach = (width / radius).asin();
            let most = std::f64::consts::FRAC_PI_2 - 2.2 * reach;
            let at = 1.1 * reach + most * f64::from(i / 10) / 9.0;
            let expected = 2.0 * reach / std::f64::consts::FRAC_PI_2;
            let found = covered(engine.as_ref(), radius * at.cos(), radius * at.sin());
            // A degree between keys: chords are 4e-5 nearer to the centre than arcs, and the angle along a
            // chord deviates by 1e-6 from that along the arc.
            let off = (found - expected).abs();
            let bound = 1.0 / f64::from(COUNT) + 1e-4 * expected + 1e-5;
            assert!(off <= bound, "{} {radius} {at}: {found} {expected}", engine.name());
        }
    }
}

/// A unit square one side of which goes from x = 1 to x = 3 and back: a point between is covered for as long as
/// the side is beyond it.
#[test]
fn a_stretching_square_covers_what_it_reaches() {
    let square = |x: f64| {
        let map = DAffine3::from_translation(DVec3::new(0.5 * x, 0.5, 0.0))
            * DAffine3::from_scale(DVec3::new(0.5 * x, 0.5, 1.0));
        Arc::new(primitives::rectangle(map, false).0)
    };
    let keys = vec![(0.0, square(1.0)), (0.25, square(3.0)), (1.0, square(1.0))];
    let shapes: [Arc<dyn Shape>; 1] = [Arc::new(DeformingMesh::new(keys).expect("alike"))];
    for engine in engines(&shapes) {
        for i in 0..150 {
            let x = 3.2 * (f64::from(i) + 0.5) / 150.0;
            let expected = if x < 1.0 { 1.0 } else { (0.5 * (3.0 - x)).max(0.0) };
            let found = covered(engine.as_ref(), x, 0.3);
            let off = (found - expected).abs();
            assert!(off <= 1.0 / f64::from(COUNT) + 1e-6, "{} {x}: {found}", engine.name());
        }
    }
}

/// A mesh whose key meshes are those of a moving instance at its keys moves as the instance does, whose matrix is
/// linear between them, and each hit is where the instance's is.
#[test]
fn a_deforming_mesh_moves_as_its_vertices_do() {
    let sphere = sphere_mesh(DVec3::ZERO, 1.0, 16, 24);
    let placed = |map: DAffine3| {
        let positions = sphere.positions().iter();
        let positions = positions.map(|p| map.transform_point3(p.as_dvec3()).as_vec3a()).collect();
        Arc::new(mesh(positions, sphere.triangles().to_vec()))
    };
    let keys = tumbling().into_iter().map(|(time, map)| (time, placed(map))).collect();
    let deforming: Arc<dyn Shape> = Arc::new(DeformingMesh::new(keys).expect("alike"));
    let moving = [moving(Arc::new(sphere.clone()), tumbling())];
    let deforming = [deforming];
    for (a, b) in engines(&deforming).iter().zip(engines(&moving)) {
        let (mut hits, mut differences) = (0, 0);
        for (i, (from, to)) in points_3d(5, 20_000).zip(points(6, 20_000)).enumerate() {
            let time = i as f32 / 20_000.0;
            let from = (from - Vec3A::new(0.2, 0.6, 0.4)) * 7.0;
            let ray = Ray {
                time,
                ..Ray::new(from, Vec3A::from(warp::square_to_uniform_sphere(to.into())))
            };
            let (one, other) = (a.closest_hit(&ray), b.closest_hit(&ray));
            assert_eq!(a.occluded(&ray), one.is_some(), "{ray:?}");
            let (Some(one), Some(other)) = (one, other) else {
                differences += u32::from(one.is_some() != other.is_some());
                continue;
            };
            hits += 1;
            let [one, other] = [(&deforming[0], one), (&moving[0], other)]
                .map(|(shape, hit)| shape.surface(&ray, &hit));
            // Positions within 1e-5 of lengths of up to 10, seen at a grazing angle at worst.
            let apart = one.position.distance(other.position);
            assert!(apart < 1e-3, "{ray:?}: {apart}");
            assert_eq!((one.time, other.time), (time, time));
        }
        assert!(hits > 500, "{hits}");
        // Rays that pass an outline within the rounding of the vertices: one in 10⁵ at most.
        assert!(differences <= 1, "{differences}");
    }
}

/// Turning, stretching and flying.
fn tumbling() -> Vec<(f64, DAffine3)> {
    let key = |i: u32| {
        let part = f64::from(i) / 4.0;
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 3.0 * part);
        let map = DAffine3::from_scale_rotation_translation(
            DVec3::new(1.0 + part, 1.0, 1.0 - 0.5 * part),
            turn,
            DVec3::new(3.0 * part, -part, part * part),
        );
        (part, map)
    };
    (0..5).map(key).collect()
}

/// No ray leaves a closed mesh that moves, at any moment, and what is hit lies where the mesh then is.
#[test]
fn a_moving_mesh_is_closed_at_every_moment() {
    let sphere = Arc::new(sphere_mesh(DVec3::ZERO, 1.0, 16, 24));
    let motion = Motion::new(tumbling()).expect("ascending");
    let shapes = [moving(sphere, tumbling())];
    for engine in engines(&shapes) {
        for (i, (from, to)) in points_3d(1, 20_000).zip(points(2, 20_000)).enumerate() {
            let time = i as f32 / 20_000.0;
            let map = motion.at(time.into());
            let from = map.transform_point3((from - 0.5).as_dvec3()).as_vec3a();
            let ray = Ray {
                time,
                ..Ray::new(from, Vec3A::from(warp::square_to_uniform_sphere(to.into())))
            };
            let hit = engine.closest_hit(&ray).expect("inside");
            let surface = shapes[0].surface(&ray, &hit);
            assert!(surface.geometric_normal.dot(ray.direction) > 0.0);
            let local = map.inverse().transform_point3(surface.position);
            // Faces of 15 degrees lie up to 1 - cos 7.5° = 0.9 % inside of the sphere in each direction.
            assert!((0.98..1.001).contains(&local.length()), "{time}: {}", local.length());
        }
    }
}

/// At random moments, with a still mesh beside the moving ones.
#[test]
fn engines_agree_at_every_moment() {
    let sphere: Arc<dyn Shape> = Arc::new(sphere_mesh(DVec3::ZERO, 1.0, 16, 24));
    let cube: Arc<dyn Shape> = Arc::new(primitives::cube(DAffine3::IDENTITY, false).0);
    let back = tumbling().into_iter().rev().map(|(time, map)| (1.0 - time, map)).collect();
    let still = Arc::new(sphere_mesh(DVec3::new(0.0, 1.0, -2.0), 1.0, 12, 16));
    let shapes = [still, moving(sphere, tumbling()), moving(cube, back)];
    let engines = engines(&shapes);
    let (mut hits, mut differences) = (0, 0);
    for (i, (from, to)) in points_3d(3, 60_000).zip(points(4, 60_000)).enumerate() {
        let time = (i as f64 * 0.618_034).fract() as f32;
        let from = (from - Vec3A::new(0.2, 0.6, 0.4)) * 7.0;
        let ray =
            Ray { time, ..Ray::new(from, Vec3A::from(warp::square_to_uniform_sphere(to.into()))) };
        let found: Vec<_> = engines.iter().map(|engine| engine.closest_hit(&ray)).collect();
        for pair in found.windows(2) {
            match (pair[0], pair[1]) {
                (Some(a), Some(b)) => {
                    let same = (a.shape, a.primitive) == (b.shape, b.primitive)
                        && (a.t - b.t).abs() <= 1e-4 * a.t;
                    differences += u32::from(!same);
                    hits += 1;
                }
                (a, b) => differences += u32::from(a.is_some() != b.is_some()),
            }
        }
        for (engine, hit) in engines.iter().zip(&found) {
            assert_eq!(engine.occluded(&ray), hit.is_some(), "{ray:?}");
        }
    }
    // Edges within the rounding of f32 in Embree's own test, whose t is off by up to 7e-5 at grazing angles.
    assert!(engines.len() < 2 || hits > 5000, "{hits}");
    assert!(differences <= 4, "{differences}");
}

/// A cube that turns as it passes a lit floor, seen by a camera that moves, too.
fn scene(shutter: (f64, f64), spp: u32, seed: u32) -> Description {
    let (open, close) = shutter;
    parse(&format!(
        r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="3"/></integrator>
    <sensor type="perspective">
        <animation name="to_world">
            <transform time="0"><lookat origin="0, 2, 6" target="0, 0.5, 0" up="0, 1, 0"/></transform>
            <transform time="2"><lookat origin="2, 2, 6" target="0, 0.5, 0" up="0, 1, 0"/></transform>
        </animation>
        <float name="fov" value="35"/>
        <float name="shutter_open" value="{open}"/>
        <float name="shutter_close" value="{close}"/>
        <sampler type="independent">
            <integer name="sample_count" value="{spp}"/>
            <integer name="seed" value="{seed}"/>
        </sampler>
        <film type="hdrfilm">
            <integer name="width" value="12"/>
            <integer name="height" value="8"/>
            <rfilter type="box"/>
        </film>
    </sensor>
    <emitter type="constant"/>
    <shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="-90"/><scale value="4"/></transform>
    </shape>
    <shape type="cube">
        <bsdf type="diffuse"><rgb name="reflectance" value="0.1, 0.4, 0.8"/></bsdf>
        <animation name="to_world">
            <transform time="0"><scale value="0.5"/><translate x="-1" y="0.6"/></transform>
            <transform time="1">
                <scale value="0.5"/><rotate y="1" angle="40"/><translate x="1" y="0.6"/>
            </transform>
        </animation>
    </shape>
</scene>"#
    ))
}

/// The mean of many still pictures, each at a random moment, is the picture of the open shutter.
#[test]
fn a_shutter_is_the_mean_of_its_moments() {
    for &backend in Backend::AVAILABLE {
        compare_with_moments(backend);
    }
}

fn compare_with_moments(backend: Backend) {
    const PICTURES: u32 = 96;
    let moments = points(7, PICTURES).enumerate();
    let stills: Vec<_> = moments
        .map(|(i, u)| {
            // Stratified: the moments are spread as those of samples are, with less noise.
            let time = (i as f64 + f64::from(u.x)) / f64::from(PICTURES);
            picture(&scene((time, time), 4, i as u32), backend).radiance()
        })
        .collect();
    let of = |shutter| -> Vec<_> {
        (0..PICTURES).map(|i| picture(&scene(shutter, 4, 1000 + i), backend).radiance()).collect()
    };
    let (open, half) = (of((0.0, 1.0)), of((0.0, 0.5)));
    let pixels = stills[0].len();
    let level = significance_each(pixels * Backend::AVAILABLE.len());
    let at = |pictures: &[Vec<Vec3A>], i: usize| {
        Moments::of(pictures.iter().map(|p| f64::from(p[i].element_sum())))
    };
    let worst = |a: &[Vec<Vec3A>], b: &[Vec<Vec3A>]| {
        let p = |i| welch(&at(a, i), &at(b, i), 1e-12);
        (0..pixels).map(p).fold(1.0, f64::min)
    };
    let p = worst(&stills, &open);
    assert!(p >= level, "{backend}: {p} < {level}");
    // Half of the time shows another picture.
    let p = worst(&stills, &half);
    assert!(p < level, "{backend}: {p}");
}

/// A shutter without length is no motion: the same picture, to the last bit, as of what stands where it is at
/// that moment, and no time is sampled.
#[test]
fn a_shutter_without_length_is_still() {
    let still = scene((0.25, 0.25), 4, 1);
    assert!(!still.moves() && !Requirements::of(&still).models(Feature::Time));
    let moved = scene((0.0, 1.0), 4, 1);
    assert!(moved.moves() && Requirements::of(&moved).models(Feature::Time));
    let map = |keys: [DAffine3; 2], time: f64| {
        Motion::new(vec![(0.0, keys[0]), (1.0, keys[1])]).expect("ascending").at(time)
    };
    let place = |x: f64, angle: f64| {
        DAffine3::from_translation(DVec3::new(x, 0.6, 0.0))
            * DAffine3::from_rotation_y(f64::to_radians(angle))
            * DAffine3::from_scale(DVec3::splat(0.5))
    };
    let expected = map([place(-1.0, 0.0), place(1.0, 40.0)], 0.25);
    let cube = &still.scene.objects()[1].shape;
    let (flat, _) = primitives::cube(expected, false);
    let (a, b) = (cube.bounds(), flat.bounds());
    assert!(a.min.abs_diff_eq(b.min, 1e-6) && a.max.abs_diff_eq(b.max, 1e-6));
    // Neither a group nor a map remains of the animation.
    assert_eq!(cube.kind(), "TriangleMesh");
}
