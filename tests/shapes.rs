//! Surfaces: texture coordinates and normals as Mitsuba 3 has them, exact positions, and rays that
//! leave without meeting the same surface again.

mod support;

use std::f32::consts::{PI, SQRT_2};
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3A};
use support::meshes::engines;
use support::points;
use support::rays::trace;
use telamon::math::{Frame, warp};
use telamon::ray::Ray;
use telamon::shape::{Cylinder, Disk, Shape, Sphere, SurfacePoint, TriangleMesh, primitives};

fn scaled(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_scale(DVec3::new(x, y, z))
}

/// A ray towards a shape, and what Mitsuba 3.7 (`scalar_rgb`, `ray_intersect`) says it finds there:
/// `si.uv` and `si.sh_frame.n`.
struct Expected {
    origin: [f32; 3],
    direction: [f32; 3],
    uv: [f32; 2],
    normal: [f32; 3],
}

const fn seen(origin: [f32; 3], direction: [f32; 3], uv: [f32; 2], normal: [f32; 3]) -> Expected {
    Expected { origin, direction, uv, normal }
}

fn assert_seen(name: &str, shape: &dyn Shape, expected: &[Expected]) {
    for e in expected {
        let ray = Ray::new(e.origin, e.direction);
        let hit = trace(shape, &ray).unwrap_or_else(|| panic!("{name}: missed"));
        let (uv, point) = (shape.uv(&ray, &hit), shape.surface(&ray, &hit));
        // The literals have six digits.
        assert!((uv - Vec2::from(e.uv)).length() < 2e-6, "{name}: uv {uv}, expected {:?}", e.uv);
        let normal = Vec3A::from(e.normal);
        assert!((point.shading_normal - normal).length() < 2e-6, "{name}: {point:?}");
        assert!((point.geometric_normal - normal).length() < 2e-6, "{name}: {point:?}");
    }
}

const DOWN: [f32; 3] = [0.0, 0.0, -1.0];

#[test]
fn rectangles_are_those_of_mitsuba() {
    let at = |uv, normal| [seen([0.5, 0.25, 3.0], DOWN, uv, normal)];
    let up = [0.0, 0.0, 1.0];
    for (name, to_world, flip, uv, normal) in [
        ("plain", scaled(1.0, 1.0, 1.0), false, [0.75, 0.625], up),
        ("flipped", scaled(1.0, 1.0, 1.0), true, [0.75, 0.625], DOWN),
        // The normal goes with the inverse transpose: x mirrored leaves it, z mirrored turns it.
        ("mirrored in x", scaled(-1.0, 1.0, 1.0), false, [0.25, 0.625], up),
        ("mirrored in z", scaled(1.0, 1.0, -1.0), false, [0.75, 0.625], DOWN),
    ] {
        assert_seen(name, &primitives::rectangle(to_world, flip).0, &at(uv, normal));
    }
}

#[test]
fn cubes_are_those_of_mitsuba() {
    let faces = [
        seen([3.0, 0.5, 0.25], [-1.0, 0.0, 0.0], [0.75, 0.375], [1.0, 0.0, 0.0]),
        seen([-3.0, 0.5, 0.25], [1.0, 0.0, 0.0], [0.75, 0.625], [-1.0, 0.0, 0.0]),
        seen([0.5, 3.0, 0.25], [0.0, -1.0, 0.0], [0.25, 0.375], [0.0, 1.0, 0.0]),
        seen([0.5, -3.0, 0.25], [0.0, 1.0, 0.0], [0.625, 0.75], [0.0, -1.0, 0.0]),
        seen([0.5, 0.25, 3.0], DOWN, [0.625, 0.75], [0.0, 0.0, 1.0]),
        seen([0.5, 0.25, -3.0], [0.0, 0.0, 1.0], [0.375, 0.75], [0.0, 0.0, -1.0]),
    ];
    assert_seen("cube", &primitives::cube(scaled(1.0, 1.0, 1.0), false).0, &faces);
    let mirrored = [
        seen([3.0, 0.5, 0.25], [-1.0, 0.0, 0.0], [0.75, 0.625], [1.0, 0.0, 0.0]),
        seen([-3.0, 0.5, 0.25], [1.0, 0.0, 0.0], [0.75, 0.375], [-1.0, 0.0, 0.0]),
    ];
    assert_seen("mirrored", &primitives::cube(scaled(-1.0, 1.0, 1.0), false).0, &mirrored);
    let flipped = [seen([3.0, 0.5, 0.25], [-1.0, 0.0, 0.0], [0.75, 0.375], [-1.0, 0.0, 0.0])];
    assert_seen("flipped", &primitives::cube(scaled(1.0, 1.0, 1.0), true).0, &flipped);
}

