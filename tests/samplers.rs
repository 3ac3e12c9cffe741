//! Random numbers: uniform, unrelated between dimensions, pixels and seeds, and pure. Independent ones are
//! unrelated between samples, too; Sobol's fill the cube evenly instead, which `sobol.rs` tests.

mod support;

use support::stats::chi_squared;
use telamon::sampler::{Independent, PathSampler, Sampler, Sobol};

const COUNT: u32 = 200_000;

const SIDE: usize = 16;

/// Counts of pairs in a grid of SIDE² cells.
fn pairs(numbers: impl Iterator<Item = (f32, f32)>) -> Vec<u64> {
    let mut counts = vec![0; SIDE * SIDE];
    for (x, y) in numbers {
        assert!((0.0..1.0).contains(&x) && (0.0..1.0).contains(&y), "{x} {y}");
        counts[(y * SIDE as f32) as usize * SIDE + (x * SIDE as f32) as usize] += 1;
    }
    counts
}

/// The chi-squared test that pairs fill the unit square evenly. It notices a number that is not
/// uniform as well as one that depends on the other.
fn uniform(numbers: impl Iterator<Item = (f32, f32)>, checks: usize) -> Result<(), String> {
    let counts = pairs(numbers);
    let each = counts.iter().sum::<u64>() as f64 / counts.len() as f64;
    chi_squared(&counts, &vec![each; counts.len()], checks)
}

/// The number of a pixel, a sample and a dimension.
fn number(seed: u64, pixel: u32, sample: u32, dimension: u32) -> f32 {
    let sampler = Independent::new(seed);
    sampler.get_1d(sampler.path(pixel, sample), dimension)
}

type Pair = fn(u32) -> (f32, f32);

/// Pairs of numbers that a render uses side by side.
const PAIRS: [(&str, Pair); 9] = [
    ("next dimension", |i| (number(1, 0, i, 0), number(1, 0, i, 1))),
    ("far dimension", |i| (number(1, 0, i, 3), number(1, 0, i, 67))),
    ("dimensions of one path", |i| (number(1, 5, 9, i), number(1, 5, 9, i + 1))),
    ("next sample", |i| (number(2, 7, i, 0), number(2, 7, i + 1, 0))),
    ("next pixel", |i| (number(3, i, 0, 0), number(3, i + 1, 0, 0))),
    ("next row", |i| (number(3, i, 0, 2), number(3, i + 1024, 0, 2))),
    ("next seed", |i| (number(4, i, 0, 0), number(5, i, 0, 0))),
    ("many seeds", |i| (number(i.into(), 0, 0, 0), number(u64::from(i) + 1, 0, 0, 0))),
    ("pixel and sample exchanged", |i| (number(6, i, 3, 0), number(6, 3, i, 0))),
];

#[test]
fn neighbouring_numbers_are_independent() {
    for (name, pair) in PAIRS {
        uniform((0..COUNT).map(pair), PAIRS.len())
            .unwrap_or_else(|table| panic!("{name}: {table}"));
    }
}

/// The same of Sobol's points.
fn sobol(seed: u64, pixel: u32, sample: u32, dimension: u32) -> f32 {
    let sampler = Sobol::new(seed);
    sampler.get_1d(sampler.path(pixel, sample), dimension)
}

/// A pair of them.
fn sobol_pair(seed: u64, pixel: u32, sample: u32, dimension: u32) -> (f32, f32) {
    let sampler = Sobol::new(seed);
    sampler.get_2d(sampler.path(pixel, sample), dimension).into()
}

/// What of Sobol's points is unrelated: all but the samples of one pixel.
const SOBOL_PAIRS: [(&str, Pair); 12] = [
    ("next dimension", |i| (sobol(1, i, 5, 0), sobol(1, i, 5, 1))),
    ("dimensions of one path", |i| (sobol(1, 5, 9, i), sobol(1, 5, 9, i + 1))),
    ("a number before a pair", |i| (sobol(1, i, 9, 4), sobol_pair(1, i, 9, 5).0)),
    ("first pair", |i| sobol_pair(2, i, 6, 0)),
    ("second pair", |i| sobol_pair(2, i, 6, 2)),
    ("odd pair", |i| sobol_pair(2, i, 6, 3)),
    ("pairs of one block", |i| (sobol_pair(2, i, 6, 4).0, sobol_pair(2, i, 6, 6).1)),
    ("pairs of two blocks", |i| (sobol_pair(2, i, 6, 2).0, sobol_pair(2, i, 6, 4).0)),
    ("next pixel", |i| (sobol_pair(3, i, 0, 0).0, sobol_pair(3, i + 1, 0, 0).0)),
    ("next row", |i| (sobol_pair(3, i, 1, 2).1, sobol_pair(3, i + 1024, 1, 2).1)),
    ("next seed", |i| (sobol(4, i, 0, 0), sobol(5, i, 0, 0))),
    ("many seeds", |i| (sobol(i.into(), 0, 0, 0), sobol(u64::from(i) + 1, 0, 0, 0))),
];

