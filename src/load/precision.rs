//! Shapes that 32-bit floats cannot hold where they lie: worth a warning, since their picture is not what
//! the file describes.

use glam::Vec3A;
use rayon::prelude::*;

use crate::math::Aabb;
use crate::shape::{Geometry, Shape};

/// Steps of an f32 that a shape has to span, and a triangle. Rays leave a surface from four steps off, and
/// points on it are rounded to one: light inside a sphere of 128 steps is 2 % off.
const SHAPE_STEPS: f32 = 256.0;
const TRIANGLE_STEPS: f32 = 64.0;
/// The share of triangles that are too small for their place of which nobody would be told.
const FEW: f64 = 0.01;
/// Beyond, products of three lengths overflow, and engines miss triangles: up to 1e13 was seen to work.
const LONGEST: f32 = 1e12;
/// Below, such products are denormal; a mesh of 360,000 triangles of 1e-13 was hit in wrong places.
const SHORTEST: f32 = 1e-11;
/// Triangles that are looked at: enough to tell 1 % from 2 %, and a millisecond.
const SAMPLE: usize = 1 << 16;

/// What 32-bit floats do to a shape: a message, and what helps.
pub(super) fn doubts(shape: &dyn Shape) -> Vec<(String, String)> {
    let Sample { bounds, coarse, short } = match shape.geometry() {
        Geometry::Triangles { positions, triangles } => sample(positions, triangles),
        Geometry::Deforming(_) | Geometry::Analytic(_) | Geometry::Instance(_) => {
            Sample { bounds: shape.bounds(), coarse: 0.0, short: 0.0 }
        }
    };
    if bounds.is_empty() {
        return Vec::new();
    }
    let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
    let size = (bounds.max - bounds.min).max_element();
    let mut doubts = Vec::new();
    let mut doubt = |message: String, help: &str| doubts.push((message, help.to_owned()));
    if reach > LONGEST && matches!(shape.geometry(), Geometry::Triangles { .. }) {
        let message = format!(
            "this shape reaches {reach:.1e} far, where the products of its lengths leave 32-bit floats and \
             rays may miss it"
        );
        doubt(message, "choose another unit of length: keep coordinates below 1e12");
    }
    if short > FEW || size < SHORTEST {
        let message = format!(
            "{} of this shape are shorter than {SHORTEST:e}, where the products of lengths leave 32-bit floats",
            part(short)
        );
        doubt(message, "choose another unit of length: scale the scene up");
    }
    if coarse > FEW || size < SHAPE_STEPS * step(reach) {
        let message = format!(
            "this shape lies {reach:.1e} from the origin, where 32-bit floats are {:.1e} apart: {} are \
             distorted",
            step(reach),
            part(coarse)
        );
        doubt(message, "move the scene, with its camera, to the origin");
    }
    doubts
}

/// `"12 % of the triangles"`.
fn part(share: f64) -> String {
    if share > FEW {
        format!("{:.0} % of the triangles", 100.0 * share)
    } else {
        "all parts".into()
    }
}

/// The spacing of floats at a magnitude, up to a factor of 2.
fn step(magnitude: f32) -> f32 {
    magnitude * f32::EPSILON
}

/// A sample of a mesh.
struct Sample {
    bounds: Aabb,
    /// The share of its triangles that are too small for their place.
    coarse: f64,
    /// The share of those that are too small wherever they lie.
    short: f64,
}

