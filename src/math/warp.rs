//! Warps of the unit square `[0, 1)²`: for each distribution the map, its density, its inverse.
//!
//! Directions are unit vectors of a local frame with z as the pole. Densities of directions are in
//! sr⁻¹, densities on the disk per unit area. Inverses are exact up to rounding and exist so that
//! a round trip can test the map.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_4, PI};

use super::discrete::BELOW_ONE;
use super::real::{Real, sin_cos_octant};
use super::vector::{Vec2, Vec3};

/// A point of the unit disk, uniform by area.
///
/// Shirley and Chiu, "A Low Distortion Map Between Disk and Square" (1997).
#[inline(always)]
#[must_use]
pub fn square_to_uniform_disk<R: Real>(u: Vec2<R>) -> Vec2<R> {
    let (x, y) = (u.x * 2.0 - 1.0, u.y * 2.0 - 1.0);
    let across = x.abs().gt(y.abs());
    let (radius, other) = (R::select(across, x, y), R::select(across, y, x));
    let ratio = R::select(radius.eq(0.0), 0.0, other / radius);
    // The angle from ±x, or from ±y.
    let (sin, cos) = sin_cos_octant(ratio * FRAC_PI_4);
    Vec2::new(R::select(across, cos, sin), R::select(across, sin, cos)) * radius
}

/// Density of [`square_to_uniform_disk`] per unit area.
#[inline(always)]
#[must_use]
pub fn square_to_uniform_disk_pdf<R: Real>(p: Vec2<R>) -> R {
    R::select(p.length_squared().le(1.0), FRAC_1_PI, 0.0)
}

/// Inverse of [`square_to_uniform_disk`].
#[inline(always)]
#[must_use]
pub fn uniform_disk_to_square<R: Real>(p: Vec2<R>) -> Vec2<R> {
    // The quadrant around +x, +y, -x or -y that the angle lies in, as the map splits the square.
    let across = p.x.abs().gt(p.y.abs());
    let (long, short) = (R::select(across, p.x, p.y), R::select(across, p.y, p.x));
    let radius = p.length();
    let (along, turned) = (radius.copysign(long), short.atan2(long.abs()) / FRAC_PI_4 * radius);
    let square = Vec2::new(R::select(across, along, turned), R::select(across, turned, along));
    Vec2::new(square.x * 0.5 + 0.5, square.y * 0.5 + 0.5)
}

/// A direction of the whole sphere, uniform by solid angle.
#[inline(always)]
#[must_use]
pub fn square_to_uniform_sphere<R: Real>(u: Vec2<R>) -> Vec3<R> {
    // sqrt(1 - z^2) written in u: exact at both poles.
    let r = (u.y * u.y.one_minus()).sqrt() * 2.0;
    with_azimuth(r, (u.y * 2.0).one_minus(), u.x)
}

/// Density of [`square_to_uniform_sphere`]: 1/4π.
pub const UNIFORM_SPHERE_PDF: f32 = 0.25 * FRAC_1_PI;

/// Inverse of [`square_to_uniform_sphere`].
#[inline(always)]
#[must_use]
pub fn uniform_sphere_to_square<R: Real>(w: Vec3<R>) -> Vec2<R> {
    Vec2::new(azimuth(w), -(w.z * 0.5) + 0.5)
}

/// A direction of the upper hemisphere, uniform by solid angle.
#[inline(always)]
#[must_use]
pub fn square_to_uniform_hemisphere<R: Real>(u: Vec2<R>) -> Vec3<R> {
    let r = (u.y * (-u.y + 2.0)).sqrt();
    with_azimuth(r, u.y.one_minus(), u.x)
}

/// Density of [`square_to_uniform_hemisphere`]: 1/2π above the horizon, else 0.
#[inline(always)]
#[must_use]
pub fn square_to_uniform_hemisphere_pdf<R: Real>(w: Vec3<R>) -> R {
    R::select(w.z.ge(0.0), 0.5 * FRAC_1_PI, 0.0)
}

/// Inverse of [`square_to_uniform_hemisphere`].
#[inline(always)]
#[must_use]
pub fn uniform_hemisphere_to_square<R: Real>(w: Vec3<R>) -> Vec2<R> {
    Vec2::new(azimuth(w), w.z.one_minus())
}

/// A direction of the upper hemisphere with density proportional to its cosine (Malley's method).
#[inline(always)]
#[must_use]
pub fn square_to_cosine_hemisphere<R: Real>(u: Vec2<R>) -> Vec3<R> {
    // At the rim rounding leaves nothing. In the horizon itself the density is 0, and a path would be lost.
    const LEAST: f32 = 0.25 * f32::EPSILON;
    let p = square_to_uniform_disk(u);
    p.extend(p.length_squared().one_minus().max(LEAST).sqrt())
}

