//! The maps from the unit square to directions, disks and triangles: each lands where its density
//! says, comes back by its inverse, and survives the corners of the square.

mod support;

use std::f64::consts::TAU;

use glam::{Vec2, Vec3A};
use support::quadrature::SphereGrid;
use support::stats::chi_squared;
use support::{corners, points, stratified_points_and_corners};
use telamon::math::warp;

/// 16 roundings of 2⁻²⁴. The maps and their inverses each take at most four operations and three
/// elementary functions, good to 2 roundings each, and none amplifies what it is given.
const ROUNDING: f32 = 16.0 * f32::EPSILON / 2.0;

const SAMPLES: u32 = 200_000;

/// A map to unit vectors.
struct DirectionWarp {
    name: &'static str,
    map: fn(Vec2) -> Vec3A,
    pdf: fn(Vec3A) -> f32,
    inverse: fn(Vec3A) -> Vec2,
}

const DIRECTION_WARPS: [DirectionWarp; 3] = [
    DirectionWarp {
        name: "uniform sphere",
        map: |u| warp::square_to_uniform_sphere(u.into()).into(),
        pdf: |_| warp::UNIFORM_SPHERE_PDF,
        inverse: |w| warp::uniform_sphere_to_square(w.into()).into(),
    },
    DirectionWarp {
        name: "uniform hemisphere",
        map: |u| warp::square_to_uniform_hemisphere(u.into()).into(),
        pdf: |w| warp::square_to_uniform_hemisphere_pdf(w.into()),
        inverse: |w| warp::uniform_hemisphere_to_square(w.into()).into(),
    },
    DirectionWarp {
        name: "cosine hemisphere",
        map: |u| warp::square_to_cosine_hemisphere(u.into()).into(),
        pdf: |w| warp::square_to_cosine_hemisphere_pdf(w.into()),
        inverse: |w| warp::cosine_hemisphere_to_square(w.into()).into(),
    },
];

/// Half angles from the whole hemisphere down to 1.4e-7, as 1 − cos.
const CONES: [f32; 6] = [1.0, 0.3, 1e-3, 1e-6, 1e-10, 1e-14];

const GRID: SphereGrid = SphereGrid { rows: 10, columns: 20 };

fn direction_counts(map: impl Fn(Vec2) -> Vec3A, seed: u64) -> Vec<u64> {
    let mut counts = vec![0; GRID.cells()];
    points(seed, SAMPLES).for_each(|u| counts[GRID.cell(map(u))] += 1);
    counts
}

fn expected(pdf: fn(Vec3A) -> f32, scale: f64) -> Vec<f64> {
    let integrals = GRID.integrals(1, |w| f64::from(pdf(w)));
    integrals.into_iter().map(|p| p * scale * f64::from(SAMPLES)).collect()
}

#[test]
fn directions_follow_their_densities() {
    for (seed, warp) in (1..).zip(&DIRECTION_WARPS) {
        // Four roundings of an f32 density.
        let total: f64 = GRID.integrals(1, |w| f64::from((warp.pdf)(w))).iter().sum();
        assert!((total - 1.0).abs() < 4.0 * 6e-8, "{}: integrates to {total}", warp.name);
        chi_squared(
            &direction_counts(warp.map, seed),
            &expected(warp.pdf, 1.0),
            DIRECTION_WARPS.len(),
        )
        .unwrap_or_else(|table| panic!("{}: {table}", warp.name));
    }
}

/// The test above would notice a density that is 5 % too high, or that of another map.
#[test]
fn wrong_densities_are_rejected() {
    for (seed, warp) in (1..).zip(&DIRECTION_WARPS) {
        let counts = direction_counts(warp.map, seed);
        assert!(chi_squared(&counts, &expected(warp.pdf, 1.05), 3).is_err(), "{}", warp.name);
        for other in DIRECTION_WARPS.iter().filter(|other| other.name != warp.name) {
            let accepted = chi_squared(&counts, &expected(other.pdf, 1.0), 3).is_ok();
            assert!(!accepted, "{} passes for {}", warp.name, other.name);
        }
    }
}

fn assert_same_point(name: &str, u: Vec2, back: Vec2) {
    // The square's left and right edges are the same half plane of directions.
    let turn = (back.x - u.x).abs();
    let across = turn.min(1.0 - turn).max((back.y - u.y).abs());
    assert!(across <= ROUNDING, "{name}: {u} comes back as {back}");
}

#[test]
fn directions_return_to_their_point() {
    for (seed, warp) in (11..).zip(&DIRECTION_WARPS) {
        for u in stratified_points_and_corners(seed, 40) {
            let w = (warp.map)(u);
            assert!((w.length() - 1.0).abs() <= ROUNDING, "{}: {u} -> {w}", warp.name);
            let mut back = (warp.inverse)(w);
            // At the pole all azimuths are one.
            if w.truncate() == Vec2::ZERO {
                back.x = u.x;
            }
            assert_same_point(warp.name, u, back);
            let pdf = (warp.pdf)(w);
            assert!(pdf > 0.0 || w.z == 0.0, "{}: pdf {pdf} at {w}", warp.name);
        }
    }
}