/// u is the azimuth in turns: atan(0.8 / 0.6) / 2π = 0.147584. v is the polar angle in half turns:
/// acos(0.8) / π = 0.204833.
#[test]
fn spheres_are_those_of_mitsuba() {
    let world = Frame { s: Vec3A::X.into(), t: Vec3A::Y.into(), n: Vec3A::Z.into() };
    let expected = [
        seen([0.6, 3.0, 0.0], [0.0, -1.0, 0.0], [0.147_584, 0.5], [0.6, 0.8, 0.0]),
        seen([0.6, -3.0, 0.0], [0.0, 1.0, 0.0], [0.852_416, 0.5], [0.6, -0.8, 0.0]),
        seen([-0.6, 0.0, 3.0], DOWN, [0.5, 0.204_833], [-0.6, 0.0, 0.8]),
        seen([-0.6, 0.0, -3.0], [0.0, 0.0, 1.0], [0.5, 0.795_167], [-0.6, 0.0, -0.8]),
    ];
    assert_seen("sphere", &Sphere::new(Vec3A::ZERO, 1.0, world, false), &expected);
    // Turned by 90 degrees about x: y goes to z, z to -y.
    let turned = Frame { s: Vec3A::X.into(), t: Vec3A::Z.into(), n: Vec3A::NEG_Y.into() };
    let expected = [seen([0.0, 0.6, 3.0], DOWN, [0.25, 0.704_833], [0.0, 0.6, 0.8])];
    assert_seen("turned", &Sphere::new(Vec3A::ZERO, 1.0, turned, false), &expected);
    let expected = [seen([0.6, 3.0, 0.0], [0.0, -1.0, 0.0], [0.147_584, 0.5], [-0.6, -0.8, 0.0])];
    assert_seen("flipped", &Sphere::new(Vec3A::ZERO, 1.0, world, true), &expected);
}

/// u is the radius, v the azimuth in turns.
#[test]
fn disks_are_those_of_mitsuba() {
    let disk = |to_world, flip| Disk::new(to_world, flip).expect("not singular");
    let up = [0.0, 0.0, 1.0];
    let plain = [
        seen([0.3, 0.4, 3.0], DOWN, [0.5, 0.147_584], up),
        seen([0.3, -0.4, 3.0], DOWN, [0.5, 0.852_416], up),
        seen([-0.3, 0.4, 3.0], DOWN, [0.5, 0.352_416], up),
    ];
    assert_seen("disk", &disk(scaled(1.0, 1.0, 1.0), false), &plain);
    let one = |uv, normal| [seen([0.3, 0.4, 3.0], DOWN, uv, normal)];
    let mirrored = disk(scaled(-1.0, 1.0, 1.0), false);
    assert_seen("mirrored in x", &mirrored, &one([0.5, 0.352_416], up));
    let mirrored = disk(scaled(1.0, 1.0, -1.0), false);
    assert_seen("mirrored in z", &mirrored, &one([0.5, 0.147_584], DOWN));
    assert_seen("flipped", &disk(scaled(1.0, 1.0, 1.0), true), &one([0.5, 0.147_584], DOWN));
}