fn sample(positions: &[Vec3A], triangles: &[[u32; 3]]) -> Sample {
    // Odd, so that it does not fall in with the two triangles of each square.
    let stride = (triangles.len() / SAMPLE) | 1;
    let none = || (Aabb::EMPTY, [0_usize; 3]);
    let (bounds, [count, coarse, short]) = triangles
        .par_iter()
        .step_by(stride)
        .map(|triangle| {
            let [a, b, c] = triangle.map(|i| positions[i as usize]);
            let bounds = Aabb { min: a.min(b).min(c).into(), max: a.max(b).max(c).into() };
            // The longest edge along an axis.
            let size = (bounds.max - bounds.min).max_element();
            let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
            let coarse = usize::from(size < TRIANGLE_STEPS * step(reach));
            (bounds, [1, coarse, usize::from(size < SHORTEST)])
        })
        .reduce(none, |a, b| (a.0.union(b.0), [0, 1, 2].map(|i| a.1[i] + b.1[i])));
    let share = |part: usize| part as f64 / count.max(1) as f64;
    Sample { bounds, coarse: share(coarse), short: share(short) }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3};

    use super::*;
    use crate::math::Frame;
    use crate::shape::{Disk, Sphere, TriangleMesh, primitives};

    fn messages(shape: &dyn Shape) -> Vec<String> {
        doubts(shape).into_iter().map(|(message, _)| message).collect()
    }

    fn cube(scale: f64, center: f64) -> TriangleMesh {
        let at = DAffine3::from_translation(DVec3::splat(center))
            * DAffine3::from_scale(DVec3::splat(scale));
        primitives::cube(at, false).0
    }

    #[test]
    fn shapes_of_every_usual_size_raise_no_doubt() {
        for (scale, center) in [(1.0, 0.0), (1e-10, 0.0), (1e12, 0.0), (1.0, 1e3), (1e-3, 1.0)] {
            assert!(messages(&cube(scale, center)).is_empty(), "{scale} {center}");
        }
        let axes = Frame::from_normal(Vec3A::Z.into());
        for (radius, center) in [(1.0, 0.0), (1e-10, 0.0), (1e15, 0.0), (1e-3, 1.0)] {
            let sphere = Sphere::new(Vec3A::splat(center), radius, axes, false);
            assert!(messages(&sphere).is_empty(), "{radius} {center}");
        }
        assert!(messages(&TriangleMesh::default()).is_empty());
    }

    #[test]
    fn shapes_beyond_the_floats_are_told() {
        assert_eq!(
            messages(&cube(1.0, 1e6)),
            ["this shape lies 1.0e6 from the origin, where 32-bit floats are 1.2e-1 apart: \
              100 % of the triangles are distorted"]
        );
        let far = Sphere::new(Vec3A::X * 1e5, 0.5, Frame::from_normal(Vec3A::Z.into()), false);
        assert_eq!(
            messages(&far),
            ["this shape lies 1.0e5 from the origin, where 32-bit floats are 1.2e-2 apart: \
              all parts are distorted"]
        );
        assert_eq!(
            messages(&cube(1e-13, 0.0)),
            ["100 % of the triangles of this shape are shorter than 1e-11, where the products of \
              lengths leave 32-bit floats"]
        );
        let disk =
            Disk::new(DAffine3::from_scale(DVec3::splat(1e-13)), false).expect("not singular");
        assert_eq!(
            messages(&disk),
            [
                "all parts of this shape are shorter than 1e-11, where the products of lengths leave \
              32-bit floats"
            ]
        );
        assert_eq!(
            messages(&cube(1e14, 0.0)),
            [
                "this shape reaches 1.0e14 far, where the products of its lengths leave 32-bit floats and \
              rays may miss it"
            ]
        );
    }

    /// A strip of fine triangles far out on a large mesh: the mesh as a whole is large enough.
    #[test]
    fn fine_parts_of_a_coarse_mesh_are_told() {
        let mut positions = vec![Vec3A::ZERO, Vec3A::X * 1e5, Vec3A::Y * 1e5];
        let mut triangles = vec![[0, 1, 2]; 50];
        for i in 0..50u32 {
            let corner = Vec3A::new(1e5, i as f32, 0.0);
            positions.extend([corner, corner + Vec3A::Y * 0.25, corner + Vec3A::X * 0.25]);
            triangles.push([3 + 3 * i, 4 + 3 * i, 5 + 3 * i]);
        }
        let mesh =
            TriangleMesh::new(positions, triangles, Vec::new(), Vec::new()).expect("valid").0;
        let expected = "this shape lies 1.0e5 from the origin, where 32-bit floats are 1.2e-2 apart: \
                        50 % of the triangles are distorted";
        assert_eq!(messages(&mesh), [expected]);
    }
}
