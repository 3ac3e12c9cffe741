//! Areas are what is compared: by the triangles, and by the shoelace formula along the outline.

use std::collections::HashMap;
use std::f32::consts::FRAC_PI_6;

use glam::{DAffine3, DVec3, Vec3A};

use super::*;

/// The fan of a polygon with the corners 0, 1, 2, …
fn fan(corners: usize) -> Triangles {
    (1..corners as u32 - 1).map(|i| [0, i, i + 1]).collect()
}

fn area(positions: &[Vec3A], triangles: &[[u32; 3]]) -> DVec3 {
    let at = |i: u32| positions[i as usize].as_dvec3();
    triangles.iter().map(|&[a, b, c]| (at(b) - at(a)).cross(at(c) - at(a)) / 2.0).sum()
}

/// The sum of the areas, each for itself.
fn covered(positions: &[Vec3A], triangles: &[[u32; 3]]) -> f64 {
    triangles.iter().map(|&t| area(positions, &[t]).length()).sum()
}

fn triangulated(positions: &[Vec3A]) -> (Triangles, Outcome) {
    let mut polygons = Polygons::default();
    polygons.push(positions.len());
    let mut triangles = fan(positions.len());
    let outcome = polygons.triangulate(positions, &mut triangles);
    (triangles, outcome)
}

/// Every side of the outline once, every other edge in both directions, and all triangles on one side: since
/// their areas as vectors have the sum that the outline says, they then cover its inside once.
fn assert_fills(positions: &[Vec3A], what: &str) {
    let (triangles, outcome) = triangulated(positions);
    assert_eq!(outcome.crossing, 0, "{what}");
    let count = positions.len();
    assert_eq!(triangles.len(), count - 2, "{what}");
    let whole = area(positions, &fan(count));
    // Up to 25 units from the origin, corners are rounded by 1e-6 each, along sides of up to 10: 2e-6 of an area
    // of 5 or more.
    let least = -2e-6 * whole.length_squared();
    assert!(triangles.iter().all(|&t| area(positions, &[t]).dot(whole) > least), "{what}");
    let mut edges = HashMap::new();
    for [a, b, c] in triangles {
        for edge in [(a, b), (b, c), (c, a)] {
            assert_eq!(edges.insert(edge, ()), None, "{what}: {edge:?} twice");
        }
    }
    for i in 0..count as u32 {
        let side = (i, (i + 1) % count as u32);
        assert!(edges.contains_key(&side), "{what}: side {side:?} is missing");
    }
}

fn flat(points: &[[f32; 2]]) -> Vec<Vec3A> {
    points.iter().map(|&[x, y]| Vec3A::new(x, y, 0.0)).collect()
}

/// The same from each corner on, seen from both sides, turned and moved.
fn assert_fills_from_everywhere(points: &[[f32; 2]], what: &str) {
    let tilt = DAffine3::from_rotation_y(0.5) * DAffine3::from_rotation_x(1.1);
    let far = DAffine3::from_translation(DVec3::new(10.0, -20.0, 5.0));
    let small = DAffine3::from_scale(DVec3::splat(1e-20));
    for map in [DAffine3::IDENTITY, tilt, far * tilt, small, DAffine3::from_rotation_y(1.6)] {
        let mut positions: Vec<_> =
            flat(points).iter().map(|p| map.transform_point3(p.as_dvec3()).as_vec3a()).collect();
        for side in 0..2 {
            for start in 0..points.len() {
                assert_fills(&positions, &format!("{what}, side {side}, from {start}, {map}"));
                positions.rotate_left(1);
            }
            positions.reverse();
        }
    }
}

