//! How far the referee looks, and how far a distance may be off.

use glam::{DVec3, Vec3A};

use super::tests::{CLEAR, MISS, fan, hit, judge, mesh, up};
use super::*;
use crate::parity::Class;
use crate::sampler::{Independent, PathSampler};

/// More triangles around a point than the referee asks what they cover: a wrong answer is told from a right one, and
/// one that rounding may excuse is left open.
#[test]
fn what_is_crowded_is_left_open() {
    let around = |count: u32| {
        let mut positions = vec![[0.0; 3]];
        positions.extend((0..count).map(|i| {
            let (sin, cos) = (std::f32::consts::TAU * i as f32 / count as f32).sin_cos();
            [cos, sin, 0.0]
        }));
        let triangles: Vec<_> = (0..count).map(|i| [0, 1 + i, 1 + (i + 1) % count]).collect();
        Oracle::new(&[mesh(&positions, &triangles), fan(1.0)])
    };
    let most = MOST_NEAR as u32;
    let ray = up(0.0, 0.0);
    // Four more belong to the fan behind.
    for (count, open) in [(most - 4, Class::Leak), (most - 3, Class::Undecided)] {
        let oracle = around(count);
        let truth = oracle.examine(&ray);
        assert_eq!(truth.near().len(), count as usize + 4);
        assert_eq!(truth.is_crowded(), open == Class::Undecided);
        let answers = [
            hit(1.0, 0.0, 0.0, 0, 0),
            hit(1.0, 0.0, 0.0, 0, 7),
            hit(1.0, 0.5, 0.0, 0, 7),
            hit(1.1, 0.0, 0.0, 0, 0),
            hit(2.0, 0.0, 1.0, 1, 0),
            MISS,
            CLEAR,
        ];
        let expected = [Class::Same, Class::Twin, Class::Wrong, Class::Distance, open, open, open];
        assert_eq!(judge(&oracle, &ray, answers), expected, "{count}");
        assert_eq!(judge(&oracle, &up(0.5, 0.5), [MISS]), [Class::Leak]);
    }
}

/// Distances are excused by 16 u (R + L S) over the cosine and no more, for a triangle 0.01 wide seen at all angles,
/// of a shape of 2 and of 100; and where that is more than the triangle itself, by what it reaches.
#[test]
fn distances_are_those_of_the_plane_and_of_the_triangle() {
    let u = 0.5 * f64::from(f32::EPSILON);
    for height in [0.01f32, 0.0002] {
        let corners = [[-0.005, 0.0, 0.0], [0.005, 0.0, 0.0], [0.0, height, 0.0]];
        let oracle = Oracle::new(&[mesh(&corners, &[[0, 1, 2]])]);
        let center = Vec3A::new(0.0, height / 4.0, 0.0);
        for cosine in [1.0f32, 0.1, 1e-2, 1e-3, 1e-5, 1e-7] {
            let direction = Vec3A::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine).normalize();
            let ray = Ray::new(center - direction, direction);
            let truth = oracle.examine(&ray);
            let [found] = truth.crossings() else { panic!("one crossing: {truth:?}") };
            let t = found.crossing.expect("crossed");
            let [o, d] = [ray.origin, ray.direction].map(|v| v.as_dvec3());
            let seen = corners.map(|c| DVec3::from(c.map(f64::from)) - o);
            let reach = seen.map(DVec3::length).into_iter().fold(0.0, f64::max);
            let longest = 0.01f64.max(0.005f64.hypot(height.into()));
            let shape = longest * longest / (0.01 * f64::from(height));
            let plane = 16.0 * u * (reach + longest * shape) / d.z;
            let farthest =
                seen.map(|c| c.dot(d)).into_iter().fold(0.0, f64::max) + 16.0 * u * reach;
            let excused = plane.min(farthest - t);
            // Within the rounding of t itself.
            for (share, class) in [(0.9, Class::Same), (1.1, Class::Distance)] {
                let off = (t + share * excused) as f32;
                let half = f64::from(off) / 2f64.powi(24);
                if 0.1 * excused < half {
                    continue;
                }
                let point = (center.x / 0.01, center.y / height);
                let (u, v) = (0.5 + point.0 - 0.5 * point.1, point.1);
                assert_eq!(
                    judge(&oracle, &ray, [hit(off, u, v, 0, 0)]),
                    [class],
                    "{height} {cosine} {share}"
                );
            }
        }
    }
}

/// What the referee looks at to find crossings does not grow with the details beside the ray, however many are
/// within the bound.
#[test]
fn crossings_are_found_among_details_below_the_bound() {
    let visited = |count: i32| {
        // Squares of a hundred millionth around the centre of the unit square.
        let side = 1e-8 / count as f32;
        let mut positions = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
        let mut triangles = vec![[0, 1, 2]];
        for i in 0..count * count {
            let (x, y) = ((i % count) as f32 * side, (i / count) as f32 * side);
            let first = positions.len() as u32;
            positions.extend([[x, y, 0.1], [x + side, y, 0.1], [x, y + side, 0.1]]);
            triangles.push([first, first + 1, first + 2]);
        }
        let oracle = Oracle::new(&[mesh(&positions, &triangles)]);
        let sampler = Independent::new(6);
        let mut u = PathSampler::new(&sampler, 0, 0);
        let (mut looked_at, mut crossed) = (0, 0);
        for _ in 0..200 {
            let ray = up(u.next_1d() * 1e-8, u.next_1d() * 1e-8);
            let line = span::Line::new(&ray).expect("can be traced");
            oracle.tree.visit_crossed(&line, |_| looked_at += 1);
            crossed += oracle.examine(&ray).crossings().len();
        }
        assert!(crossed >= 250, "{crossed}");
        looked_at
    };
    let (few, many) = (visited(10), visited(100));
    // A hundred times as many are a few more leaves of four.
    assert!(many <= 2 * few && many < 200 * 16, "{few} {many}");
}
