//! Cones of directions.

use std::f32::consts::PI;

use glam::Vec3;

/// The directions within some angle of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Unit vector.
    pub axis: Vec3,
    /// Half angle in radians, in `[0, π]`.
    pub angle: f32,
}

impl Cone {
    /// All directions.
    pub const ALL: Self = Self { axis: Vec3::Z, angle: PI };

    /// One direction.
    #[must_use]
    pub fn direction(axis: Vec3) -> Self {
        Self { axis, angle: 0.0 }
    }

    /// The smallest cone around both, but for rounding.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        let (wide, narrow) = if self.angle >= other.angle { (self, other) } else { (other, self) };
        if wide.axis == narrow.axis {
            return *wide;
        }
        // With the cross product, since the cosine says little of small angles.
        let across = wide.axis.cross(narrow.axis);
        let between = across.length().atan2(wide.axis.dot(narrow.axis));
        if between + narrow.angle <= wide.angle {
            return *wide;
        }
        let angle = 0.5 * (wide.angle + between + narrow.angle);
        let Some(pole) = across.try_normalize().filter(|_| angle < PI) else {
            return Self { axis: wide.axis, angle: PI };
        };
        // From the axis of the wide one towards the other.
        let (sin, cos) = (angle - wide.angle).sin_cos();
        let axis = (wide.axis * cos + pole.cross(wide.axis) * sin).normalize();
        Self { axis, angle }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unions_hold_both() {
        let cone = |x: f32, angle: f32| Cone { axis: Vec3::new(x.cos(), x.sin(), 0.0), angle };
        // Side by side, one within the other, the same, far apart, all directions, opposite.
        for (a, b, expected) in [
            (cone(0.0, 0.1), cone(1.0, 0.3), 0.7),
            (cone(0.0, 0.5), cone(0.2, 0.1), 0.5),
            (cone(1.0, 0.0), cone(1.0, 0.0), 0.0),
            (cone(0.0, 0.0), cone(2.0, 0.0), 1.0),
            (cone(0.0, 2.0), cone(2.0, 2.0), 3.0),
            (cone(0.0, 2.5), cone(2.0, 2.0), PI),
            (cone(0.0, 0.2), cone(PI, 0.1), 0.5 * PI + 0.15),
        ] {
            for union in [a.union(&b), b.union(&a)] {
                assert!((union.angle - expected).abs() < 1e-6, "{union:?}, not {expected}");
                for Cone { axis, angle } in [a, b] {
                    let farthest = axis.angle_between(union.axis) + angle;
                    // The angle between vectors of f32 is off by the root of a rounding.
                    assert!(union.angle == PI || farthest <= union.angle + 5e-4, "{union:?}");
                }
            }
        }
    }
}