#[test]
fn concave_polygons_are_filled() {
    let arrow = [[0.0, 0.0], [2.0, -1.0], [0.5, 0.0], [2.0, 1.0]];
    let court = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 3.0],
        [2.0, 3.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [0.0, 3.0],
    ];
    let comb: Vec<_> = (0..20).map(|i| [i as f32, if i % 2 == 0 { 2.0 } else { 0.25 }]).collect();
    let comb = [&[[19.0, -1.0], [0.0, -1.0]], &comb[..]].concat();
    let spiral: Vec<_> = (0..40)
        .map(|i| {
            let (turn, radius) = if i < 20 { (i, 1.0) } else { (39 - i, 1.5) };
            let angle = turn as f32 * 0.6;
            [angle.cos() * (radius + angle), angle.sin() * (radius + angle)]
        })
        .collect();
    for (what, points) in
        [("arrow", &arrow[..]), ("court", &court), ("comb", &comb), ("spiral", &spiral)]
    {
        assert_fills_from_everywhere(points, what);
    }
}

/// A hole that is joined to the outline by a side which is passed both ways: the corners at its ends occur
/// twice. Squares in squares, the inner one turned round.
#[test]
fn holes_that_are_joined_to_the_outline_stay_open() {
    let points = [
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 4.0],
        [0.0, 4.0],
        [0.0, 0.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [2.0, 2.0],
        [2.0, 1.0],
        [1.0, 1.0],
    ];
    let positions = flat(&points);
    for start in 0..points.len() {
        let mut positions = positions.clone();
        positions.rotate_left(start);
        assert_fills(&positions, &format!("from {start}"));
    }
    let (triangles, _) = triangulated(&positions);
    assert_eq!(covered(&positions, &triangles), 15.0);
    // Shared by index, as exporters write them.
    let shared = [0, 1, 2, 3, 0, 5, 6, 7, 8, 5];
    let mut polygons = Polygons::default();
    polygons.push(points.len());
    let mut triangles: Triangles =
        fan(points.len()).iter().map(|t| t.map(|i| shared[i as usize])).collect();
    let outcome = polygons.triangulate(&positions, &mut triangles);
    assert_eq!((outcome.crossing, covered(&positions, &triangles)), (0, 15.0));
}

/// Corners in the middle of a side stay corners, or there would be gaps to a neighbour that has them.
#[test]
fn corners_on_sides_are_kept() {
    let points =
        [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [3.0, 3.0], [1.5, 3.0], [0.0, 3.0]];
    assert_fills(&flat(&points), "box");
    // A triangle with a fourth corner: the other diagonal.
    assert_fills(&flat(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 2.0]]), "triangle");
}

/// What is convex stays as it is, triangles too; what has no area, or repeats a corner, gives no complaint.
#[test]
fn fans_stay_where_they_are_right() {
    let round: Vec<_> =
        (0..12).map(|i| i as f32 * FRAC_PI_6).map(|angle| [angle.cos(), angle.sin()]).collect();
    for points in [
        &round[..],
        &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 1.0]],
        &[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [4.0, 0.0]],
        &[[0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]],
        &[[0.0, 0.0], [1.0, f32::NAN], [2.0, 1.0], [0.0, 1.0], [0.0, 0.5]],
        &[[0.0, 0.0], [f32::INFINITY, 0.0], [2.0, 1.0], [0.5, 0.1]],
    ] {
        let positions = flat(points);
        let (triangles, outcome) = triangulated(&positions);
        assert_eq!(triangles, fan(points.len()), "{points:?}");
        assert!(outcome.replaced.is_empty() && outcome.crossing == 0, "{points:?}");
    }
    // Indices that refer to nothing are reported later.
    let mut polygons = Polygons::default();
    polygons.push(4);
    let mut triangles = fan(4);
    polygons.triangulate(&[], &mut triangles);
    assert_eq!(triangles, fan(4));
}

/// A quadrilateral that is bent has a diagonal from which it is a roof, and none that is wrong.
#[test]
fn polygons_need_not_be_flat() {
    let bent =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.25], [1.0, 1.0, 0.0], [0.0, 1.0, 0.25]].map(Vec3A::from);
    assert_eq!(triangulated(&bent).0, fan(4));
    let court = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 3.0],
        [2.0, 3.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [0.0, 3.0f32],
    ];
    let bent: Vec<_> = (0..8)
        .map(|i| Vec3A::new(court[i][0], court[i][1], if i % 3 == 0 { 0.25 } else { 0.0 }))
        .collect();
    let (triangles, outcome) = triangulated(&bent);
    assert_eq!((triangles.len(), outcome.crossing), (6, 0));
    // Seen along z it is the flat one.
    let flat: Vec<_> = bent.iter().map(|p| Vec3A::new(p.x, p.y, 0.0)).collect();
    assert!((covered(&flat, &triangles) - 7.0).abs() < 1e-12);
}