#[test]
fn cones_of_all_sizes_return_to_their_point() {
    for (seed, one_minus_cos) in (21..).zip(CONES) {
        for u in stratified_points_and_corners(seed, 40) {
            let w = Vec3A::from(warp::square_to_uniform_cone(u.into(), one_minus_cos));
            assert!((w.length() - 1.0).abs() <= ROUNDING, "{one_minus_cos}: {u} -> {w}");
            let mut back = Vec2::from(warp::uniform_cone_to_square(w.into(), one_minus_cos));
            if w.truncate() == Vec2::ZERO {
                back.x = u.x;
            }
            assert_same_point(&format!("cone {one_minus_cos}"), u, back);
        }
        let solid_angle = TAU * f64::from(one_minus_cos);
        let total = solid_angle * f64::from(warp::square_to_uniform_cone_pdf(one_minus_cos));
        assert!((total - 1.0).abs() < 4.0 * 6e-8, "cone {one_minus_cos} integrates to {total}");
    }
}

/// Ten rows of equal solid angle, found from x and y in f64, times 20 columns.
fn cone_counts(one_minus_cos: f32, claimed: f32, seed: u64) -> Vec<u64> {
    let mut counts = vec![0; GRID.cells()];
    for u in points(seed, SAMPLES) {
        let w = Vec3A::from(warp::square_to_uniform_cone(u.into(), one_minus_cos)).as_dvec3();
        let sin_squared = w.x * w.x + w.y * w.y;
        let row = sin_squared / (1.0 + (1.0 - sin_squared).max(0.0).sqrt()) / f64::from(claimed);
        let z = 2.0 * row.min(1.0) - 1.0;
        let r = (1.0 - z * z).max(0.0).sqrt() / sin_squared.sqrt().max(f64::MIN_POSITIVE);
        counts[GRID.cell(glam::DVec3::new(w.x * r, w.y * r, z).as_vec3a())] += 1;
    }
    counts
}

#[test]
fn cones_are_uniform() {
    let expected = vec![f64::from(SAMPLES) / GRID.cells() as f64; GRID.cells()];
    for (seed, one_minus_cos) in (31..).zip(CONES) {
        chi_squared(&cone_counts(one_minus_cos, one_minus_cos, seed), &expected, CONES.len())
            .unwrap_or_else(|table| panic!("cone {one_minus_cos}: {table}"));
        let wider = cone_counts(one_minus_cos, one_minus_cos * 1.05, seed);
        assert!(chi_squared(&wider, &expected, CONES.len()).is_err(), "cone {one_minus_cos}");
    }
}

#[test]
fn disk_points_are_uniform_and_return() {
    for u in stratified_points_and_corners(41, 40) {
        let p = Vec2::from(warp::square_to_uniform_disk(u.into()));
        let back = Vec2::from(warp::uniform_disk_to_square(p.into()));
        let difference = (back - u).abs().max_element();
        assert!(difference <= ROUNDING, "{u} -> {p} comes back as {back}");
        assert!(warp::square_to_uniform_disk_pdf(p.into()) > 0.0, "{u} -> {p} has density 0");
    }
    // Rings of equal area: r² as the height of a cylinder of equal area on the sphere.
    let counts = direction_counts(
        |u| {
            let p = Vec2::from(warp::square_to_uniform_disk(u.into()));
            let z = (2.0 * p.length_squared() - 1.0).clamp(-1.0, 1.0);
            (p.normalize_or_zero() * (1.0 - z * z).sqrt()).extend(z).into()
        },
        42,
    );
    let per_area = f64::from(warp::square_to_uniform_disk_pdf(Vec2::ZERO.into()));
    let each = f64::from(SAMPLES) * per_area * std::f64::consts::PI / GRID.cells() as f64;
    chi_squared(&counts, &vec![each; GRID.cells()], 1).unwrap_or_else(|table| panic!("{table}"));
    assert!(chi_squared(&counts, &vec![each * 1.05; GRID.cells()], 1).is_err());
    assert_eq!(warp::square_to_uniform_disk_pdf(Vec2::new(0.8, 0.7).into()), 0.0);
}