#[test]
fn sobols_pixels_seeds_and_dimensions_are_independent() {
    for (name, pair) in SOBOL_PAIRS {
        uniform((0..COUNT).map(pair), SOBOL_PAIRS.len())
            .unwrap_or_else(|table| panic!("{name}: {table}"));
    }
}

#[test]
fn both_halves_of_a_pair_are_independent() {
    let sampler = Independent::new(8);
    let pair = |i| sampler.get_2d(sampler.path(i, 2), 4).into();
    uniform((0..COUNT).map(pair), 1).unwrap_or_else(|table| panic!("{table}"));
}

/// The number that chooses has 40 bits: seen through its upper 16 and the 24 below them, and beside the
/// other one.
#[test]
fn numbers_that_choose_are_uniform_to_the_last_bit() {
    numbers_that_choose(&Independent::new(8));
    numbers_that_choose(&Sobol::new(8));
}

fn numbers_that_choose(sampler: &dyn Sampler) {
    let choice = |i| sampler.get_choice(sampler.path(i, 2), 4);
    let pair = |i| choice(i).as_vec2().into();
    uniform((0..COUNT).map(pair), 6).unwrap_or_else(|table| panic!("{sampler:?}: {table}"));
    // 12 bits from bit `skip` on, which no rounding turns into 1.
    let bits =
        |x: f64, skip: i32| ((x * f64::from(skip).exp2()).fract() * 4096.0).floor() as f32 / 4096.0;
    for (high, low) in [(0, 16), (16, 28)] {
        let pair = |i| (bits(choice(i).x, high), bits(choice(i).x, low));
        uniform((0..COUNT).map(pair), 6)
            .unwrap_or_else(|table| panic!("{sampler:?}, {high} {low}: {table}"));
    }
    let in_range = |x: f64| (0.0..1.0).contains(&x) && (x * 2f64.powi(40)).fract() == 0.0;
    assert!((0..COUNT).all(|i| in_range(choice(i).x) && in_range(choice(i).y)));
    // It begins with the number that the path takes elsewhere.
    let path = sampler.path(3, 2);
    let (choice, pair) = (sampler.get_choice(path, 4), sampler.get_2d(path, 4));
    assert!(choice.x - f64::from(pair.x) < f64::from(f32::EPSILON));
}

/// The low bits count too: a cell of 2⁻¹⁶, seen through its upper and lower half.
#[test]
fn low_bits_are_uniform() {
    let split = |x: f32| ((x * 256.0).fract(), (x * 65_536.0).fract());
    for number in [number, sobol] {
        uniform((0..COUNT).map(|i| split(number(9, i, 0, 0))), 2)
            .unwrap_or_else(|table| panic!("{table}"));
    }
}

/// Numbers that are not uniform, or that hang together, do not pass.
#[test]
fn wrong_numbers_are_rejected() {
    let wrong: [(&str, Pair); 3] = [
        ("the same twice", |i| (number(1, 0, i, 0), number(1, 0, i, 0))),
        ("5 % too small", |i| (0.95 * number(1, 0, i, 0), number(1, 0, i, 1))),
        ("a little alike", |i| {
            let (x, y) = (number(1, 0, i, 0), number(1, 0, i, 1));
            (x, (y + 0.02 * x) / 1.02)
        }),
    ];
    for (name, pair) in wrong {
        assert!(uniform((0..COUNT).map(pair), 1).is_err(), "{name}");
    }
}

/// The same arguments give the same number, in any order, and each has its own.
#[test]
fn numbers_are_pure() {
    pure(&Independent::new(10), &Independent::new(10));
    pure(&Sobol::new(10), &Sobol::new(10));
}

fn pure(sampler: &dyn Sampler, twin: &dyn Sampler) {
    let forth: Vec<f32> = (0..1_000).map(|d| sampler.get_1d(sampler.path(3, 4), d)).collect();
    let mut back: Vec<f32> = (0..1_000)
        .rev()
        .map(|d| {
            // Other numbers asked for in between change nothing.
            let _ = sampler.get_2d(sampler.path(d, 9), 1);
            twin.get_1d(sampler.path(3, 4), d)
        })
        .collect();
    back.reverse();
    assert_eq!(forth, back);
    // 1,000 of 2²⁴ values: 0.03 collisions expected.
    let mut distinct: Vec<u32> = forth.iter().map(|x| x.to_bits()).collect();
    distinct.sort_unstable();
    distinct.dedup();
    assert!(distinct.len() >= 998, "{} distinct numbers of 1,000", distinct.len());
}

/// A path takes its numbers one after the other and never one of them twice.
#[test]
fn a_path_walks_through_its_dimensions() {
    let sampler = Independent::new(11);
    let key = sampler.path(6, 7);
    let mut path = PathSampler::new(&sampler, 6, 7);
    assert_eq!(path.next_1d(), sampler.get_1d(key, 0));
    assert_eq!(path.next_2d(), sampler.get_2d(key, 1));
    assert_eq!(path.next_1d(), sampler.get_1d(key, 3));
    assert_eq!(path.next_choice(), sampler.get_choice(key, 4));
    assert_eq!(path.next_2d(), sampler.get_2d(key, 6));
}
