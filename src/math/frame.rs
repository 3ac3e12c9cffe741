//! Orthonormal frames.

use super::real::{Lanes, Real};
use super::vector::Vec3;

/// A right-handed orthonormal basis `(s, t, n)` in each lane: local x, y, z in world coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame<R = f32> {
    /// Local x.
    pub s: Vec3<R>,
    /// Local y.
    pub t: Vec3<R>,
    /// Local z: the normal.
    pub n: Vec3<R>,
}

impl<R: Real> Frame<R> {
    /// A frame around the unit vector `n`.
    ///
    /// Duff et al., "Building an Orthonormal Basis, Revisited" (JCGT 2017), listing 3: no branch,
    /// no loss of precision near −z.
    #[inline(always)]
    #[must_use]
    pub fn from_normal(n: Vec3<R>) -> Self {
        let sign = R::splat(n.token(), 1.0).copysign(n.z);
        let a = -(sign + n.z).recip();
        let b = n.x * n.y * a;
        Self {
            s: Vec3::new(sign * n.x * n.x * a + 1.0, sign * b, -sign * n.x),
            t: Vec3::new(b, sign + n.y * n.y * a, -n.y),
            n,
        }
    }

    /// A frame around the unit vector `n` whose s is the direction of `tangent` in the plane of `n`; any,
    /// if that has none.
    #[inline(always)]
    #[must_use]
    pub fn from_normal_and_tangent(n: Vec3<R>, tangent: Vec3<R>) -> Self {
        // The direction first: for a tangent of 1e-20 or 1e20 the square of what is left leaves the range.
        let (tangent, has_direction) = tangent.try_normalize();
        let (s, leaves_normal) = (tangent - n * n.dot(tangent)).try_normalize();
        let (given, any) = (has_direction & leaves_normal, Self::from_normal(n));
        Self { s: Vec3::select(given, s, any.s), t: Vec3::select(given, n.cross(s), any.t), n }
    }

    /// World direction to local.
    #[inline(always)]
    #[must_use]
    pub fn to_local(&self, v: Vec3<R>) -> Vec3<R> {
        Vec3::new(v.dot(self.s), v.dot(self.t), v.dot(self.n))
    }

    /// Local direction to world.
    #[inline(always)]
    #[must_use]
    pub fn to_world(&self, v: Vec3<R>) -> Vec3<R> {
        self.s * v.x + self.t * v.y + self.n * v.z
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    use super::*;

    /// Duff et al. measure 1.5e-7 as the largest deviation of their basis in f32.
    #[test]
    fn stays_orthonormal_near_the_pole() {
        let mut normals = vec![Vec3A::new(1.0, 0.0, 0.0), Vec3A::new(1.0, 0.0, -0.0), Vec3A::NEG_Z];
        for i in 0..20_000 {
            let theta = 10f64.powf(-8.0 + 8.0 * f64::from(i) / 20_000.0);
            let phi = f64::from(i) * 2.399_963;
            normals.push(
                glam::DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), -theta.cos())
                    .as_vec3a(),
            );
        }
        for n in normals {
            let frame = Frame::from_normal(n.into());
            let [s, t, n] = [frame.s, frame.t, frame.n].map(Vec3A::from);
            for (a, b, expected) in
                [(s, s, 1.0), (t, t, 1.0), (n, n, 1.0), (s, t, 0.0), (s, n, 0.0), (t, n, 0.0)]
            {
                let dot = a.as_dvec3().dot(b.as_dvec3());
                // Twice 1.5e-7: a dot product sums the deviations of both its vectors.
                assert!((dot - expected).abs() < 3e-7, "{n}: {a} . {b} = {dot}");
            }
            assert!(s.cross(t).dot(n) > 0.999, "{n}: left-handed");
        }
    }
}
