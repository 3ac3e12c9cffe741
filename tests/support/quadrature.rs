//! Integrals over rectangles and over the sphere of directions, in f64.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3A};

/// ∫∫ `f(x, y)` over a rectangle by the five-point rule of Gauss and Legendre in each variable:
/// exact for polynomials up to degree 9.
pub(crate) fn integrate(x: [f64; 2], y: [f64; 2], mut f: impl FnMut(f64, f64) -> f64) -> f64 {
    let mut sum = 0.0;
    for (a, weight_x) in gauss_legendre(x) {
        for (b, weight_y) in gauss_legendre(y) {
            sum += weight_x * weight_y * f(a, b);
        }
    }
    sum
}

/// `whole`, which the rule says for a rectangle, or better what it says for its parts, halved up to `depth`
/// times.
fn adaptive(x: [f64; 2], y: [f64; 2], f: &impl Fn(f64, f64) -> f64, whole: f64, depth: u32) -> f64 {
    // Half a count in a million samples.
    const TOLERANCE: f64 = 5e-7;
    let halves = |[a, b]: [f64; 2]| [[a, 0.5 * (a + b)], [0.5 * (a + b), b]];
    let parts = halves(x).into_iter().flat_map(|x| halves(y).map(|y| (x, y)));
    let parts: Vec<_> = parts.map(|(x, y)| (x, y, integrate(x, y, f))).collect();
    let sum: f64 = parts.iter().map(|p| p.2).sum();
    if depth == 0 || (sum - whole).abs() <= TOLERANCE {
        return sum;
    }
    parts.into_iter().map(|(x, y, part)| adaptive(x, y, f, part, depth - 1)).sum()
}

/// Nodes and weights on an interval (Abramowitz and Stegun, 25.4.30).
fn gauss_legendre([low, high]: [f64; 2]) -> [(f64, f64); 5] {
    let (inner, outer) = (
        (5.0 - 2.0 * (10.0f64 / 7.0).sqrt()).sqrt() / 3.0,
        (5.0 + 2.0 * (10.0f64 / 7.0).sqrt()).sqrt() / 3.0,
    );
    let (w_inner, w_outer) =
        ((322.0 + 13.0 * 70f64.sqrt()) / 900.0, (322.0 - 13.0 * 70f64.sqrt()) / 900.0);
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    [(-outer, w_outer), (-inner, w_inner), (0.0, 128.0 / 225.0), (inner, w_inner), (outer, w_outer)]
        .map(|(node, weight)| (middle + half * node, half * weight))
}

/// The sphere of directions, cut into cells of equal solid angle: rows in cosθ, columns in φ. With an
/// even number of rows no cell crosses the horizon.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SphereGrid {
    pub(crate) rows: usize,
    pub(crate) columns: usize,
}

impl SphereGrid {
    pub(crate) fn cells(&self) -> usize {
        self.rows * self.columns
    }

    /// The cell that holds a unit vector.
    pub(crate) fn cell(&self, w: Vec3A) -> usize {
        let fraction = |x: f64, n: usize| ((x * n as f64) as usize).min(n - 1);
        let turn = f64::from(w.y).atan2(f64::from(w.x)) / TAU;
        let turn = if turn < 0.0 { turn + 1.0 } else { turn };
        // The horizon itself belongs above, where the materials put it.
        fraction(0.5 + 0.5 * f64::from(w.z), self.rows) * self.columns
            + fraction(turn, self.columns)
    }

    /// The integral of a density per solid angle over each cell; `parts` is the number of parts that
    /// each is cut into in either direction, so that nothing is overlooked, before those parts are halved
    /// where the rule says something else for both halves.
    pub(crate) fn integrals(&self, parts: usize, density: impl Fn(Vec3A) -> f64) -> Vec<f64> {
        let edges = |i: usize, n: usize| [i as f64 / n as f64, (i + 1) as f64 / n as f64];
        // In the angle from the pole, because lobes around the pole are narrow in its cosine.
        let by_angles = |theta: f64, phi: f64| theta.sin() * density(direction(theta.cos(), phi));
        let mut integrals = Vec::with_capacity(self.cells());
        for row in 0..self.rows {
            for column in 0..self.columns {
                let [high, low] = edges(row, self.rows).map(|e| (2.0 * e - 1.0).acos());
                let phi = edges(column, self.columns).map(|e| TAU * e);
                let cut = |[a, b]: [f64; 2], i| edges(i, parts).map(|e| a + e * (b - a));
                let cells = (0..parts).flat_map(|i| (0..parts).map(move |j| (i, j)));
                let sum = cells.map(|(i, j)| {
                    let (theta, phi) = (cut([low, high], i), cut(phi, j));
                    adaptive(theta, phi, &by_angles, integrate(theta, phi, by_angles), 6)
                });
                integrals.push(sum.sum());
            }
        }
        integrals
    }
}

/// The unit vector of given cosine and azimuth.
pub(crate) fn direction(z: f64, phi: f64) -> Vec3A {
    let r = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(r * phi.cos(), r * phi.sin(), z).as_vec3a()
}
