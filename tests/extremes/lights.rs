//! Lights: of a million triangles, tiny, blinding, seen from everywhere, and what a floor gets of them.

use telamon::math::{Choice, Discrete};
use telamon::sampler::{Independent, Sampler};

use crate::support::stats::chi_squared;

/// How often the number that is left of a choice among `count` alike falls into each of 64 cells.
fn rests(count: usize, number: impl Fn(u32) -> f64) -> Vec<u64> {
    let alike = Discrete::new(&vec![1.0; count]).expect("positive weights");
    let mut cells = vec![0; 64];
    for i in 0..200_000 {
        let Choice { rest, .. } = alike.sample(number(i));
        cells[(rest * 64.0) as usize] += 1;
    }
    cells
}

/// A choice among a million leaves a number that is good for a coordinate: 20 bits of 40. Numbers of 24 bits
/// leave four of them, and choose some of a million 6 % more often than others.
#[test]
fn a_choice_among_a_million_leaves_a_number() {
    let sampler = Independent::new(501);
    let fine = |i| sampler.get_choice(sampler.path(0, i), 0).x;
    let expected = [200_000.0 / 64.0; 64];
    for count in [1, 3, 1_000, 1 << 20, 4_000_000] {
        let cells = rests(count, fine);
        chi_squared(&cells, &expected, 5).unwrap_or_else(|table| panic!("{count}: {table}"));
    }
    let coarse = |i| f64::from(sampler.get_1d(sampler.path(0, i), 0));
    assert!(chi_squared(&rests(1 << 20, coarse), &expected, 1).is_err());
}
