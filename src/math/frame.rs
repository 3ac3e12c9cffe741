//! Orthonormal frames.

use glam::Vec3A;

/// A right-handed orthonormal basis `(s, t, n)`: local x, y, z in world coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Local x.
    pub s: Vec3A,
    /// Local y.
    pub t: Vec3A,
    /// Local z: the normal.
    pub n: Vec3A,
}

impl Frame {
    /// A frame around the unit vector `n`.
    ///
    /// Duff et al., "Building an Orthonormal Basis, Revisited" (JCGT 2017), listing 3: no branch,
    /// no loss of precision near −z.
    #[must_use]
    pub fn from_normal(n: Vec3A) -> Self {
        let sign = 1f32.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Self {
            s: Vec3A::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            t: Vec3A::new(b, sign + n.y * n.y * a, -n.y),
            n,
        }
    }

    /// A frame around the unit vector `n` whose s is the direction of `tangent` in the plane of `n`; any,
    /// if that has none.
    #[must_use]
    pub fn from_normal_and_tangent(n: Vec3A, tangent: Vec3A) -> Self {
        // The direction first: for a tangent of 1e-20 or 1e20 the square of what is left leaves the range.
        let s = tangent.try_normalize().and_then(|t| (t - n * n.dot(t)).try_normalize());
        s.map_or_else(|| Self::from_normal(n), |s| Self { s, t: n.cross(s), n })
    }

    /// World direction to local.
    #[must_use]
    pub fn to_local(&self, v: Vec3A) -> Vec3A {
        Vec3A::new(v.dot(self.s), v.dot(self.t), v.dot(self.n))
    }

    /// Local direction to world.
    #[must_use]
    pub fn to_world(&self, v: Vec3A) -> Vec3A {
        self.s * v.x + self.t * v.y + self.n * v.z
    }
}

#[cfg(test)]
mod tests {
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
            let f = Frame::from_normal(n);
            for (a, b, expected) in [
                (f.s, f.s, 1.0),
                (f.t, f.t, 1.0),
                (f.n, f.n, 1.0),
                (f.s, f.t, 0.0),
                (f.s, f.n, 0.0),
                (f.t, f.n, 0.0),
            ] {
                let dot = a.as_dvec3().dot(b.as_dvec3());
                // Twice 1.5e-7: a dot product sums the deviations of both its vectors.
                assert!((dot - expected).abs() < 3e-7, "{n}: {a} . {b} = {dot}");
            }
            assert!(f.s.cross(f.t).dot(f.n) > 0.999, "{n}: left-handed");
        }
    }
}
