//! Determinants of f32 coordinates, in f64 where that tells their sign and ten digits, else exactly.
//!
//! A published `orient3d` takes points, and the second point of a ray, `o + d`, is in general no f64: a
//! coordinate of 1e6 and a component of 1e-9 need 74 bits between them. So the determinants are expanded
//! into products of three f32, which two f64 hold exactly, and those are summed as an expansion.
//! Neither overflows nor underflows: a product lies between 2⁻⁴⁴⁷ and 2³⁸⁴.

use glam::{DVec3, Vec3A};

/// `det(d, p - o, q - o)`: its sign says on which side of the edge from `p` to `q` the line through `o`
/// along `d` passes; divided by `|d × (q - p)|` it is the distance of the two lines. Only the sign, zero
/// included, is to be relied on.
pub(super) fn side(o: Vec3A, d: Vec3A, p: Vec3A, q: Vec3A) -> f64 {
    edge_function(o, d, p, q, SIGN)
}

/// The scalar product of `d` with the normal `(b - a) × (c - a)`, within 1e-9 of its value, with the exact
/// sign.
pub(super) fn facing(d: Vec3A, a: Vec3A, b: Vec3A, c: Vec3A) -> f64 {
    edge_function(c, d, a, b, VALUE)
}

/// `det(a - o, b - o, c - o)`, six times the volume between `o` and a triangle: as exact as [`facing`].
pub(super) fn volume(o: Vec3A, a: Vec3A, b: Vec3A, c: Vec3A) -> f64 {
    let [od, ad, bd, cd] = [o, a, b, c].map(|v| v.as_dvec3());
    determinant(ad - od, bd - ad, cd - ad, VALUE).unwrap_or_else(|| {
        // Linear in each row, and zero for two equal ones.
        let mut sum = Expansion::default();
        sum.add_determinant(a, b, c);
        sum.add_determinant(o, c, b);
        sum.add_determinant(o, a, c);
        sum.add_determinant(o, b, a);
        sum.value()
    })
}

fn edge_function(o: Vec3A, d: Vec3A, p: Vec3A, q: Vec3A, needed: f64) -> f64 {
    let [od, dd, pd, qd] = [o, d, p, q].map(|v| v.as_dvec3());
    // The third row may be p − o or q − o as well, but the edge is short where details are small and far, and with
    // it the products that are to cancel.
    determinant(dd, pd - od, qd - pd, needed).unwrap_or_else(|| {
        let mut sum = Expansion::default();
        sum.add_determinant(d, p, q);
        sum.add_determinant(d, q, o);
        sum.add_determinant(d, o, p);
        sum.value()
    })
}

/// How large a determinant must be against the magnitudes of its terms for its sign to be right, and for
/// its value to be within 1e-9.
const SIGN: f64 = 1e-15;
const VALUE: f64 = 1e-6;

/// The determinant of rows that carry one rounding each, if it is large enough.
///
/// Each of its six products goes through at most eight roundings (three factors, two multiplications,
/// three additions), so that the error is below 9 · 2⁻⁵³ < 1e-15 of the sum of their magnitudes.
fn determinant(x: DVec3, y: DVec3, z: DVec3, needed: f64) -> Option<f64> {
    let value = x.dot(y.cross(z));
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    let magnitude = ax.x * (ay.y * az.z + ay.z * az.y)
        + ax.y * (ay.z * az.x + ay.x * az.z)
        + ax.z * (ay.x * az.y + ay.y * az.x);
    (value.abs() > needed * magnitude).then_some(value)
}

/// Terms of the sums above: four determinants of six products of two parts.
const CAPACITY: usize = 48;

/// A number as a sum of f64 that do not overlap, the smaller ones first (Shewchuk, "Adaptive Precision
/// Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997).
struct Expansion {
    parts: [f64; CAPACITY],
    count: usize,
}

impl Default for Expansion {
    fn default() -> Self {
        Self { parts: [0.0; CAPACITY], count: 0 }
    }
}

impl Expansion {
    fn add_determinant(&mut self, x: Vec3A, y: Vec3A, z: Vec3A) {
        for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            self.add_product(x[i], y[j], z[k]);
            self.add_product(-x[i], y[k], z[j]);
        }
    }

    fn add_product(&mut self, a: f32, b: f32, c: f32) {
        // 48 bits, hence exact.
        let ab = f64::from(a) * f64::from(b);
        let c = f64::from(c);
        let high = ab * c;
        self.add(ab.mul_add(c, -high));
        self.add(high);
    }

    /// Shewchuk's Grow-Expansion, without the zeros.
    fn add(&mut self, term: f64) {
        let mut carry = term;
        let mut kept = 0;
        for i in 0..self.count {
            let (sum, error) = two_sum(carry, self.parts[i]);
            carry = sum;
            if error != 0.0 {
                self.parts[kept] = error;
                kept += 1;
            }
        }
        if carry != 0.0 {
            self.parts[kept] = carry;
            kept += 1;
        }
        self.count = kept;
    }

    /// Rounded to an f64: the last part outweighs all before it, so the sign is right.
    fn value(&self) -> f64 {
        self.parts[..self.count].iter().sum()
    }
}

