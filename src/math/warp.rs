//! Warps of the unit square `[0, 1)²`: for each distribution the map, its density, its inverse.
//!
//! Directions are unit vectors of a local frame with z as the pole. Densities of directions are in
//! sr⁻¹, densities on the disk per unit area. Inverses are exact up to rounding and exist so that
//! a round trip can test the map.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_4, PI};

use glam::{Vec2, Vec3A};

/// A point of the unit disk, uniform by area.
///
/// Shirley and Chiu, "A Low Distortion Map Between Disk and Square" (1997).
#[must_use]
pub fn square_to_uniform_disk(u: Vec2) -> Vec2 {
    let p = 2.0 * u - Vec2::ONE;
    // A choice of numbers and not of code: no processor could foresee which way the branch goes.
    let across = p.x.abs() > p.y.abs();
    let (radius, other) = if across { (p.x, p.y) } else { (p.y, p.x) };
    if radius == 0.0 {
        return Vec2::ZERO;
    }
    // The angle from ±x, or from ±y.
    let (sin, cos) = sin_cos_eighth(FRAC_PI_4 * (other / radius));
    radius * if across { Vec2::new(cos, sin) } else { Vec2::new(sin, cos) }
}

/// Density of [`square_to_uniform_disk`] per unit area.
#[must_use]
pub fn square_to_uniform_disk_pdf(p: Vec2) -> f32 {
    if p.length_squared() <= 1.0 { FRAC_1_PI } else { 0.0 }
}

/// Sine and cosine of an angle of at most π/4 in magnitude, within 1e-7, and the same on every machine.
/// The polynomials are those of Cephes (Moshier 1989, `sinf` and `cosf`).
fn sin_cos_eighth(angle: f32) -> (f32, f32) {
    let z = angle * angle;
    let sin = ((-1.951_529_6e-4 * z + 8.332_161e-3) * z - 1.666_665_5e-1) * z * angle + angle;
    let cos = ((2.443_315_7e-5 * z - 1.388_731_6e-3) * z + 4.166_664_6e-2) * z * z - 0.5 * z + 1.0;
    (sin, cos)
}

/// Inverse of [`square_to_uniform_disk`].
#[must_use]
pub fn uniform_disk_to_square(p: Vec2) -> Vec2 {
    let r = p.length();
    if r == 0.0 {
        return Vec2::splat(0.5);
    }
    // The quadrant around +x, +y, -x or -y that the angle lies in, as the map splits the square.
    let q = if p.x.abs() > p.y.abs() {
        let a = p.y.atan2(p.x.abs()) * p.x.signum();
        Vec2::new(1.0, a / FRAC_PI_4) * r * p.x.signum()
    } else {
        let a = p.x.atan2(p.y.abs()) * p.y.signum();
        Vec2::new(a / FRAC_PI_4, 1.0) * r * p.y.signum()
    };
    (q + Vec2::ONE) * 0.5
}

/// A direction of the whole sphere, uniform by solid angle.
#[must_use]
pub fn square_to_uniform_sphere(u: Vec2) -> Vec3A {
    let z = 1.0 - 2.0 * u.y;
    // sqrt(1 - z^2) written in u: exact at both poles.
    let r = 2.0 * (u.y * (1.0 - u.y)).sqrt();
    with_azimuth(r, z, u.x)
}

/// Density of [`square_to_uniform_sphere`]: 1/4π.
pub const UNIFORM_SPHERE_PDF: f32 = 0.25 * FRAC_1_PI;

/// Inverse of [`square_to_uniform_sphere`].
#[must_use]
pub fn uniform_sphere_to_square(w: Vec3A) -> Vec2 {
    Vec2::new(azimuth(w), 0.5 - 0.5 * w.z)
}

/// A direction of the upper hemisphere, uniform by solid angle.
#[must_use]
pub fn square_to_uniform_hemisphere(u: Vec2) -> Vec3A {
    let z = 1.0 - u.y;
    let r = (u.y * (2.0 - u.y)).sqrt();
    with_azimuth(r, z, u.x)
}

/// Density of [`square_to_uniform_hemisphere`]: 1/2π above the horizon, else 0.
#[must_use]
pub fn square_to_uniform_hemisphere_pdf(w: Vec3A) -> f32 {
    if w.z >= 0.0 { 0.5 * FRAC_1_PI } else { 0.0 }
}

/// Inverse of [`square_to_uniform_hemisphere`].
#[must_use]
pub fn uniform_hemisphere_to_square(w: Vec3A) -> Vec2 {
    Vec2::new(azimuth(w), 1.0 - w.z)
}