/// A cylinder from `p0` to `p1` whose u begins where Mitsuba lets it begin.
fn cylinder(p0: [f64; 3], p1: [f64; 3], radius: f64, flip: bool) -> Cylinder {
    let along = DVec3::from(p1) - DVec3::from(p0);
    let frame = Frame::from_normal(along.normalize().as_vec3a().into());
    let [s, t] = [frame.s, frame.t].map(|v| Vec3A::from(v).as_dvec3() * radius);
    Cylinder::new(p0.into(), [s, t, along], flip).expect("has an area")
}

/// u is the azimuth in turns, v the height. Mirrors turn no normals.
#[test]
fn cylinders_are_those_of_mitsuba() {
    let left = [-1.0, 0.0, 0.0];
    let plain = [
        seen([3.0, 0.6, 0.25], left, [0.102_416, 0.25], [0.8, 0.6, 0.0]),
        seen([-3.0, 0.6, 0.25], [1.0, 0.0, 0.0], [0.397_584, 0.25], [-0.8, 0.6, 0.0]),
        seen([0.0, 0.0, 0.5], [0.6, -0.8, 0.0], [0.852_416, 0.5], [0.6, -0.8, 0.0]),
    ];
    let (zero, up) = ([0.0; 3], [0.0, 0.0, 1.0]);
    assert_seen("cylinder", &cylinder(zero, up, 1.0, false), &plain);
    let flipped = [seen([3.0, 0.6, 0.25], left, [0.102_416, 0.25], [-0.8, -0.6, 0.0])];
    assert_seen("flipped", &cylinder(zero, up, 1.0, true), &flipped);
    let slanted = [
        seen([4.5, 3.0, 4.0], left, [0.977_416, 0.558_926], [0.942_809, -0.235_702, -0.235_702]),
        seen([1.5, 3.0, 9.0], DOWN, [0.676_208, 0.649_071], [-0.298_142, -0.596_285, 0.745_356]),
    ];
    let p0 = [1.0, 2.0, 3.0];
    assert_seen("slanted", &cylinder(p0, [2.0, 4.0, 5.0], 0.5, false), &slanted);
    let below = [seen([3.0, 0.1, 0.4], left, [0.967_953, 0.560_18], [0.966_465, 0.2, 0.161_077])];
    assert_seen("below", &cylinder([0.0, 0.0, 2.0], [0.5, 0.0, -1.0], 0.5, false), &below);
    let mirrored = |axes| Cylinder::new(DVec3::ZERO, axes, false).expect("has an area");
    let one = |uv| [seen([3.0, 0.6, 0.25], left, uv, [0.8, 0.6, 0.0])];
    let in_x = mirrored([DVec3::NEG_X, DVec3::Y, DVec3::Z]);
    assert_seen("mirrored in x", &in_x, &one([0.397_584, 0.25]));
    let down = [seen([3.0, 0.6, -0.25], left, [0.102_416, 0.25], [0.8, 0.6, 0.0])];
    let in_z = mirrored([DVec3::X, DVec3::Y, DVec3::NEG_Z]);
    assert_seen("mirrored in z", &in_z, &down);
}

/// Rays beside it, along it, through its ends and past them.
#[test]
fn cylinders_are_open() {
    let cylinder = cylinder([0.0; 3], [0.0, 0.0, 2.0], 1.0, false);
    let t = |origin: [f32; 3], direction: [f32; 3]| {
        let direction = Vec3A::from(direction).normalize();
        trace(&cylinder, &Ray::new(origin, direction)).map(|hit| hit.t)
    };
    assert_eq!(t([0.0, 0.0, -1.0], [0.0, 0.0, 1.0]), None);
    assert_eq!(t([1.0, 0.0, -1.0], [0.0, 0.0, 1.0]), None);
    assert_eq!(t([3.0, 0.0, 2.5], [-1.0, 0.0, 0.0]), None);
    assert_eq!(t([3.0, 1.5, 1.0], [-1.0, 0.0, 0.0]), None);
    assert_eq!(t([3.0, 0.0, 1.0], [-1.0, 0.0, 0.0]), Some(2.0));
    // In through the open end, onto the wall from inside.
    let through = t([0.5, 0.0, 3.0], [-1.0, 0.0, -1.0]).expect("the wall");
    assert!((through - 1.5 * SQRT_2).abs() < 1e-6, "{through}");
    let steep = t([3.0, 0.0, 5.0], [-1.0, 0.0, -1.0]).expect("the far wall");
    assert!((steep - 4.0 * SQRT_2).abs() < 1e-5, "{steep}");
}

