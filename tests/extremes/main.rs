//! Cases that break renderers: tiny, huge, far away, degenerate, grazing, black and blinding. Each runs on
//! every engine, in its default modes, and says where its expected value comes from.
//!
//! u is half the spacing of f32 at 1, 2⁻²⁴.

#[path = "../support/mod.rs"]
mod support;

mod camera_film;
mod closed;
mod densities;
mod directions;
mod enclosed;
mod furnaces;
mod instanced;
mod invariants;
mod leaving;
mod lights;
mod limits;
mod polygons;
mod queries;
mod replay;
mod shading_normals;
mod starts;

/// Half the spacing of f32 at 1: the largest relative error of one rounding.
const ULP: f32 = f32::EPSILON / 2.0;