/// A direction of the upper hemisphere with density proportional to its cosine (Malley's method).
#[must_use]
pub fn square_to_cosine_hemisphere(u: Vec2) -> Vec3A {
    // At the rim rounding leaves nothing. In the horizon itself the density is 0, and a path would be lost.
    const LEAST: f32 = 0.25 * f32::EPSILON;
    let p = square_to_uniform_disk(u);
    Vec3A::new(p.x, p.y, (1.0 - p.length_squared()).max(LEAST).sqrt())
}

/// Density of [`square_to_cosine_hemisphere`]: cosθ/π above the horizon, else 0.
#[must_use]
pub fn square_to_cosine_hemisphere_pdf(w: Vec3A) -> f32 {
    w.z.max(0.0) * FRAC_1_PI
}

/// Inverse of [`square_to_cosine_hemisphere`].
#[must_use]
pub fn cosine_hemisphere_to_square(w: Vec3A) -> Vec2 {
    uniform_disk_to_square(w.truncate())
}

/// A direction of the cone around +z with `1 - cos` of its half angle = `one_minus_cos_max`, uniform
/// by solid angle.
///
/// The argument is 1 − cosθ and not cosθ because the difference is lost in f32 for a cone narrower
/// than 2.4e-4 rad.
#[must_use]
pub fn square_to_uniform_cone(u: Vec2, one_minus_cos_max: f32) -> Vec3A {
    let one_minus_z = u.y * one_minus_cos_max;
    let r = (one_minus_z * (2.0 - one_minus_z)).max(0.0).sqrt();
    with_azimuth(r, 1.0 - one_minus_z, u.x)
}

/// Density of [`square_to_uniform_cone`] inside the cone.
#[must_use]
pub fn square_to_uniform_cone_pdf(one_minus_cos_max: f32) -> f32 {
    0.5 * FRAC_1_PI / one_minus_cos_max
}

/// Inverse of [`square_to_uniform_cone`].
#[must_use]
pub fn uniform_cone_to_square(w: Vec3A, one_minus_cos_max: f32) -> Vec2 {
    let sin_squared = w.x * w.x + w.y * w.y;
    Vec2::new(azimuth(w), sin_squared / (1.0 + w.z) / one_minus_cos_max)
}

/// Barycentric weights `(u, v)` of the second and third vertex, uniform by area of any triangle.
///
/// Heitz, "A Low-Distortion Map Between Triangle and Square" (2019).
#[must_use]
pub fn square_to_uniform_triangle(u: Vec2) -> Vec2 {
    // Half the smaller number, taken from both; as a choice of numbers for the same reason as in the disk.
    let half = 0.5 * u.min_element();
    let above = u.y > u.x;
    Vec2::new(if above { half } else { u.x - half }, if above { u.y - half } else { half })
}

/// Density of [`square_to_uniform_triangle`] per unit of `(u, v)`; divided by twice the triangle's
/// area it is the density per unit area.
#[must_use]
pub fn square_to_uniform_triangle_pdf(b: Vec2) -> f32 {
    if b.x >= 0.0 && b.y >= 0.0 && b.x + b.y <= 1.0 { 2.0 } else { 0.0 }
}

/// Inverse of [`square_to_uniform_triangle`].
#[must_use]
pub fn uniform_triangle_to_square(b: Vec2) -> Vec2 {
    if b.y > b.x { Vec2::new(2.0 * b.x, b.y + b.x) } else { Vec2::new(b.x + b.y, 2.0 * b.y) }
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
    (u * (low + high) / (low + slope)).min(1.0 - f64::EPSILON / 2.0)
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

fn with_azimuth(r: f32, z: f32, turn: f32) -> Vec3A {
    let phi = 2.0 * PI * turn;
    Vec3A::new(r * phi.cos(), r * phi.sin(), z)
}

fn azimuth(w: Vec3A) -> f32 {
    let turn = w.y.atan2(w.x) * (0.5 * FRAC_1_PI);
    if turn < 0.0 { turn + 1.0 } else { turn }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_those_of_the_angle() {
        for i in -1000..=1000 {
            let angle = FRAC_PI_4 * i as f32 / 1000.0;
            let (sin, cos) = sin_cos_eighth(angle);
            let (expected_sin, expected_cos) = f64::from(angle).sin_cos();
            assert!((f64::from(sin) - expected_sin).abs() < 1e-7, "{angle}");
            assert!((f64::from(cos) - expected_cos).abs() < 1e-7, "{angle}");
        }
    }
}
