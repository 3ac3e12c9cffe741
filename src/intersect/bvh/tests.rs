//! The tree, from inside: its structure, and that neither it nor the processor changes an answer.

use std::cmp::Ordering;

use glam::Vec3A;

use super::node::ChildKind;
use super::*;
use crate::intersect::triangle::tests::Candidates;
use crate::intersect::triangle::{Corners, RayTriangle, TriangleHit, nearer};
use crate::math::{Aabb, Frame, warp};
use crate::sampler::{Independent, PathSampler};
use crate::shape::{Sphere, TriangleMesh};

type Scene = Vec<Arc<dyn Shape>>;

/// A mesh of triangles without common vertices.
fn soup(corners: impl IntoIterator<Item = [Vec3A; 3]>) -> Arc<dyn Shape> {
    let positions: Vec<_> = corners.into_iter().flatten().collect();
    let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    let mesh = TriangleMesh::new(positions, triangles.collect(), Vec::new(), Vec::new());
    Arc::new(mesh.expect("indices in range").0)
}

fn random(seed: u64, count: u32, triangle: impl Fn(&mut PathSampler) -> [Vec3A; 3]) -> Scene {
    let sampler = Independent::new(seed);
    let triangle = |i| triangle(&mut PathSampler::new(&sampler, i, 0));
    vec![soup((0..count).map(triangle))]
}

fn cube(u: &mut PathSampler) -> Vec3A {
    Vec3A::new(u.next_1d(), u.next_1d(), u.next_1d())
}

/// Three points of a box of `size` around a random point of the unit cube.
fn small_triangle(u: &mut PathSampler, size: f32) -> [Vec3A; 3] {
    let center = cube(u);
    [(); 3].map(|()| center + (cube(u) - 0.5) * size)
}

fn sphere(center: Vec3A, radius: f32) -> Arc<dyn Shape> {
    Arc::new(Sphere::new(center, radius, Frame::from_normal(Vec3A::Z.into()), false))
}

/// An axis-parallel grid of unit cubes, whose faces coincide.
fn cubes(side: u32) -> Arc<dyn Shape> {
    let mut corners = Vec::new();
    for cube in 0..side.pow(3) {
        let min = Vec3A::new(
            (cube % side) as f32,
            (cube / side % side) as f32,
            (cube / side / side) as f32,
        );
        for axis in 0..3 {
            let [a, b] = [Vec3A::AXES[(axis + 1) % 3], Vec3A::AXES[(axis + 2) % 3]];
            for o in [min, min + Vec3A::AXES[axis]] {
                corners.extend([[o, o + a, o + a + b], [o, o + a + b, o + b]]);
            }
        }
    }
    soup(corners)
}

/// Scenes that builders stumble over.
fn nasty() -> Vec<(&'static str, Scene)> {
    let unit = [Vec3A::ZERO, Vec3A::X, Vec3A::Y];
    let wide_range = |u: &mut PathSampler| {
        let mut magnitude = || 10f32.powf(56.0 * u.next_1d() - 38.0).copysign(u.next_1d() - 0.5);
        [(); 3].map(|()| Vec3A::new(magnitude(), magnitude(), magnitude()))
    };
    // Each twice as large as the one before and beside it: a split takes off the largest only.
    let doubling = (-125..60).map(|i| unit.map(|p| (p + Vec3A::ONE) * 2f32.powi(i)));
    vec![
        ("nothing", Vec::new()),
        ("an empty mesh", vec![soup([])]),
        ("one triangle", vec![soup([unit])]),
        ("one sphere", vec![sphere(Vec3A::ZERO, 1.0)]),
        ("eight triangles", random(1, 8, |u| small_triangle(u, 0.5))),
        ("nine triangles", random(1, 9, |u| small_triangle(u, 0.5))),
        ("coincident triangles", vec![soup(vec![unit; 100_000])]),
        ("coincident spheres", vec![sphere(Vec3A::ONE, 1.0); 1000]),
        ("spheres among triangles", {
            let mut scene = random(2, 1000, |u| small_triangle(u, 0.1));
            scene.extend((0..100).map(|i| sphere(Vec3A::splat(i as f32 / 100.0), 0.01)));
            scene.insert(0, soup([]));
            scene.push(soup(vec![[Vec3A::ZERO, Vec3A::X, Vec3A::ONE]; 3]));
            scene.push(sphere(Vec3A::splat(0.5), 0.3));
            scene
        }),
        ("a sphere larger than f32 can square", vec![sphere(Vec3A::ONE, 1e38), soup([unit; 3])]),
        (
            "slivers",
            random(3, 10_000, |u| {
                let [a, b] = [cube(u), cube(u)];
                [a, b, b + 1e-6 * cube(u)]
            }),
        ),
        (
            "huge coordinates",
            random(4, 10_000, |u| small_triangle(u, 0.1).map(|p| (p - 0.5) * 3.6e18)),
        ),
        ("tiny coordinates", random(5, 10_000, |u| small_triangle(u, 0.1).map(|p| p * 1e-37))),
        ("a range of 56 decades", random(6, 20_000, wide_range)),
        ("doubling", vec![soup(doubling)]),
        ("a grid of cubes", vec![cubes(12)]),
        ("small triangles", random(7, 50_000, |u| small_triangle(u, 0.02))),
    ]
}

