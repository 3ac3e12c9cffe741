//! Meshes that engines have trouble with.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3A};
use telamon::math::{Frame, Motion};
use telamon::parity::Budget;
use telamon::shape::{Cylinder, DeformingMesh, Disk, Group, Instance, Shape, Sphere, primitives};

use crate::lattice::Lattice;
use crate::support::meshes::{mesh, sphere_mesh, sphere_mesh_and_dropped};

/// What the rays are fired at.
pub(crate) struct Subject {
    pub(crate) name: &'static str,
    pub(crate) shapes: Vec<Arc<dyn Shape>>,
    /// Whether coordinates are so large against the triangles that fast modes lose rays by the percent.
    pub(crate) is_far: bool,
}

impl Subject {
    /// As much as `budget`, but for modes without a promise where coordinates are large against the triangles:
    /// Embree's fast mode loses 0.7 % of all random rays there.
    pub(crate) fn budget(&self, budget: Budget) -> Budget {
        match budget {
            Budget { random, aimed } if self.is_far && random >= Budget::FAST.random => {
                Budget { random: 0.02, aimed }
            }
            budget => budget,
        }
    }
}

/// Closed and open, of 12 to more than 100,000 triangles, well and badly shaped.
pub(crate) fn all() -> Vec<Subject> {
    let near = |name, shapes| Subject { name, shapes, is_far: false };
    vec![
        near("cube", vec![cube()]),
        near("sphere with poles", vec![uv_sphere(40, 40)]),
        near("icosphere", vec![icosphere(5)]),
        near("bowl", vec![uv_sphere(60, 40)]),
        near("slivers", vec![sliver_tube()]),
        near("grid", vec![grid(64)]),
        near("gyroid", vec![gyroid(0.03)]),
        near("coincident faces", vec![cube(), cube(), ball(), disk(), tube()]),
        near("instances and time", instances()),
        near("deforming", vec![deforming(), cube()]),
        near("tiny", vec![sphere(DVec3::ZERO, 1e-6, 40)]),
        near("huge", vec![sphere(DVec3::ZERO, 1e6, 40)]),
        Subject {
            name: "far away",
            shapes: vec![sphere(DVec3::splat(1e5), 2.0, 100)],
            is_far: true,
        },
    ]
}

/// Too large for each day.
pub(crate) fn large() -> Subject {
    Subject { name: "gyroid, fine", shapes: vec![gyroid(0.0114)], is_far: false }
}

pub(crate) fn cube() -> Arc<dyn Shape> {
    Arc::new(primitives::cube(DAffine3::IDENTITY, false).0)
}

/// A group of a mesh, a sphere and a cube that fit into each other: at rest, mirrored, stretched, and moving
/// as it turns and grows, in front of a square that slides away.
fn instances() -> Vec<Arc<dyn Shape>> {
    let group = |shapes| Arc::new(Group::new(shapes).expect("no instance"));
    let figure = group(vec![sphere(DVec3::ZERO, 1.2, 20), ball(), cube()]);
    let floor = group(vec![grid(16)]);
    let still = |map| -> Arc<dyn Shape> {
        Arc::new(Instance::new(Arc::clone(&figure), map).expect("not singular"))
    };
    let moving = |group: &Arc<Group>, keys: Vec<(f64, DAffine3)>| -> Arc<dyn Shape> {
        let motion = Motion::new(keys).expect("ascending");
        Arc::new(Instance::moving(Arc::clone(group), motion).expect("not singular"))
    };
    let place = |scale: f64, turn: f64, x: f64| {
        DAffine3::from_scale_rotation_translation(
            DVec3::splat(scale),
            glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 2.0) / 3.0, turn),
            DVec3::new(x, 3.0, 1.0),
        )
    };
    let slide = |x: f64| DAffine3::from_translation(DVec3::new(x, -3.0, -4.0));
    vec![
        cube(),
        still(DAffine3::from_translation(DVec3::new(4.0, 0.0, 0.0))),
        still(DAffine3::from_scale(DVec3::new(-0.3, 2.0, 1.0))),
        moving(&figure, vec![(0.0, place(0.5, 0.0, -3.0)), (1.0, place(1.5, 1.2, 2.0))]),
        moving(&floor, vec![(0.0, slide(-8.0)), (0.4, slide(-8.0)), (1.0, slide(0.0))]),
    ]
}

/// A cube, and at its centre a sphere of 10⁻⁸ of its size with so many `rings`.
pub(crate) fn mixed_scales(rings: u32) -> Vec<Arc<dyn Shape>> {
    vec![cube(), sphere(DVec3::ZERO, 1e-8, rings)]
}

fn ball() -> Arc<dyn Shape> {
    Arc::new(Sphere::new(
        Vec3A::new(1.0, 0.5, 0.0),
        0.75,
        Frame::from_normal(Vec3A::Z.into()),
        false,
    ))
}

fn disk() -> Arc<dyn Shape> {
    let to_world = DAffine3::from_scale_rotation_translation(
        DVec3::new(1.5, 0.5, 1.0),
        glam::DQuat::from_rotation_x(0.7),
        DVec3::new(0.0, 1.5, 0.0),
    );
    Arc::new(Disk::new(to_world, false).expect("not singular"))
}

fn tube() -> Arc<dyn Shape> {
    let turn = glam::DQuat::from_rotation_z(0.4);
    let axes = [DVec3::X * 0.5, DVec3::Y * 0.5, DVec3::Z * 3.0].map(|v| turn * v);
    Arc::new(Cylinder::new(DVec3::new(-1.5, 0.0, -1.0), axes, false).expect("has an area"))
}

