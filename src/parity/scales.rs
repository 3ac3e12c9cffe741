//! Whether a scene mixes sizes that rays in f32 cannot serve together.

use std::fmt::{self, Display, Formatter};
use std::sync::Arc;

use glam::Vec3A;

use super::oracle::bound;
use crate::math::Aabb;
use crate::shape::{Geometry, Shape};

/// Triangles that are smaller than what rounding may shift on a ray that crosses the whole scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MixedScales {
    /// How many there are.
    pub small: u64,
    /// All triangles.
    pub triangles: u64,
    /// Length of the diagonal of the box around the scene, or around the group that they are in.
    pub size: f64,
    /// What rounding may shift there ([`bound`]), which none of their edges exceeds.
    pub bound: f64,
}

impl MixedScales {
    /// `None` if no triangle of `shapes`, or of a group that they place, is so small. Shapes that move are looked at
    /// as they are at time 0.
    #[must_use]
    pub fn of(shapes: &[Arc<dyn Shape>]) -> Option<Self> {
        let bounds = shapes.iter().map(|s| s.bounds()).filter(|b| !b.is_empty());
        let bounds = bounds.reduce(Aabb::union)?;
        let size = bounds.min.as_dvec3().distance(bounds.max.as_dvec3());
        let mut found = Self { small: 0, triangles: 0, size, bound: bound(size) };
        let mut groups: Vec<&[Arc<dyn Shape>]> = Vec::new();
        for shape in shapes {
            if let Geometry::Instance(instance) = shape.geometry() {
                let group = instance.group().shapes();
                // Many places of one group are looked at once.
                if !groups.iter().any(|g| std::ptr::eq(*g, group)) {
                    groups.push(group);
                }
                continue;
            }
            for primitive in 0..shape.primitive_count() as u32 {
                let corners = shape.geometry().corners(primitive, 0.0);
                found.triangles += u64::from(corners.is_some());
                found.small += u64::from(corners.is_some_and(|c| longest_edge(c) < found.bound));
            }
        }
        let own = (found.small > 0).then_some(found);
        own.or_else(|| groups.into_iter().find_map(Self::of))
    }
}

fn longest_edge([a, b, c]: [Vec3A; 3]) -> f64 {
    let [a, b, c] = [a, b, c].map(|p| p.as_dvec3());
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

impl Display for MixedScales {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { small, triangles, size, bound } = self;
        write!(
            f,
            "{small} of {triangles} triangles are smaller than {bound:.1e}, which is what 32-bit floats may shift them \
             by on a ray across the whole, {size:.1e} wide: no engine tells them apart from there, and the referee \
             cannot decide what should be hit"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::TriangleMesh;

    fn right_angled(legs: &[f32]) -> Arc<dyn Shape> {
        let mut positions = Vec::new();
        for &leg in legs {
            positions.extend([Vec3A::ZERO, Vec3A::X * leg, Vec3A::Y * leg]);
        }
        let triangles = (0..legs.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = TriangleMesh::new(positions, triangles, Vec::new(), Vec::new());
        Arc::new(mesh.expect("indices in range").0)
    }

    /// The diagonal of a right-angled triangle with legs of 1 is √2, and 2⁻¹⁹ of it 2.7e-6; that with legs of l has a
    /// longest edge of √2 l.
    #[test]
    fn triangles_below_the_bound_are_counted() {
        let just = 2f32.powi(-19);
        assert_eq!(MixedScales::of(&[right_angled(&[1.0, 1.01 * just])]), None);
        assert_eq!(MixedScales::of(&[]), None);
        let shapes = [right_angled(&[1.0, 0.99 * just]), right_angled(&[1e-8, 0.5])];
        let found = MixedScales::of(&shapes).expect("two are small");
        assert_eq!((found.small, found.triangles), (2, 4));
        assert!((found.size - 2f64.sqrt()).abs() < 1e-7);
        let told = "2 of 4 triangles are smaller than 2.7e-6, which is what 32-bit floats may shift them by on a ray \
                    across the whole, 1.4e0 wide: no engine tells them apart from there, and the referee cannot decide \
                    what should be hit";
        assert_eq!(found.to_string(), told);
    }
}