/// Polygons that cross themselves have no inside that all agree on: they are fans, and counted.
#[test]
fn polygons_that_cross_themselves_are_counted() {
    let bow = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]];
    let star: Vec<_> =
        (0..5).map(|i| [(i as f32 * 2.5133).cos(), (i as f32 * 2.5133).sin()]).collect();
    let crossed = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [1.0, -1.0], [0.0, 4.0]];
    for points in [&bow[..], &crossed] {
        let (triangles, outcome) = triangulated(&flat(points));
        assert_eq!((triangles, outcome.crossing), (fan(points.len()), 1), "{points:?}");
    }
    // All triangles of a pentagram's fan face alike.
    assert_eq!(triangulated(&flat(&star)).0.len(), 3);
}

/// Runs of polygons of all sizes, of which some are cut anew; their fans can be had back.
#[test]
fn fans_can_be_had_back() {
    let arrow = flat(&[[0.0, 0.0], [2.0, -1.0], [0.5, 0.0], [2.0, 1.0]]);
    let positions: Vec<_> = [1, 0, 1, 1]
        .iter()
        .flat_map(|&start| {
            let mut arrow = arrow.clone();
            arrow.rotate_left(start);
            arrow
        })
        .collect();
    let (mut polygons, mut triangles) = (Polygons::default(), Triangles::new());
    for first in [0, 4, 8, 12] {
        let mut piece = Polygons::default();
        piece.push(4);
        piece.push(3);
        polygons.append(&piece);
        triangles.extend(fan(4).iter().map(|t| t.map(|i| i + first)));
        triangles.push([first, first + 1, first + 2]);
    }
    let before = triangles.clone();
    let mut outcome = polygons.triangulate(&positions, &mut triangles);
    assert_eq!(outcome.replaced.len(), 3);
    assert_ne!(triangles, before);
    assert_eq!(fans(&triangles, &outcome.replaced), before);
    flip(&mut outcome.replaced);
    triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let flipped: Triangles = before.iter().map(|&[a, b, c]| [a, c, b]).collect();
    assert_eq!(fans(&triangles, &outcome.replaced), flipped);
}

/// The outlines of unions of squares of a grid, with holes that are joined to them by random sides along which
/// nothing else lies, and stars of random radii: all are simple by construction.
#[test]
fn random_polygons_are_filled() {
    let mut state = 1_u64;
    let mut random = move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 24) as f32
    };
    for round in 0..500 {
        let count = 5 + round % 60;
        let points: Vec<_> = (0..count)
            .map(|i| {
                // Angles apart from each other, and no gap as wide as half a turn.
                let angle = (i as f32 + 0.8 * random()) / count as f32 * std::f32::consts::TAU;
                let radius = 0.2 + random();
                [radius * angle.cos(), radius * angle.sin()]
            })
            .collect();
        let tilt =
            DAffine3::from_rotation_y(random().into()) * DAffine3::from_rotation_x(random().into());
        let positions: Vec<_> =
            flat(&points).iter().map(|p| tilt.transform_point3(p.as_dvec3()).as_vec3a()).collect();
        assert_fills(&positions, &format!("star {round}"));
    }
}

/// A star of many corners takes about as long for each of them as one of few: nobody waits for the square of
/// 100,000.
#[test]
fn many_corners_are_cut_in_one_go() {
    let count = 100_000;
    let points: Vec<_> = (0..count)
        .map(|i| {
            let angle = i as f32 / count as f32 * std::f32::consts::TAU;
            let radius = if i % 2 == 0 { 1.0 } else { 0.25 + (i % 101) as f32 / 200.0 };
            [radius * angle.cos(), radius * angle.sin()]
        })
        .collect();
    assert_fills(&flat(&points), "star");
}
