use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3A};

use super::*;
use crate::math::{Frame, Motion};
use crate::parity::{Answer, Class, Generated, RaySource};
use crate::ray::Hit;
use crate::sampler::{Independent, PathSampler};
use crate::shape::{Cylinder, Disk, Group, Instance, Sphere, TriangleMesh, primitives};

pub(super) fn mesh(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Arc<dyn Shape> {
    let positions = positions.iter().map(|&p| Vec3A::from_array(p)).collect();
    let (mesh, _) = TriangleMesh::new(positions, triangles.to_vec(), Vec::new(), Vec::new())
        .expect("indices in range");
    Arc::new(mesh)
}

/// The right-angled triangle with legs of 1 along x and y from the origin.
fn triangle() -> Oracle {
    Oracle::new(&[mesh(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])])
}

/// The square from −1 to 1 in a plane of constant z, as four triangles around its centre.
pub(super) fn fan(z: f32) -> Arc<dyn Shape> {
    let corners = [[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z], [0.0, 0.0, z]];
    mesh(&corners, &[[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
}

/// Along +z from z = −1.
pub(super) fn up(x: f32, y: f32) -> Ray {
    Ray::new(Vec3A::new(x, y, -1.0), Vec3A::Z)
}

/// The positive number that is so many numbers away.
fn beside(x: f32, steps: i32) -> f32 {
    f32::from_bits(x.to_bits().wrapping_add_signed(steps))
}

pub(super) fn hit(t: f32, u: f32, v: f32, shape: u32, primitive: u32) -> Answer {
    Answer::Closest(Some(Hit { t, u, v, shape, primitive, member: 0 }))
}

pub(super) const MISS: Answer = Answer::Closest(None);
pub(super) const CLEAR: Answer = Answer::Occluded(false);
const BLOCKED: Answer = Answer::Occluded(true);

/// What is said of each answer.
pub(super) fn judge<const N: usize>(
    oracle: &Oracle,
    ray: &Ray,
    answers: [Answer; N],
) -> [Class; N] {
    let truth = oracle.examine(ray);
    answers.map(|a| truth.judge(&a))
}

#[test]
fn inside_a_triangle_there_is_one_answer() {
    let (oracle, ray) = (triangle(), up(0.25, 0.5));
    let truth = oracle.examine(&ray);
    let [found] = truth.crossings() else { panic!("one crossing: {truth:?}") };
    assert_eq!((found.shape, found.primitive, found.crossing), (0, 0, Some(1.0)));
    // From (1/4, 1/2) the hypotenuse x + y = 1 is 1/4 / √2 away, the legs 1/2 and 1/4.
    assert!((found.clearance - 0.25 / 2f64.sqrt()).abs() < 1e-12);
    // R is the distance of the corner at y = 1, or at x = 1, from the start.
    let reach = (0.25f64.powi(2) + 0.5f64.powi(2) + 1.0).max(0.75f64.powi(2) + 0.25 + 1.0).sqrt();
    // All corners are at the same distance, so the shape of the triangle does not lengthen the span.
    assert!((found.span.far - 1.0 - 0.5 * bound(reach)).abs() < 1e-12, "{found:?}");
    assert!((found.reach - reach).abs() < 1e-12, "{found:?}");
    let said = judge(&oracle, &ray, [hit(1.0, 0.25, 0.5, 0, 0), BLOCKED, MISS, CLEAR]);
    assert_eq!(said, [Class::Same, Class::Same, Class::Leak, Class::Leak]);
}

#[test]
fn what_a_hit_says_must_be_true() {
    let (oracle, ray) = (triangle(), up(0.25, 0.5));
    let beyond = 1.0 + 3.0 * bound(2.0) as f32;
    let said = judge(
        &oracle,
        &ray,
        [
            hit(f32::NAN, 0.25, 0.5, 0, 0),
            hit(f32::INFINITY, 0.25, 0.5, 0, 0),
            hit(-1.0, 0.25, 0.5, 0, 0),
            // Weights of another point, or of none.
            hit(1.0, 0.5, 0.25, 0, 0),
            hit(1.0, f32::NAN, 0.5, 0, 0),
            // Primitives and shapes that are not there.
            hit(1.0, 0.25, 0.5, 0, 1),
            hit(1.0, 0.25, 0.5, 1, 0),
        ],
    );
    assert_eq!(said, [Class::Wrong; 7]);
    let said = judge(&oracle, &ray, [0.999, beyond].map(|t| hit(t, 0.25, 0.5, 0, 0)));
    assert_eq!(said, [Class::Distance; 2]);
    // Within the bound, and beyond the end of the segment.
    let within = 1.0 + 2.0 * f32::EPSILON;
    assert_eq!(judge(&oracle, &ray, [hit(within, 0.25, 0.5, 0, 0)]), [Class::Same]);
    assert_eq!(judge(&oracle, &ray.until(0.5), [hit(1.0, 0.25, 0.5, 0, 0)]), [Class::False]);
}

/// The triangle twice as large and 10 to the right, which goes up by 4 while the shutter is open.
#[test]
fn instances_are_judged_where_they_are() {
    let place = |z: f64| {
        DAffine3::from_translation(DVec3::new(10.0, 0.0, z))
            * DAffine3::from_scale(DVec3::splat(2.0))
    };
    let triangle = mesh(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
    let group = Arc::new(Group::new(vec![fan(8.0), triangle]).expect("no instance"));
    let motion = Motion::new(vec![(0.0, place(0.0)), (1.0, place(4.0))]).expect("ascending");
    let oracle = Oracle::new(&[Arc::new(Instance::moving(group, motion).expect("not singular"))]);
    let said = |t, member| {
        let hit = Hit { t, u: 0.25, v: 0.5, shape: 0, primitive: 0, member };
        Answer::Closest(Some(hit))
    };
    for (time, t) in [(0.0, 1.0), (0.5, 3.0), (1.0, 5.0)] {
        let ray = Ray { time, ..up(10.5, 1.0) };
        let truth = oracle.examine(&ray);
        let [first, second] = truth.crossings() else { panic!("two crossings: {truth:?}") };
        assert_eq!((first.member, first.primitive, first.crossing), (1, 0, Some(t.into())));
        assert_eq!((second.member, second.crossing), (0, Some(f64::from(t) + 16.0)));
        let answers = [said(t, 1), BLOCKED, MISS, CLEAR, said(t, 0), said(t + 1e-3, 1), said(t, 2)];
        let expected = [Class::Same, Class::Same, Class::Leak, Class::Leak];
        let expected = [
            expected.as_slice(),
            // Of the fan's first triangle, of no point of the right one, of no member.
            &[Class::Wrong, Class::Distance, Class::Wrong],
        ]
        .concat();
        assert_eq!(judge(&oracle, &ray, answers), *expected);
    }
    // Where the group is without its map.
    let said = judge(&oracle, &up(0.25, 0.25), [MISS, BLOCKED]);
    assert_eq!(said, [Class::Same, Class::False]);
}

#[test]
fn where_nothing_is_near_nothing_may_be_hit() {
    let oracle = triangle();
    for ray in [
        up(0.75, 0.75),
        up(-1e-3, 0.5),
        up(0.25, 0.25).until(0.9),
        Ray { t_min: 1.1, ..up(0.25, 0.25) },
        // Behind the start; beside; parallel to the plane.
        Ray::new(Vec3A::new(0.25, 0.25, 1.0), Vec3A::Z),
        Ray::new(Vec3A::new(0.25, 0.25, -0.1), Vec3A::X),
    ] {
        let said = judge(&oracle, &ray, [MISS, CLEAR, BLOCKED, hit(1.0, 0.25, 0.25, 0, 0)]);
        assert_eq!(said, [Class::Same, Class::Same, Class::False, Class::False], "{ray:?}");
    }
}

/// Rays that no engine may be asked about, and one without direction.
#[test]
fn impossible_rays_hit_nothing() {
    let (oracle, good) = (triangle(), up(0.25, 0.25));
    for ray in [
        Ray { origin: Vec3A::NAN, ..good },
        Ray { direction: Vec3A::INFINITY, ..good },
        Ray { direction: Vec3A::ZERO, ..good },
        Ray { t_max: f32::NAN, ..good },
        Ray { t_min: -1.0, ..good },
        Ray { time: 2.0, ..good },
        Ray { t_min: 2.0, t_max: 1.0, ..good },
    ] {
        let said = judge(&oracle, &ray, [MISS, CLEAR, BLOCKED, hit(1.0, 0.25, 0.25, 0, 0)]);
        assert_eq!(said, [Class::Same, Class::Same, Class::False, Class::False], "{ray:?}");
    }
}

/// The border belongs to the triangle; one f32 beside it the ray misses, and either answer is excused.
#[test]
fn the_border_is_exact_and_excused() {
    let oracle = triangle();
    let edge = up(0.5, 0.5);
    for (ray, crosses) in [
        (up(0.0, 0.0), true),
        (up(1.0, 0.0), true),
        (up(0.5, 0.0), true),
        (edge, true),
        (up(beside(0.5, -1), 0.5), true),
        (up(beside(0.5, 1), 0.5), false),
        (up(0.5, -f32::from_bits(1)), false),
        (up(beside(1.0, 1), 0.0), false),
    ] {
        let truth = oracle.examine(&ray);
        assert_eq!(truth.crossings().len(), usize::from(crosses), "{ray:?}");
        assert_eq!(truth.near().len(), 1);
        assert!(truth.near()[0].clearance <= f64::from(f32::EPSILON));
        assert!(truth.barriers().is_empty());
        let (x, y) = (ray.origin.x, ray.origin.y);
        let said = judge(&oracle, &ray, [hit(1.0, x, y, 0, 0), BLOCKED, MISS, CLEAR]);
        let (there, gone) = (Class::Same, Class::Silhouette);
        let expected =
            if crosses { [there, there, gone, gone] } else { [gone, gone, there, there] };
        assert_eq!(said, expected, "{ray:?}");
    }
}

/// In the plane, along an edge or across: no crossing by convention, but excused.
#[test]
fn a_ray_in_the_plane_crosses_nothing() {
    let oracle = triangle();
    for (ray, t) in [
        (Ray::new(Vec3A::new(-1.0, 0.0, 0.0), Vec3A::X), 1.1),
        (Ray::new(Vec3A::new(-1.0, 0.5, 0.0), Vec3A::X), 1.1),
        (Ray::new(Vec3A::new(0.25, 0.25, 0.0), Vec3A::Y), 0.1),
    ] {
        let truth = oracle.examine(&ray);
        assert!(truth.crossings().is_empty(), "{ray:?}");
        assert_eq!(truth.near().len(), 1, "{ray:?}");
        let answers = [MISS, BLOCKED, hit(t, 0.25, 0.25, 0, 0), hit(9.0, 0.25, 0.25, 0, 0)];
        let expected = [Class::Same, Class::Silhouette, Class::Silhouette, Class::Distance];
        assert_eq!(judge(&oracle, &ray, answers), expected);
    }
}

/// At the centre of the fan four triangles meet: each is right, none is a leak, even for a ray that
/// ends as far behind as f32 can tell; at the fan's own border nothing is sure.
#[test]
fn a_surface_without_bare_edges_must_be_hit() {
    let oracle = Oracle::new(&[fan(0.0)]);
    for (x, y, crossed) in [(0.0, 0.0, 4), (0.5, 0.5, 2), (1e-9, 1e-9, 2), (1e-9, 2e-9, 1)] {
        let truth = oracle.examine(&up(x, y));
        assert_eq!(truth.crossings().len(), crossed, "{x}, {y}");
        assert_eq!(truth.barriers().len(), 1, "{x}, {y}");
        assert_eq!(truth.judge(&MISS), Class::Leak);
        assert_eq!(truth.judge(&CLEAR), Class::Leak);
    }
    let centre = judge(&oracle, &up(0.0, 0.0), [0, 1, 2, 3].map(|i| hit(1.0, 0.0, 1.0, 0, i)));
    assert_eq!(centre, [Class::Same, Class::Twin, Class::Twin, Class::Twin]);
    // Near the edge between triangles 1 and 2, but inside 1.
    let ray = up(0.5, beside(0.5, -1));
    let said = judge(&oracle, &ray, [hit(1.0, 0.5, 0.5, 0, 1), hit(1.0, 0.0, 0.5, 0, 2)]);
    assert_eq!(said, [Class::Same, Class::Twin]);
    for ray in [up(1.0, 0.25), up(1.0, 1.0), up(0.0, 0.0).until(1.0)] {
        assert_eq!(judge(&oracle, &ray, [MISS, CLEAR]), [Class::Silhouette; 2], "{ray:?}");
    }
}

/// The same positions under other indices are one edge; a gap, however small, is none.
#[test]
fn edges_are_compared_by_position() {
    let two = |gap: f32| {
        let [a, b, c, d] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
        // −0 is 0.
        let (c2, d2) = ([1.0, 1.0, -0.0], [-1.0 + gap, -1.0, -0.0]);
        Oracle::new(&[mesh(&[a, b, c], &[[0, 1, 2]]), mesh(&[d2, c2, d], &[[0, 1, 2]])])
    };
    let ray = up(0.25, 0.25);
    assert_eq!(judge(&two(0.0), &ray, [MISS]), [Class::Leak]);
    assert_eq!(judge(&two(f32::EPSILON), &ray, [MISS]), [Class::Silhouette]);
}

/// Through the front to the back is a leak, beside the front it is none.
#[test]
fn what_lies_behind_a_surface_is_not_seen() {
    let shapes = [fan(0.0), fan(1.0)];
    let oracle = Oracle::new(&shapes);
    // (1/4, 1/8) lies in the triangle of the edge at x = 1, with weights 3/16, 1/16 of its corners there.
    let front = hit(1.0, 3.0 / 16.0, 3.0 / 4.0, 0, 1);
    let back = hit(2.0, 3.0 / 16.0, 3.0 / 4.0, 1, 1);
    let said = judge(&oracle, &up(0.25, 0.125), [front, back, MISS]);
    assert_eq!(said, [Class::Same, Class::Leak, Class::Leak]);
    let narrow = mesh(&[[0.25, -9.0, 0.0], [9.0, -9.0, 0.0], [0.25, 9.0, 0.0]], &[[0, 1, 2]]);
    let oracle = Oracle::new(&[narrow, fan(1.0)]);
    let said = judge(&oracle, &up(0.25, 0.125), [back, MISS]);
    assert_eq!(said, [Class::Silhouette, Class::Leak]);
}

/// Two faces that hang together by an edge, on one side of it as the ray sees them.
#[test]
fn a_fold_is_a_silhouette() {
    let positions = [[0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, -0.5], [1.0, 0.0, 0.5]];
    let oracle = Oracle::new(&[mesh(&positions, &[[0, 1, 2], [1, 0, 3]])]);
    let said = judge(&oracle, &up(0.0, 0.25), [MISS, CLEAR, BLOCKED]);
    assert_eq!(said, [Class::Silhouette, Class::Silhouette, Class::Same]);
    // A little inside it must be hit, and not behind the front face.
    let ray = up(0.5, 0.0);
    let said = judge(&oracle, &ray, [MISS, hit(1.25, 0.25, 0.5, 0, 1)]);
    assert_eq!(said, [Class::Leak, Class::Leak]);
}

#[test]
fn coincident_faces_are_twins() {
    let oracle = Oracle::new(&[fan(0.0), fan(0.0)]);
    let answers = [0, 1].map(|shape| hit(1.0, 3.0 / 16.0, 3.0 / 4.0, shape, 1));
    let said = judge(&oracle, &up(0.25, 0.125), answers);
    assert_eq!(said, [Class::Same, Class::Twin]);
}

/// The referee's answers do not depend on the unit of length, as far as f32 and its products go.
#[test]
fn scale_does_not_matter() {
    let rays = [(0.25, 0.5), (0.5, 0.5), (0.0, 0.0), (0.75, 0.75), (beside(0.5, 1), 0.5)];
    for exponent in [-120, -60, -20, 20, 60] {
        let s = 2f32.powi(exponent);
        let oracle = Oracle::new(&[mesh(&[[0.0; 3], [s, 0.0, 0.0], [0.0, s, 0.0]], &[[0, 1, 2]])]);
        for (x, y) in rays {
            let unit = up(x, y);
            let scaled = Ray { origin: unit.origin * s, t_min: 0.0, ..unit };
            let answers = |s: f32| [hit(s, x, y, 0, 0), hit(1.1 * s, x, y, 0, 0), MISS, BLOCKED];
            assert_eq!(
                judge(&oracle, &scaled, answers(s)),
                judge(&triangle(), &unit, answers(1.0)),
                "2^{exponent}: {x}, {y}"
            );
        }
    }
}

/// A sphere of radius 1 seen along z at distance h from its axis: crossings at ∓√(1 − h²).
#[test]
fn spheres_and_disks_have_closed_forms() {
    let axes = Frame::from_normal(Vec3A::Z.into());
    let sphere: Arc<dyn Shape> = Arc::new(Sphere::new(Vec3A::new(0.0, 0.0, 4.0), 1.0, axes, false));
    let oracle = Oracle::new(&[sphere]);
    for h in [0.0, 0.5, 0.999] {
        let truth = oracle.examine(&up(h, 0.0));
        let half_chord = (1.0 - f64::from(h).powi(2)).sqrt();
        let crossings: Vec<_> = truth.crossings().iter().filter_map(|e| e.crossing).collect();
        let [near, far] = crossings.as_slice() else { panic!("two crossings: {crossings:?}") };
        assert!((near - 5.0 + half_chord).abs() < 1e-12 && (far - 5.0 - half_chord).abs() < 1e-12);
        let said = [*near, *far].map(|t| truth.judge(&hit(t as f32, 0.0, 0.0, 0, 0)));
        assert_eq!(said, [Class::Same, Class::Leak], "{h}");
        assert_eq!(truth.judge(&MISS), Class::Leak);
        assert_eq!(truth.judge(&hit(5.0, 0.0, 0.0, 0, 0)), Class::Wrong);
    }
    let tangent = oracle.examine(&up(1.0, 0.0));
    assert_eq!(tangent.judge(&MISS), Class::Silhouette);
    assert_eq!(tangent.judge(&hit(5.0, 0.0, 0.0, 0, 0)), Class::Same);
    assert_eq!(oracle.examine(&up(1.1, 0.0)).judge(&hit(5.0, 0.0, 0.0, 0, 0)), Class::False);

    // Half axes 2 and 1/2 at z = 1.
    let to_world = DAffine3::from_scale_rotation_translation(
        DVec3::new(2.0, 0.5, 1.0),
        glam::DQuat::IDENTITY,
        DVec3::Z,
    );
    let disk: Arc<dyn Shape> = Arc::new(Disk::new(to_world, false).expect("not singular"));
    let oracle = Oracle::new(&[disk]);
    for (x, y, miss) in [
        (1.9, 0.0, Class::Leak),
        (0.0, 0.49, Class::Leak),
        (2.0, 0.0, Class::Silhouette),
        (0.0, 0.5, Class::Silhouette),
        (2.1, 0.0, Class::Same),
        (0.0, 0.6, Class::Same),
        (1.9, 0.49, Class::Same),
    ] {
        let truth = oracle.examine(&up(x, y));
        assert_eq!(truth.judge(&MISS), miss, "{x}, {y}");
        if miss == Class::Leak {
            assert_eq!(truth.crossings()[0].crossing, Some(2.0));
            assert_eq!(truth.judge(&hit(2.0, 0.0, 0.0, 0, 0)), Class::Same);
            assert_eq!(truth.judge(&hit(1.9, 0.0, 0.0, 0, 0)), Class::Wrong);
        }
    }
}

/// Triangles of all sizes and shapes, many of which share corners, beside a cube, a sphere and a disk.
fn jumble() -> Vec<Arc<dyn Shape>> {
    let sampler = Independent::new(5);
    let mut u = PathSampler::new(&sampler, 0, 0);
    let mut positions = Vec::new();
    for i in 0..300 {
        let size = 10f32.powi(-(i % 5));
        positions.push([0, 1, 2].map(|_| (u.next_1d() * 2.0 - 1.0) * size));
    }
    let mut corner = || (u.next_1d() * 300.0) as u32;
    let triangles: Vec<_> = (0..500).map(|_| [corner(), corner(), corner()]).collect();
    let axes = Frame::from_normal(Vec3A::Z.into());
    vec![
        mesh(&positions, &triangles),
        Arc::new(primitives::cube(DAffine3::IDENTITY, false).0),
        Arc::new(Sphere::new(Vec3A::X, 0.5, axes, false)),
        Arc::new(Disk::new(DAffine3::from_rotation_x(0.5), false).expect("not singular")),
        Arc::new(Cylinder::new(DVec3::ZERO, [DVec3::X, DVec3::Y, DVec3::Z], false).expect("valid")),
        Arc::new(TriangleMesh::default()),
    ]
}

/// The tree leaves out nothing that brute force finds.
#[test]
fn the_tree_is_as_good_as_brute_force() {
    let shapes = jumble();
    let (tree, all) = (Oracle::new(&shapes), Oracle::brute_force(&shapes));
    let rays = Generated::new(&shapes, None, 3, 3000);
    let mut found = 0;
    for index in 0..rays.count() {
        let (family, ray) = rays.ray(index);
        let (a, b) = (tree.examine(&ray), all.examine(&ray));
        assert_eq!(a.crossings(), b.crossings(), "{family}: {ray:?}");
        let sorted = |truth: &Truth<'_>| {
            let mut near = truth.near().to_vec();
            near.sort_by(|x, y| {
                (x.shape, x.primitive)
                    .cmp(&(y.shape, y.primitive))
                    .then(x.span.near.total_cmp(&y.span.near))
            });
            near
        };
        assert_eq!(sorted(&a), sorted(&b), "{family}: {ray:?}");
        assert_eq!(a.barriers().len(), b.barriers().len(), "{family}: {ray:?}");
        found += b.crossings().len();
    }
    assert!(found > 3000, "{found}");
}

/// Where the referee says that something must be hit, it is hit by every ray beside the first, as far away as
/// half the smallest bound: R is at least the distance of the crossing.
#[test]
fn barriers_hold_beside_the_ray() {
    let shapes: Vec<Arc<dyn Shape>> =
        vec![fan(0.0), Arc::new(primitives::cube(DAffine3::IDENTITY, false).0)];
    let oracle = Oracle::new(&shapes);
    let rays = Generated::new(&shapes, None, 8, 4000);
    let sampler = Independent::new(9);
    let (mut barriers, mut at_edges) = (0, 0);
    for index in 0..rays.count() {
        let (_, ray) = rays.ray(index);
        let truth = oracle.examine(&ray);
        for barrier in truth.barriers() {
            barriers += 1;
            at_edges += usize::from(truth.near().iter().any(|e| e.clearance < 1e-7));
            let mut u = PathSampler::new(&sampler, 0, index as u32);
            let reach = 0.5 * bound(barrier.near.max(0.0)) as f32;
            for _ in 0..8 {
                let frame = Frame::from_normal(ray.direction.into());
                let (sin, cos) = (u.next_1d() * std::f32::consts::TAU).sin_cos();
                let origin = ray.origin + Vec3A::from(frame.s * cos + frame.t * sin) * reach;
                let beside = Ray { origin, ..ray };
                let crossings = oracle.examine(&beside);
                let inside = crossings.crossings().iter().filter_map(|e| e.crossing);
                // The span of the barrier has room for the shift.
                assert!(
                    inside.clone().any(|t| t >= barrier.near && t <= barrier.far),
                    "{ray:?}: {barrier:?} {beside:?}"
                );
            }
        }
    }
    assert!(barriers > 1000 && at_edges > 100, "{barriers} {at_edges}");
}
