//! Whether noise explains the differences between two pictures.

use glam::DVec3;

use super::image::Image;
use super::statistics::{p_value, significance_each};

/// How many pixels differ by more than their noise explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZTest {
    /// Numbers (pixels times channels) that were compared.
    pub compared: usize,
    /// Those whose difference has a p-value below [`ZTest::level`].
    pub beyond: usize,
    /// Numbers, not among those compared, that are finite in one picture and not in the other.
    pub one_sided: usize,
    /// Numbers, not among those compared, of which nothing can be said: they are finite in neither picture, or
    /// a variance is not, as that of a single sample.
    pub unknown: usize,
    /// Mean of the squared z: 1 if noise explains the differences and is as large as it says.
    pub mean_square: f64,
    /// Significance of one number's test, so that all together have [`ZTest::SIGNIFICANCE`].
    pub level: f64,
}

impl ZTest {
    /// Probability that a number is beyond the level by chance, if noise is normal.
    pub const SIGNIFICANCE: f64 = 0.01;
    /// The fraction of numbers that may be beyond it all the same: noise of few samples has heavier tails
    /// than the normal distribution (the allowance of Mitsuba's own tests).
    pub const ALLOWANCE: f64 = 0.0025;

    /// z = (A − B)/√(v_A + v_B) of each pixel and channel, against the normal distribution, at a level after
    /// Šidák. `None` unless a variance is known of one picture at least; one without counts as exact.
    ///
    /// # Panics
    /// If the pictures differ in size.
    #[must_use]
    pub fn of(a: &Image, b: &Image) -> Option<Self> {
        assert_eq!(a.crop, b.crop, "pictures of the same pixels");
        if a.variance.is_none() && b.variance.is_none() {
            return None;
        }
        let variance = |image: &Image, i: usize| {
            image.variance.as_ref().map_or(DVec3::ZERO, |v| v[i].as_dvec3())
        };
        let mut scores = Vec::with_capacity(3 * a.pixels.len());
        let (mut one_sided, mut unknown) = (0, 0);
        for i in 0..a.pixels.len() {
            let difference = a.pixels[i].as_dvec3() - b.pixels[i].as_dvec3();
            let variance = variance(a, i) + variance(b, i);
            for c in 0..3 {
                let (d, v) = (difference[c], variance[c]);
                if a.pixels[i][c].is_finite() != b.pixels[i][c].is_finite() {
                    one_sided += 1;
                } else if d.is_finite() && v.is_finite() {
                    scores.push((d, v.sqrt()));
                } else {
                    unknown += 1;
                }
            }
        }
        let compared = scores.len();
        let level = significance_each(Self::SIGNIFICANCE, compared);
        let far = |&&(d, e): &&(f64, f64)| p_value(d, e, f64::INFINITY) < level;
        let beyond = scores.iter().filter(far).count();
        let square = |&(d, e): &(f64, f64)| (d / e) * (d / e);
        let noisy = || scores.iter().filter(|(_, e)| *e > 0.0);
        let mean_square = noisy().map(square).sum::<f64>() / noisy().count() as f64;
        Some(Self { compared, beyond, one_sided, unknown, mean_square, level })
    }

    /// Whether there are differences that noise does not explain.
    #[must_use]
    pub fn fails(&self) -> bool {
        self.one_sided > 0 || self.beyond as f64 > Self::ALLOWANCE * self.compared as f64
    }

    /// Whether noise explains the differences of all numbers.
    #[must_use]
    pub fn passes(&self) -> bool {
        !self.fails() && self.unknown == 0
    }
}