fn sphere(center: DVec3, radius: f64, rings: u32) -> Arc<dyn Shape> {
    // Far from the origin some triangles have no area left.
    Arc::new(sphere_mesh_and_dropped(center, radius, rings, 2 * rings).0)
}

/// A sphere that grows, drifts, and is thrown back.
fn deforming() -> Arc<dyn Shape> {
    let key = |time: f64, x: f64, radius: f64| {
        (time, Arc::new(sphere_mesh(DVec3::new(x, 0.2, -0.1), radius, 20, 40)))
    };
    let keys = vec![key(-0.5, -1.0, 0.5), key(0.4, 0.5, 1.5), key(1.0, 0.0, 0.7)];
    Arc::new(DeformingMesh::new(keys).expect("of one topology"))
}

/// A unit sphere by longitude and latitude, of which the first `kept` of `rings` rings are there. A pole is
/// as many vertices as there are meridians, all at one place.
fn uv_sphere(rings: u32, kept: u32) -> Arc<dyn Shape> {
    let segments = 2 * rings;
    let mut positions = Vec::new();
    for ring in 0..=kept {
        let theta = PI * f64::from(ring) / f64::from(rings);
        // The sine of π is not 0.
        let r = if ring == rings { 0.0 } else { theta.sin() };
        for segment in 0..segments {
            let phi = TAU * f64::from(segment) / f64::from(segments);
            positions.push(DVec3::new(r * phi.cos(), r * phi.sin(), theta.cos()).as_vec3a());
        }
    }
    let mut triangles = Vec::new();
    for ring in 0..kept {
        for segment in 0..segments {
            let at = |ring, segment| ring * segments + segment % segments;
            let (a, b) = (at(ring, segment), at(ring, segment + 1));
            let (c, d) = (at(ring + 1, segment), at(ring + 1, segment + 1));
            // At a pole one edge of the square is a point.
            triangles.extend((ring > 0).then_some([a, c, b]));
            triangles.extend((ring + 1 < rings).then_some([b, c, d]));
        }
    }
    Arc::new(mesh(positions, triangles))
}

/// A unit sphere of 20 · 4ⁿ nearly equal triangles.
fn icosphere(subdivisions: u32) -> Arc<dyn Shape> {
    let phi = 0.5 * (1.0 + 5f64.sqrt());
    let mut positions: Vec<DVec3> = [(1.0, phi), (-1.0, phi), (1.0, -phi), (-1.0, -phi)]
        .into_iter()
        .flat_map(|(a, b)| [DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)])
        .collect();
    let mut triangles = Vec::new();
    // Neighbours are 2 apart, all others farther.
    let near = |p: &[DVec3], i: usize, j: usize| (p[i].distance(p[j]) - 2.0).abs() < 1e-9;
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(&positions, i, j) && near(&positions, j, k) && near(&positions, i, k) {
                    let [a, b, c] = [i, j, k].map(|n| positions[n]);
                    let outward = (b - a).cross(c - a).dot(a) > 0.0;
                    let [i, j, k] = [i, j, k].map(|n| n as u32);
                    triangles.push(if outward { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    for _ in 0..subdivisions {
        let mut middles = std::collections::BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push(positions[a as usize] + positions[b as usize]);
                positions.len() as u32 - 1
            })
        };
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
        positions.iter_mut().for_each(|p| *p = p.normalize());
    }
    Arc::new(mesh(positions.into_iter().map(|p| p.as_vec3a()).collect(), triangles))
}

/// A closed tube of length 1 and 1.6e-4 around, of 200 flat sides: its triangles are a million times as
/// long as wide.
fn sliver_tube() -> Arc<dyn Shape> {
    const SIDES: u32 = 200;
    let radius = 1e-6 * f64::from(SIDES) / TAU;
    let mut positions = vec![Vec3A::ZERO, Vec3A::Z];
    for side in 0..SIDES {
        let phi = TAU * f64::from(side) / f64::from(SIDES);
        let foot = DVec3::new(radius * phi.cos(), radius * phi.sin(), 0.0);
        positions.extend([foot.as_vec3a(), (foot + DVec3::Z).as_vec3a()]);
    }
    let mut triangles = Vec::new();
    for side in 0..SIDES {
        let [a, b] = [side, (side + 1) % SIDES].map(|s| 2 + 2 * s);
        triangles.extend([[a, b, a + 1], [a + 1, b, b + 1], [0, b, a], [1, a + 1, b + 1]]);
    }
    Arc::new(mesh(positions, triangles))
}

/// A square of n × n unit squares on whole coordinates, so that rays meet vertices and edges exactly.
fn grid(n: u32) -> Arc<dyn Shape> {
    let width = n + 1;
    let positions =
        (0..width * width).map(|i| Vec3A::new((i % width) as f32, (i / width) as f32, 0.0));
    let squares = (0..n * n).map(|i| i / n * width + i % n);
    let triangles =
        squares.flat_map(|a| [[a, a + 1, a + width], [a + 1, a + width + 1, a + width]]);
    Arc::new(mesh(positions.collect(), triangles.collect()))
}

/// The figure of `examples/sculpt`.
fn gyroid(half_cell: f32) -> Arc<dyn Shape> {
    let sculpture = Lattice::new(half_cell).surface();
    let positions = sculpture.vertices.into_iter().map(Vec3A::from).collect();
    Arc::new(mesh(positions, sculpture.triangles))
}