/// `si.dp_du` and `si.dp_dv` of Mitsuba 3.9.1 for the same rays; 0 where there is none.
#[test]
fn tangents_are_those_of_mitsuba() {
    let world = Frame { s: Vec3A::X.into(), t: Vec3A::Y.into(), n: Vec3A::Z.into() };
    let turned = Frame { s: Vec3A::X.into(), t: Vec3A::Z.into(), n: Vec3A::NEG_Y.into() };
    let sphere = |radius, axes, flip| Sphere::new(Vec3A::ZERO, radius, axes, flip);
    let disk = Disk::new(scaled(2.0, 3.0, 1.0), false).expect("not singular");
    let rectangle = |x| primitives::rectangle(scaled(x, 3.0, 1.0), false).0;
    let cube = primitives::cube(scaled(1.0, 1.0, 1.0), false).0;
    type Pair = [[f32; 3]; 2];
    let tube = cylinder([0.0, 0.0, 2.0], [0.5, 0.0, -1.0], 0.5, true);
    let cases: [(&str, &dyn Shape, Pair, Pair); 10] = [
        (
            "rectangle",
            &rectangle(2.0),
            [[0.5, 0.25, 3.0], DOWN],
            [[4.0, 0.0, 0.0], [0.0, 6.0, 0.0]],
        ),
        (
            "mirrored rectangle",
            &rectangle(-2.0),
            [[0.5, 0.25, 3.0], DOWN],
            [[-4.0, 0.0, 0.0], [0.0, 6.0, 0.0]],
        ),
        ("cube", &cube, [[3.0, 0.5, 0.25], [-1.0, 0.0, 0.0]], [[0.0, 2.0, 0.0], [0.0, 0.0, -2.0]]),
        (
            "sphere",
            &sphere(2.0, world, false),
            [[-1.2, 0.0, 3.0], DOWN],
            [[0.0, -7.539_823, 0.0], [-5.026_548, 0.0, -3.769_912]],
        ),
        (
            "turned sphere",
            &sphere(1.0, turned, false),
            [[0.0, 0.6, 3.0], DOWN],
            [[-5.026_548, 0.0, 0.0], [0.0, 2.513_274, -1.884_956]],
        ),
        (
            "flipped sphere",
            &sphere(1.0, world, true),
            [[0.6, 3.0, 0.0], [0.0, -1.0, 0.0]],
            [[-5.026_548, 3.769_912, 0.0], [0.0, 0.0, -PI]],
        ),
        ("pole", &sphere(1.0, world, false), [[0.0, 0.0, 3.0], DOWN], [[0.0; 3], [PI, 0.0, 0.0]]),
        (
            "disk",
            &disk,
            [[0.6, 0.9, 3.0], DOWN],
            [[SQRT_2, 2.121_32, 0.0], [-3.769_911, 5.654_867, 0.0]],
        ),
        (
            "cylinder",
            &tube,
            [[3.0, 0.1, 0.4], [-1.0, 0.0, 0.0]],
            [[0.619_77, -3.078_12, 0.103_295], [0.5, 0.0, -3.0]],
        ),
        ("centre", &disk, [[0.0, 0.0, 3.0], DOWN], [[0.0; 3]; 2]),
    ];
    for (name, shape, [origin, direction], expected) in cases {
        let ray = Ray::new(origin, direction);
        let hit = trace(shape, &ray).unwrap_or_else(|| panic!("{name}: missed"));
        for (found, expected) in shape.tangents(&ray, &hit).into_iter().zip(expected) {
            let off = (found - Vec3A::from(expected)).length();
            assert!(off < 5e-6, "{name}: {found}, expected {expected:?}");
        }
    }
}