fn build_mode(triangle: TriangleTest, scene: &Scene) -> Bvh {
    Bvh::new(RustModes { triangle }, scene).expect("few primitives")
}

#[test]
fn trees_are_valid() {
    for (name, scene) in nasty() {
        let bvh = build_mode(TriangleTest::Watertight, &scene);
        assert_eq!(bvh.validate(), Ok(()), "{name}");
    }
}

/// Not even where it is merged from the work of many.
#[test]
fn the_number_of_threads_does_not_change_the_tree() {
    let scene = random(8, 100_000, |u| small_triangle(u, 0.02));
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let bvh = pool.install(|| build_mode(TriangleTest::Watertight, &scene));
        (bvh.nodes, bvh.packs)
    };
    let one = build(1);
    assert!(one.0.len() > 1000);
    assert!(build(2) == one && build(7) == one);
}

#[test]
fn flaws_are_found() {
    let scene = random(9, 200, |u| small_triangle(u, 0.1));
    let flawed = |damage: &dyn Fn(&mut Bvh)| {
        let mut bvh = build_mode(TriangleTest::Watertight, &scene);
        damage(&mut bvh);
        bvh.validate().expect_err("damaged").to_string()
    };
    let child = |bvh: &Bvh, i| bvh.nodes[0].children().nth(i).expect("there are more");
    let set = |bvh: &mut Bvh, kind| {
        let (i, bounds, _) = child(bvh, 0);
        bvh.nodes[0].set(i, &bounds, Child::new(kind));
    };
    assert_eq!(
        flawed(&|bvh| set(bvh, ChildKind::Node(999))),
        format!(
            "node 0 refers to node 999, but there are {}",
            build_mode(TriangleTest::Plain, &scene).nodes.len()
        ),
    );
    assert_eq!(
        flawed(&|bvh| set(bvh, ChildKind::Shape(7))),
        "node 0 refers to shape 7, but there are 1",
    );
    assert_eq!(
        flawed(&|bvh| {
            let (_, bounds, first) = child(bvh, 0);
            bvh.nodes[0].set(1, &bounds, first);
        }),
        "node 1 is in 2 places",
    );
    assert_eq!(
        flawed(&|bvh| {
            let (i, mut bounds, c) = child(bvh, 0);
            bounds.max.x = bounds.max.x * 0.9 + bounds.min.x * 0.1;
            bvh.nodes[0].set(i, &bounds, c);
        }),
        "child 0 of node 0 reaches out of its box",
    );
    assert_eq!(
        flawed(&|bvh| bvh.packs[0].corners[1][2][0] += 1.0),
        format!(
            "pack 0 has another triangle than the scene's primitive {}",
            build_mode(TriangleTest::Plain, &scene).packs[0].id(0)
        ),
    );
}

/// The rays that a scene of this extent has to answer: at random, from afar, along the axes and nearly
/// so, through corners and edges, and starting on a corner.
fn rays(bvh: &Bvh) -> Vec<Ray> {
    let count = (300_000 / (bvh.packs.len() as u32 + 1)).clamp(40, 1000);
    let limit = Vec3A::splat(1.8e18);
    let root = bvh.nodes.iter().take(1).flat_map(|node| node.children());
    let bounds = root.fold(Aabb::EMPTY, |all, (_, bounds, _)| all.union(bounds));
    let (min, max) = (Vec3A::from(bounds.min).max(-limit), Vec3A::from(bounds.max).min(limit));
    let sampler = Independent::new(10);
    let ray = |i: u32| {
        let mut u = PathSampler::new(&sampler, i, 1);
        let within = |u: &mut PathSampler| min + (max - min) * cube(u);
        let corners = match bvh.packs.len() {
            0 => [within(&mut u); 3],
            packs => {
                let pack = &bvh.packs[(u.next_1d() * packs as f32) as usize];
                pack.corners(0).map(Vec3A::from)
            }
        };
        let target = match i % 4 {
            0 => within(&mut u),
            1 => corners[0],
            2 => corners[0] + (corners[1] - corners[0]) * u.next_1d(),
            _ => (corners[0] + corners[1] + corners[2]) / 3.0,
        };
        let direction = match i / 4 % 5 {
            0 | 1 => Vec3A::from(warp::square_to_uniform_sphere(u.next_2d().into())),
            // Along an axis, or nearly: the other components are ±0, denormal, or small.
            kind => {
                let small = [0f32, 1e-42, 1e-32, 1e-20, 1e-8, 1e-6];
                let mut other = || small[(u.next_1d() * 6.0) as usize].copysign(u.next_1d() - 0.5);
                let mut d = Vec3A::new(other(), other(), other());
                d[kind as usize - 2] = 1f32.copysign(u.next_1d() - 0.5);
                d
            }
        };
        let size = (max - min).max_element();
        let distance = [0.0, 0.3, 1.0, 1000.0][(i / 20 % 4) as usize];
        let origin = target - direction * (size * distance).min(1.8e18);
        // The components along which the ray does not move stay those of the target.
        Ray::new(origin, direction)
    };
    (0..count).map(ray).filter(Ray::is_traceable).collect()
}