/// Density of [`square_to_cosine_hemisphere`]: cosθ/π above the horizon, else 0.
#[inline(always)]
#[must_use]
pub fn square_to_cosine_hemisphere_pdf<R: Real>(w: Vec3<R>) -> R {
    w.z.max(0.0) * FRAC_1_PI
}

/// Inverse of [`square_to_cosine_hemisphere`].
#[inline(always)]
#[must_use]
pub fn cosine_hemisphere_to_square<R: Real>(w: Vec3<R>) -> Vec2<R> {
    uniform_disk_to_square(w.truncate())
}

/// A direction of the cone around +z with `1 - cos` of its half angle = `one_minus_cos_max`, uniform
/// by solid angle.
///
/// The argument is 1 − cosθ and not cosθ because the difference is lost in f32 for a cone narrower
/// than 2.4e-4 rad.
#[inline(always)]
#[must_use]
pub fn square_to_uniform_cone<R: Real>(u: Vec2<R>, one_minus_cos_max: R) -> Vec3<R> {
    let one_minus_z = u.y * one_minus_cos_max;
    let r = (one_minus_z * (-one_minus_z + 2.0)).max(0.0).sqrt();
    with_azimuth(r, one_minus_z.one_minus(), u.x)
}

/// Density of [`square_to_uniform_cone`] inside the cone.
#[inline(always)]
#[must_use]
pub fn square_to_uniform_cone_pdf<R: Real>(one_minus_cos_max: R) -> R {
    R::splat(one_minus_cos_max.token(), 0.5 * FRAC_1_PI) / one_minus_cos_max
}

/// Inverse of [`square_to_uniform_cone`].
#[inline(always)]
#[must_use]
pub fn uniform_cone_to_square<R: Real>(w: Vec3<R>, one_minus_cos_max: R) -> Vec2<R> {
    let sin_squared = w.x * w.x + w.y * w.y;
    Vec2::new(azimuth(w), sin_squared / (w.z + 1.0) / one_minus_cos_max)
}

/// Barycentric weights `(u, v)` of the second and third vertex, uniform by area of any triangle.
///
/// Heitz, "A Low-Distortion Map Between Triangle and Square" (2019).
#[inline(always)]
#[must_use]
pub fn square_to_uniform_triangle<R: Real>(u: Vec2<R>) -> Vec2<R> {
    // Half the smaller number, taken from both.
    let half = u.x.min(u.y) * 0.5;
    let above = u.y.gt(u.x);
    Vec2::new(R::select(above, half, u.x - half), R::select(above, u.y - half, half))
}

/// Density of [`square_to_uniform_triangle`] per unit of `(u, v)`; divided by twice the triangle's
/// area it is the density per unit area.
#[inline(always)]
#[must_use]
pub fn square_to_uniform_triangle_pdf<R: Real>(b: Vec2<R>) -> R {
    R::select(b.x.ge(0.0) & b.y.ge(0.0) & (b.x + b.y).le(1.0), 2.0, 0.0)
}

/// Inverse of [`square_to_uniform_triangle`].
#[inline(always)]
#[must_use]
pub fn uniform_triangle_to_square<R: Real>(b: Vec2<R>) -> Vec2<R> {
    let (above, sum) = (b.y.gt(b.x), b.x + b.y);
    Vec2::new(R::select(above, b.x * 2.0, sum), R::select(above, sum, b.y * 2.0))
}

/// A number with a density that is linear on `[0, 1]`, in proportion to `low` at 0 and to `high` at 1. Neither is
/// negative, and one is above 0.
///
/// The root of F(x) = u that cancels nothing, for F of [`linear_to_interval`].
#[must_use]
pub fn interval_to_linear(u: f64, low: f64, high: f64) -> f64 {
    if u == 0.0 {
        return 0.0;
    }
    let slope = (low * low * (1.0 - u) + high * high * u).sqrt();
    (u * (low + high) / (low + slope)).min(BELOW_ONE)
}

/// Density of [`interval_to_linear`].
#[must_use]
pub fn interval_to_linear_pdf(x: f64, low: f64, high: f64) -> f64 {
    if (0.0..=1.0).contains(&x) { 2.0 * (low * (1.0 - x) + high * x) / (low + high) } else { 0.0 }
}

/// Inverse of [`interval_to_linear`].
#[must_use]
pub fn linear_to_interval(x: f64, low: f64, high: f64) -> f64 {
    x * (low * (2.0 - x) + high * x) / (low + high)
}

#[inline(always)]
fn with_azimuth<R: Real>(r: R, z: R, turn: R) -> Vec3<R> {
    let (sin, cos) = (turn * (2.0 * PI)).sin_cos();
    Vec3::new(r * cos, r * sin, z)
}

#[inline(always)]
fn azimuth<R: Real>(w: Vec3<R>) -> R {
    let turn = w.y.atan2(w.x) * (0.5 * FRAC_1_PI);
    R::select(turn.lt(0.0), turn + 1.0, turn)
}
