//! Texture coordinates, normals and tangents as Mitsuba 3 has them.

use std::f32::consts::{PI, SQRT_2};

use crate::support::rays::trace;
use crate::{cylinder, scaled};
use glam::{DVec3, Vec2, Vec3A};
use telamon::math::Frame;
use telamon::ray::Ray;
use telamon::shape::{Cylinder, Disk, Shape, Sphere, TriangleMesh, primitives};

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