/// The rounded sum and what was rounded off (Knuth).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    let a_part = sum - b_part;
    (sum, (a - a_part) + (b - b_part))
}

#[cfg(test)]
mod tests {
    use super::*;

    const O: Vec3A = Vec3A::new(1e6, -3.0, 0.1);
    const P: Vec3A = Vec3A::new(2.5, 1e-7, -1e4);
    const Q: Vec3A = Vec3A::new(-1e-20, 7.0, 3e3);

    #[test]
    fn a_ray_through_a_vertex_is_on_the_edge() {
        // Differences that are exact in f32, so that the ray passes through the vertex.
        let (o, p) = (Vec3A::new(0.5, 0.25, -8.0), Vec3A::new(0.375, 1.0, 3.0));
        assert_eq!(side(o, p - o, p, Q), 0.0);
        assert_eq!(side(o, p - o, Q, p), 0.0);
        // Next to it the sign tells the side, though the value is 1e-9 of its terms.
        let beside = |x: u32| {
            let near = Vec3A::new(f32::from_bits(x), p.y, p.z);
            side(o, p - o, near, Vec3A::new(0.375, 1.0, 9e8))
        };
        let (above, below) = (beside(p.x.to_bits() + 1), beside(p.x.to_bits() - 1));
        assert!(above != 0.0 && above == -below, "{above} {below}");
    }

    /// Components that no f64 can hold in a sum: from (1e6, 0, 0) along (2⁻⁶⁰, 0, 1) the ray leaves the
    /// plane x = 1e6, in which an edge lies; along (0, 0, 1) it meets the edge.
    #[test]
    fn a_direction_far_below_the_origin_counts() {
        let (o, d) = (Vec3A::new(1e6, 0.0, 0.0), Vec3A::new(2f32.powi(-60), 0.0, 1.0));
        let (p, q) = (Vec3A::new(1e6, -1.0, 1.0), Vec3A::new(1e6, 1.0, 1.0));
        // det = d · ((p - o) × (q - o)) = (2⁻⁶⁰, 0, 1) · (-2, 0, 0).
        assert_eq!(side(o, d, p, q), -(2f64.powi(-59)));
        assert_eq!(side(o, Vec3A::Z, p, q), 0.0);
    }

    #[test]
    fn determinants_are_antisymmetric_and_shift() {
        let d = Vec3A::new(0.6, -1e-9, 0.8);
        assert_eq!(side(O, d, P, Q), -side(O, d, Q, P));
        assert_eq!(volume(O, P, Q, d), -volume(O, Q, P, d));
        assert_eq!(volume(O, P, Q, d), volume(O, Q, d, P));
        // A triangle seen from one of its points has no volume.
        assert_eq!(volume(P, P, Q, d), 0.0);
        assert_eq!(volume(Vec3A::ZERO, Vec3A::X, Vec3A::Y, Vec3A::Z), 1.0);
    }

    /// The largest and smallest coordinates there are: nothing overflows or vanishes.
    #[test]
    fn the_range_of_f32_is_enough() {
        for s in [1.8e18, 1e-30, f32::from_bits(1)] {
            let cube = f64::from(s).powi(3);
            let v = volume(Vec3A::ZERO, Vec3A::X * s, Vec3A::Y * s, Vec3A::Z * s);
            assert_eq!(v, cube);
            let mut sum = Expansion::default();
            sum.add_determinant(Vec3A::X * s, Vec3A::Y * s, Vec3A::Z * s);
            assert_eq!(sum.value(), cube);
        }
    }

    /// The exact sum against the plain one where both are good, and against i128 where only it is.
    #[test]
    fn exact_sums_are_exact() {
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as i32 - (1 << 23)
        };
        for _ in 0..1000 {
            let [x, y, z]: [[i32; 3]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| next()));
            let [xf, yf, zf] = [x, y, z].map(|v| Vec3A::from(v.map(|c| c as f32)));
            let mut sum = Expansion::default();
            sum.add_determinant(xf, yf, zf);
            let [x, y, z] = [x, y, z].map(|v| v.map(i128::from));
            let expected = x[0] * (y[1] * z[2] - y[2] * z[1])
                + x[1] * (y[2] * z[0] - y[0] * z[2])
                + x[2] * (y[0] * z[1] - y[1] * z[0]);
            assert_eq!(sum.value(), expected as f64);
            // Minus the rounded value, a second expansion holds what was rounded off.
            sum.add(-(expected as f64));
            assert_eq!(sum.value(), (expected - (expected as f64) as i128) as f64);
        }
    }
}