/// Every triangle and every shape, without the tree.
fn brute_force(bvh: &Bvh, ray: &Ray) -> Option<Found> {
    let ray = &Ray { direction: traverse::without_denormals(ray.direction), ..*ray };
    let test = Watertight::new(ray);
    let mut hits = Vec::new();
    for pack in &bvh.packs {
        let candidates = Level::baseline().run(Candidates(test, &pack.corners));
        let candidate = |lane: &usize| candidates >> lane & 1 == 1 && pack.is_occupied(*lane);
        for lane in (0..LANES).filter(candidate) {
            let corners = pack.corners(lane);
            if let Some(TriangleHit { t, u, v }) = test.hit(ray, &corners) {
                let found = Found { t, u, v, id: pack.id(lane), inner: Inner::NONE };
                hits.push((found, Some(corners)));
            }
        }
    }
    for (shape, &id) in bvh.shapes.iter().zip(&bvh.offsets) {
        if let Geometry::Analytic(analytic) = shape.geometry() {
            let found = |(t, u, v)| (Found { t, u, v, id, inner: Inner::NONE }, None);
            hits.extend(analytic.intersect(ray).map(found));
        }
    }
    let in_f64 = |a: &Option<Corners>, b: &Option<Corners>| match (a, b) {
        (Some(a), Some(b)) => nearer(ray, a, b),
        _ => Ordering::Equal,
    };
    let first = hits.into_iter().min_by(|(a, a_corners), (b, b_corners)| {
        a.t.total_cmp(&b.t).then(in_f64(a_corners, b_corners)).then(a.id.cmp(&b.id))
    });
    first.map(|(found, _)| found)
}

/// No box is missed that holds something the watertight test would hit, and of hits at one distance
/// the same wins, whatever the order: the answers are those without a tree, to the last bit.
#[test]
fn the_tree_changes_no_answer() {
    for (name, scene) in nasty() {
        let bvh = build_mode(TriangleTest::Watertight, &scene);
        let rays = rays(&bvh);
        let mut hits = 0;
        for ray in &rays {
            let expected = brute_force(&bvh, ray);
            assert_eq!(bvh.trace::<false>(ray), expected, "{name}: {ray:?}");
            assert_eq!(bvh.occluded(ray), expected.is_some(), "{name}: {ray:?}");
            hits += usize::from(expected.is_some());
            // Ends at, just before and just behind the hit.
            let Some(Found { t, .. }) = expected else { continue };
            for factor in [1.0 - 1e-3, 1.0, 1.0 + 1e-3] {
                let ray = ray.until(t * factor);
                let expected = brute_force(&bvh, &ray);
                assert_eq!(bvh.trace::<false>(&ray), expected, "{name}: {ray:?}");
                assert_eq!(bvh.occluded(&ray), expected.is_some(), "{name}: {ray:?}");
            }
        }
        assert!(hits > rays.len() / 25 || bvh.nodes.is_empty(), "{name}: {hits} of {}", rays.len());
    }
}

/// The same bits from the best level as from the baseline.
#[test]
fn processors_agree() {
    for (name, scene) in nasty() {
        for triangle in [TriangleTest::Watertight, TriangleTest::Plain] {
            let mut bvh = build_mode(triangle, &scene);
            let rays = rays(&bvh);
            let trace = |bvh: &Bvh| -> Vec<_> {
                rays.iter().map(|ray| (bvh.trace::<false>(ray), bvh.trace::<true>(ray))).collect()
            };
            let detected = trace(&bvh);
            bvh.level = Level::baseline();
            assert!(trace(&bvh) == detected, "{name}, {triangle:?}");
        }
    }
}