/// Texture coordinates that are turned, mirrored and stretched; without any, two directions along the
/// triangle.
#[test]
fn tangents_of_meshes_follow_their_texture_coordinates() {
    let corners = [Vec3A::ZERO, Vec3A::new(2.0, 0.0, 1.0), Vec3A::new(0.0, 3.0, -1.0)];
    let mesh = |uvs: Vec<Vec2>| {
        let mesh = TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2]], Vec::new(), uvs);
        mesh.expect("valid").0
    };
    let ray = Ray::new([0.5, 0.5, 5.0], DOWN);
    let of = |mesh: &TriangleMesh| mesh.tangents(&ray, &trace(mesh, &ray).expect("hit"));
    let uvs = [Vec2::new(0.25, 0.5), Vec2::new(0.25, 0.0), Vec2::new(0.75, 0.25)];
    let [du, dv] = of(&mesh(uvs.to_vec()));
    for (corner, uv) in [(1, uvs[1] - uvs[0]), (2, uvs[2] - uvs[0])] {
        assert!((du * uv.x + dv * uv.y - corners[corner]).length() < 1e-6);
    }
    let normal = corners[1].cross(corners[2]).normalize();
    for uvs in [Vec::new(), vec![Vec2::ONE; 3]] {
        let [du, dv] = of(&mesh(uvs));
        assert!((du.cross(dv) - normal).length() < 1e-6, "{du} {dv}");
    }
}

/// The normal of a distant sphere, for a ray taken as exact: the rounding of t moves the point by
/// 6e-8 of the distance along the ray, which is much against the radius.
#[test]
fn distant_spheres_have_exact_normals() {
    for (radius, distance) in [(1.0f32, 1e3f32), (1.0, 1e6), (1e-3, 1e3), (1e-6, 1.0)] {
        let axis = Vec3A::new(1.0, 2.0, 3.0).normalize();
        let sphere =
            Sphere::new(axis * distance, radius, Frame::from_normal(Vec3A::Z.into()), false);
        let center = (axis * distance).as_dvec3();
        let mut hits = 0;
        for u in points(1, 10_000) {
            let across = Vec3A::from(
                Frame::from_normal(axis.into()).to_world((u * 1.8 - 0.9).extend(0.0).into()),
            );
            // Parallel to the line to the centre, so that most rays hit.
            let ray = Ray::new(across * radius, axis);
            let Some(hit) = trace(&sphere, &ray) else {
                continue;
            };
            hits += 1;
            let (o, d) = (ray.origin.as_dvec3() - center, ray.direction.as_dvec3());
            let (a, b) = (d.length_squared(), o.dot(d));
            let closest = o - d * (b / a);
            let half = ((f64::from(radius).powi(2) - closest.length_squared()) / a).sqrt();
            let exact = (closest - d * half) / f64::from(radius);
            let normal = sphere.surface(&ray, &hit).geometric_normal.as_dvec3();
            // One rounding for each coordinate.
            assert!((normal - exact).length() < 2e-7, "{radius} at {distance}: {normal}, {exact}");
        }
        assert!(hits > 1_000, "{radius} at {distance}: only {hits} hits");
    }
}

const CENTERS: [f32; 4] = [0.0, 1.0, -100.0, 1e5];