#[test]
fn triangle_points_are_uniform_and_return() {
    for u in stratified_points_and_corners(51, 40) {
        let b = Vec2::from(warp::square_to_uniform_triangle(u.into()));
        let back = Vec2::from(warp::uniform_triangle_to_square(b.into()));
        let difference = (back - u).abs().max_element();
        assert!(difference <= ROUNDING, "{u} -> {b} comes back as {back}");
        assert!(warp::square_to_uniform_triangle_pdf(b.into()) > 0.0, "{u} -> {b} has density 0");
    }
    const SIDE: usize = 10;
    let mut counts = [0; SIDE * SIDE];
    for u in points(52, SAMPLES) {
        let b = Vec2::from(warp::square_to_uniform_triangle(u.into())) * SIDE as f32;
        counts[b.y as usize * SIDE + b.x as usize] += 1;
    }
    // Cells below the diagonal lie inside, those on it by half.
    let share = |x: usize, y: usize| match (x + y + 1).cmp(&SIDE) {
        std::cmp::Ordering::Less => 1.0,
        std::cmp::Ordering::Equal => 0.5,
        std::cmp::Ordering::Greater => 0.0,
    };
    let density = f64::from(warp::square_to_uniform_triangle_pdf(Vec2::splat(0.25).into()));
    let full = density * f64::from(SAMPLES) / (SIDE * SIDE) as f64;
    let expected: Vec<f64> = (0..SIDE * SIDE).map(|i| full * share(i % SIDE, i / SIDE)).collect();
    chi_squared(&counts, &expected, 1).unwrap_or_else(|table| panic!("{table}"));
    let wrong: Vec<f64> = expected.iter().map(|e| e * 1.05).collect();
    assert!(chi_squared(&counts, &wrong, 1).is_err());
    for outside in [Vec2::new(0.6, 0.5), Vec2::new(-0.1, 0.5), Vec2::new(0.5, -0.1)] {
        assert_eq!(warp::square_to_uniform_triangle_pdf(outside.into()), 0.0);
    }
}

/// Densities that rise, fall, stay, begin or end at 0, and change a million times.
#[test]
fn linear_densities_are_followed_and_return() {
    const ENDS: [[f64; 2]; 6] =
        [[1.0, 3.0], [5.0, 2.0], [0.7, 0.7], [0.0, 1.0], [2.0, 0.0], [1.0, 1e6]];
    for (seed, [low, high]) in (61..).zip(ENDS) {
        let mut counts = [0; 20];
        for u in points(seed, SAMPLES).map(|u| f64::from(u.x)) {
            let x = warp::interval_to_linear(u, low, high);
            counts[(x * 20.0) as usize] += 1;
            // In f64, so 16 roundings are 2e-15; from x near 1 the square takes half of the digits.
            let back = warp::linear_to_interval(x, low, high);
            assert!((back - u).abs() < 1e-14, "{low} to {high}: {u} comes back as {back}");
        }
        // The density in the middle of a cell is its mean there.
        let middle = |i: usize| (i as f64 + 0.5) / 20.0;
        let expected: Vec<f64> = (0..20)
            .map(|i| warp::interval_to_linear_pdf(middle(i), low, high) * f64::from(SAMPLES) / 20.0)
            .collect();
        chi_squared(&counts, &expected, ENDS.len())
            .unwrap_or_else(|table| panic!("{low} to {high}: {table}"));
        let wrong: Vec<f64> = (0..20)
            .map(|i| {
                warp::interval_to_linear_pdf(middle(i), low, 1.2 * high) * f64::from(SAMPLES) / 20.0
            })
            .collect();
        // Where only one end counts, its height does not.
        let alike = low == 0.0 || high == 0.0 || high > 1e3 * low;
        assert!(alike || chi_squared(&counts, &wrong, 1).is_err(), "{low} to {high}");
        for u in [0.0, 1.0 - f64::EPSILON / 2.0] {
            assert!((0.0..1.0).contains(&warp::interval_to_linear(u, low, high)), "{u}");
        }
    }
    assert_eq!([-0.1, 1.1].map(|x| warp::interval_to_linear_pdf(x, 1.0, 2.0)), [0.0, 0.0]);
}

#[test]
fn corners_of_the_square_give_usable_points() {
    for u in corners() {
        for warp in &DIRECTION_WARPS {
            let w = (warp.map)(u);
            assert!(w.is_finite() && w.length() > 0.999_999, "{}: {u} -> {w}", warp.name);
        }
        for one_minus_cos in CONES {
            let w = Vec3A::from(warp::square_to_uniform_cone(u.into(), one_minus_cos));
            assert!(w.is_finite() && w.z >= 0.0, "cone {one_minus_cos}: {u} -> {w}");
        }
    }
}

/// At the rim of the disk rounding would leave directions in the horizon, whose density is 0: paths would be lost.
#[test]
fn cosine_directions_stay_above_the_horizon() {
    let below_one = 1.0 - 0.5 * f32::EPSILON;
    for x in [0.0, f32::MIN_POSITIVE, 1e-8, 3e-8, below_one, 1.0 - f32::EPSILON] {
        for i in 0..10_000 {
            let y = i as f32 / 10_000.0;
            for u in [Vec2::new(x, y), Vec2::new(y, x)] {
                let w = warp::square_to_cosine_hemisphere(u.into());
                assert!(w.z > 0.0 && (w.length() - 1.0).abs() < 3e-7, "{u}: {w:?}");
                assert!(warp::square_to_cosine_hemisphere_pdf(w) > 0.0, "{u}");
            }
        }
    }
}
