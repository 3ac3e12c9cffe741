//! Where the camera stands.
//!
//! In the camera's axes, with z along its view, a point is within the picture's margins if |x - cx| ≤ a (z - cz) for the
//! camera's place c and the tangent a of the half angle up to the margin, and likewise for y. For all points together
//! that is cx ≥ A + a cz and cx ≤ -B - a cz, with the largest of x - a z and of -x - a z as A and B: the nearest place has
//! cz = -(A + B) / 2a for the direction that asks for more, and lies midway between the bounds for the other one.

use glam::DVec3;

use super::setup::{Axis, Setup};

/// What stays free between the mesh and the edges of the picture at each side, as a fraction of the picture's width or
/// height.
pub const MARGIN: f64 = 0.08;

/// How near a camera may come to the nearest vertex, in radii of the mesh: of a plane that is seen from its edge, or in a very
/// wide view, nothing else keeps it away.
pub(super) const NEAREST: f64 = 0.1;

/// The directions of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Basis {
    pub(super) right: DVec3,
    pub(super) up: DVec3,
    /// From the mesh to the camera.
    pub(super) back: DVec3,
    /// From the mesh to the camera, along the ground.
    pub(super) level: DVec3,
}

impl Basis {
    /// Degrees to the right of the front, and above it.
    pub(super) fn new(up: Axis, azimuth: f64, elevation: f64) -> Self {
        let (sin, cos) = sin_cos(azimuth);
        let level = up.front() * cos + up.right() * sin;
        let right = up.right() * cos - up.front() * sin;
        let (sin, cos) = sin_cos(elevation);
        let direction = up.direction();
        Self {
            right,
            up: direction * cos - level * sin,
            back: level * cos + direction * sin,
            level,
        }
    }

    /// Coordinates along its directions, z along the view.
    fn of(&self, p: DVec3) -> DVec3 {
        DVec3::new(self.right.dot(p), self.up.dot(p), -self.back.dot(p))
    }

    /// The vector with these coordinates.
    pub(super) fn vector(&self, p: DVec3) -> DVec3 {
        self.right * p.x + self.up * p.y - self.back * p.z
    }
}

/// Exact for quarter turns, so that views along an axis are.
fn sin_cos(degrees: f64) -> (f64, f64) {
    let quarter = (degrees / 90.0).round();
    let (sin, cos) = (degrees - 90.0 * quarter).to_radians().sin_cos();
    match quarter.rem_euclid(4.0) as u8 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// The place of a camera, in its own axes and from the middle of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Framing {
    pub(super) place: DVec3,
}

/// Bounds of a camera's place along one direction: the largest of x - a z and of -x - a z.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    tangent: f64,
    lower: f64,
    upper: f64,
}

impl Bounds {
    fn new(tangent: f64) -> Self {
        Self { tangent, lower: f64::NEG_INFINITY, upper: f64::NEG_INFINITY }
    }

    fn add(&mut self, x: f64, z: f64) {
        self.lower = self.lower.max(x - self.tangent * z);
        self.upper = self.upper.max(-x - self.tangent * z);
    }

    fn nearest(&self) -> f64 {
        -(self.lower + self.upper) / (2.0 * self.tangent)
    }

    fn middle(&self) -> f64 {
        (self.lower - self.upper) / 2.0
    }
}

impl Framing {
    /// The nearest place from which all points are in the picture, in every one of `frames`; if those are several, the
    /// camera looks at the axis about which it turns, and stays as far from it.
    pub(super) fn new(
        points: &[DVec3],
        center: DVec3,
        radius: f64,
        frames: &[Basis],
        setup: &Setup,
    ) -> Self {
        let [mut x, mut y] = tangents(setup).map(Bounds::new);
        let mut front = f64::INFINITY;
        for basis in frames {
            for &point in points {
                let p = basis.of(point - center);
                x.add(p.x, p.z);
                y.add(p.y, p.z);
                front = front.min(p.z);
            }
        }
        if frames.len() > 1 {
            let larger = x.lower.max(x.upper);
            (x.lower, x.upper) = (larger, larger);
        }
        let z = x.nearest().min(y.nearest()).min(front - NEAREST * radius);
        Self { place: DVec3::new(x.middle(), y.middle(), z) }
    }
}

/// Tangents of the half angles across and up the picture, as far as the margins.
fn tangents(setup: &Setup) -> [f64; 2] {
    let (width, height) = (f64::from(setup.size.0), f64::from(setup.size.1));
    let longer = (setup.fov.to_radians() / 2.0).tan() * (1.0 - 2.0 * MARGIN);
    [width, height].map(|side| longer * side / width.max(height))
}