/// Rays that leave a sphere to either side, in each engine: outwards none comes back, inwards each meets the far side.
#[test]
fn rays_leave_spheres() {
    for (size, center) in [1e-3f32, 1.0, 1e3].into_iter().flat_map(|s| CENTERS.map(|c| (s, c))) {
        let center = Vec3A::new(center, -0.7 * center, 0.3 * center);
        let sphere = Sphere::new(center, size, Frame::from_normal(Vec3A::Z.into()), false);
        for engine in engines(&[Arc::new(sphere)]) {
            for (a, b) in points(11, 2_000).zip(points(12, 2_000)) {
                let side = Vec3A::from(warp::square_to_uniform_sphere(a.into()));
                let ray = Ray::new(center + side * (3.0 * size), -side);
                let Some(hit) = trace(&sphere, &ray) else {
                    continue;
                };
                let point = sphere.surface(&ray, &hit);
                let direction = Vec3A::from(warp::square_to_uniform_sphere(b.into()));
                let cosine = direction.dot(point.geometric_normal);
                let again = engine.closest_hit(&point.spawn(direction)).map(|h| h.t);
                if cosine >= 0.0 {
                    assert_eq!(again, None, "{size} at {center}: {direction} from {point:?}");
                    continue;
                }
                // The far end of the chord, from a start that is off by the lift; shorter ones are shorter than that.
                let (chord, lift) = (-2.0 * size * cosine, point.end_towards(direction).lift());
                if chord > 100.0 * lift {
                    let t = again.unwrap_or_else(|| panic!("{size} at {center}: no far side"));
                    let slack = 4.0 * lift / -cosine + 1e-5 * size;
                    assert!((t - chord).abs() < slack, "{size} at {center}: {t}, chord {chord}");
                }
            }
        }
    }
}

/// Rays that leave a cylinder to either side: outwards none comes back; inwards each meets the far side or leaves
/// through an end.
#[test]
fn rays_leave_cylinders() {
    for (size, center) in [1e-3f64, 1.0, 1e3].into_iter().flat_map(|s| CENTERS.map(|c| (s, c))) {
        let base = f64::from(center) * DVec3::new(1.0, -0.7, 0.3);
        let top = base + DVec3::new(1.0, 2.0, -2.0) * size;
        let cylinder = cylinder(base.into(), top.into(), size, false);
        for engine in engines(&[Arc::new(cylinder)]) {
            for (a, b) in points(41, 2_000).zip(points(42, 2_000)) {
                let s = cylinder.sample_primitive(0, DVec3::splat(3e5), a).expect("seen");
                let direction = Vec3A::from(warp::square_to_uniform_sphere(b.into()));
                let cosine = direction.dot(s.point.geometric_normal);
                let again = engine.closest_hit(&s.point.spawn(direction)).map(|hit| hit.t);
                if cosine >= 0.0 {
                    assert_eq!(again, None, "{size} at {center}: {direction} from {:?}", s.point);
                    continue;
                }
                // The far end of the chord, by the angle to the axis.
                let axis = DVec3::new(1.0, 2.0, -2.0) / 3.0;
                let sine = direction.as_dvec3().cross(axis).length() as f32;
                let chord = -2.0 * size as f32 * cosine / (sine * sine);
                let lift = s.point.end_towards(direction).lift();
                let slack = 8.0 * lift / -cosine / sine + 1e-5 * size as f32 / sine;
                if let Some(t) = again.filter(|_| chord > 100.0 * lift) {
                    assert!((t - chord).abs() < slack, "{size} at {center}: {t}, chord {chord}");
                }
            }
        }
    }
}

/// Rays that leave a disk never meet it again.
#[test]
fn rays_leave_disks() {
    for (size, center) in [1e-6f64, 1.0, 1e3].into_iter().flat_map(|s| CENTERS.map(|c| (s, c))) {
        let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0);
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.5, 2.0, 0.0), DVec3::Z);
        let offset = f64::from(center) * DVec3::new(1.0, -0.7, 0.3);
        let to_world = DAffine3::from_mat3_translation(turn * shear * size, offset);
        let disk = Disk::new(to_world, false).expect("not singular");
        for engine in engines(&[Arc::new(disk)]) {
            for (a, b) in points(21, 2_000).zip(points(22, 2_000)) {
                let s = disk.sample_primitive(0, DVec3::splat(3e5), a).expect("seen");
                let direction = Vec3A::from(warp::square_to_uniform_sphere(b.into()));
                let again = engine.closest_hit(&s.point.spawn(direction));
                assert_eq!(again, None, "{size} at {center}: {direction}");
            }
        }
    }
}

