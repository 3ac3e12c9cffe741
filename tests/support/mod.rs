//! What the statistical tests share: random numbers, tests of hypotheses, quadrature.
//!
//! The significance is 0.01 for each test function, divided among its checks after Šidák. Seeds are
//! fixed, so a check that passes keeps passing until the code changes.

#![allow(dead_code, reason = "each test program uses its own part of this")]

pub(crate) mod command;
pub(crate) mod lights;
pub(crate) mod materials;
pub(crate) mod meshes;
pub(crate) mod pictures;
pub(crate) mod python;
pub(crate) mod quadrature;
pub(crate) mod rays;
pub(crate) mod rooms;
pub(crate) mod stats;

use std::collections::BTreeSet;

use glam::{Vec2, Vec3A};
use telamon::load::plugins::{Category, supported};
use telamon::sampler::{Independent, Sampler};

/// What a scene file can name of one kind: each must have a row in the table of its tests.
pub(crate) fn plugin_names(category: Category) -> BTreeSet<&'static str> {
    supported().filter(|p| p.category() == category).map(|p| p.name).collect()
}

/// The largest f32 below 1, hence the largest number that a sampler returns.
pub(crate) const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// `count` points of `[0, 1)²` that depend on `seed` only.
pub(crate) fn points(seed: u64, count: u32) -> impl Iterator<Item = Vec2> {
    let sampler = Independent::new(seed);
    (0..count).map(move |i| sampler.get_2d(sampler.path(0, i), 0))
}

/// `count` points of `[0, 1)³` that depend on `seed` only.
pub(crate) fn points_3d(seed: u64, count: u32) -> impl Iterator<Item = Vec3A> {
    let sampler = Independent::new(seed);
    (0..count).map(move |i| {
        let path = sampler.path(0, i);
        sampler.get_2d(path, 0).extend(sampler.get_1d(path, 2)).into()
    })
}

/// `side`² points, one at a random place of each cell of a grid, followed by the corners of the
/// domain of a sampler's numbers.
pub(crate) fn stratified_points_and_corners(seed: u64, side: u32) -> impl Iterator<Item = Vec2> {
    let cells = points(seed, side * side).enumerate().map(move |(i, u)| {
        let cell = Vec2::new((i as u32 % side) as f32, (i as u32 / side) as f32);
        ((cell + u) / side as f32).min(Vec2::splat(BELOW_ONE))
    });
    cells.chain(corners())
}

/// The corners of the domain of a sampler's numbers.
pub(crate) fn corners() -> impl Iterator<Item = Vec2> {
    [0.0, BELOW_ONE].into_iter().flat_map(|x| [0.0, BELOW_ONE].map(|y| Vec2::new(x, y)))
}