/// pbrt's recipe: triangles whose coordinates range over 16 decades. A ray starts on the side that it
/// goes to, clear of the exact plane by a good part of the lift, and no farther than the lift and two roundings.
#[test]
fn rays_leave_triangles_on_their_own_side() {
    let coordinates = |seed| {
        points(seed, 9_000)
            .map(|u| 10f64.powf(16.0 * f64::from(u.x) - 8.0).copysign(f64::from(u.y) - 0.5))
    };
    let all: Vec<f32> = coordinates(31).map(|x| x as f32).collect();
    let mut tested = 0;
    for corners in all.chunks(9) {
        let corners = [0, 3, 6].map(|i| Vec3A::new(corners[i], corners[i + 1], corners[i + 2]));
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        let across = (b - a).cross(c - a);
        if across.length_squared() < 1e-20 {
            continue;
        }
        let exact_normal = across.normalize();
        let positions = corners.map(Into::into).into();
        let (mesh, _) =
            TriangleMesh::new(positions, vec![[0, 1, 2]], Vec::new(), Vec::new()).expect("valid");
        for (u, w) in points(32, 100).zip(points(33, 100)) {
            let Some(s) = mesh.sample_primitive(0, DVec3::splat(1e9), u) else {
                continue;
            };
            assert_leaves(
                &s.point,
                [a, b, c],
                exact_normal,
                Vec3A::from(warp::square_to_uniform_sphere(w.into())),
            );
            tested += 1;
        }
    }
    assert!(tested > 80_000, "only {tested} rays");
}

fn assert_leaves(point: &SurfacePoint, corners: [DVec3; 3], exact_normal: DVec3, direction: Vec3A) {
    let error = (point.geometric_normal.as_dvec3() - exact_normal).length();
    // Rounded to f32 three times: the product of the edges, its length, and their quotient.
    assert!(error < 1.8e-7, "normal {} is off by {error}", point.geometric_normal);
    let height = (point.position - corners[0]).dot(exact_normal).abs();
    let size = corners.iter().fold(0.0, |most: f64, p| most.max(p.abs().max_element()));
    // Two products and three sums in f64; and the roundings of this test, whose normal cancels for slivers.
    let [to_b, to_c] = [corners[1] - corners[0], corners[2] - corners[0]];
    let sharpness = to_b.length() * to_c.length() / to_b.cross(to_c).length();
    let rounding = 16.0 * f64::EPSILON * size * (1.0 + sharpness);
    assert!(height <= rounding, "{height} above the plane, whose corners reach to {size}");
    let cosine = f64::from(direction.dot(point.geometric_normal));
    if cosine.abs() < 1e-6 {
        return;
    }
    let start = (point.leave_towards(direction).0.as_dvec3() - corners[0]).dot(exact_normal);
    let (start, lift) = (start * cosine.signum(), f64::from(point.end_towards(direction).lift()));
    // The point and the start are rounded, each by a quarter of the lift at most.
    let range = 0.499 * lift - rounding..1.501 * lift + rounding;
    assert!(range.contains(&start), "starts at {start}, lift {lift}");
}

/// Two squares 1e-6 apart at coordinates near 1 do not hide each other, however large they are.
#[test]
fn lifts_are_small() {
    for half in [1.0, 1e6] {
        let to_world = DAffine3::from_translation(DVec3::ONE) * scaled(half, half, 1.0);
        let square = primitives::rectangle(to_world, false).0;
        let ray = Ray::new(Vec3A::new(1.2, 1.1, 5.0), Vec3A::NEG_Z);
        let hit = trace(&square, &ray).expect("in front");
        let lift = square.surface(&ray, &hit).end_towards(Vec3A::Z).lift();
        // 4 · 2⁻²⁴ · |z| with z = 1, and 2⁻⁴⁰ of the coordinates.
        assert!((4.0 / 16_777_216.0..4.001 / 16_777_216.0).contains(&lift), "{lift}");
    }
}
