//! The statistics that measurements are judged by.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use crate::sampler::{Independent, Sampler};

/// Mean, spread and count of some numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// How many there are.
    pub count: usize,
    /// Their mean; NaN if there are none.
    pub mean: f64,
    /// Their sample standard deviation; NaN for fewer than two.
    pub deviation: f64,
}

impl Moments {
    /// Moments of `values`, in two passes.
    #[must_use]
    pub fn of(values: &[f64]) -> Self {
        let count = values.len();
        let mean = values.iter().sum::<f64>() / count as f64;
        let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        let deviation = if count < 2 { f64::NAN } else { (squares / (count as f64 - 1.0)).sqrt() };
        Self { count, mean, deviation }
    }

    /// Standard error of the mean.
    #[must_use]
    pub fn standard_error(&self) -> f64 {
        self.deviation / (self.count as f64).sqrt()
    }
}

/// The value below which a fraction `q` in `[0, 1]` of `sorted` lies: linear between neighbours (type 7
/// of Hyndman and Fan 1996); NaN if there is none.
#[must_use]
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let place = q.clamp(0.0, 1.0) * last as f64;
    let (below, above) = (sorted[place as usize], sorted[(place as usize + 1).min(last)]);
    below + place.fract() * (above - below)
}

/// Sorted copy. NaN, which compares with nothing, comes last.
#[must_use]
pub fn sorted(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_unstable_by(f64::total_cmp);
    values
}

/// The median; NaN if there is none.
#[must_use]
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    quantile(&sorted(values), 0.5)
}

/// The significance of one of `tests` tests that together have `significance` (Šidák 1967).
#[must_use]
pub fn significance_each(significance: f64, tests: usize) -> f64 {
    -((-significance).ln_1p() / tests.max(1) as f64).exp_m1()
}

/// Two-sided p-value of Student's t with `freedom` degrees of freedom, which need not be whole; that of
/// the normal distribution where `freedom` is infinite. 0/0 counts as no deviation at all.
#[must_use]
pub fn p_value(deviation: f64, standard_error: f64, freedom: f64) -> f64 {
    if deviation == 0.0 {
        return 1.0;
    }
    let t = -(deviation / standard_error).abs();
    if t == f64::NEG_INFINITY {
        return 0.0;
    }
    // From the lower tail, where small probabilities keep their digits.
    let below = if freedom.is_infinite() {
        Normal::standard().cdf(t)
    } else {
        StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |d| d.cdf(t))
    };
    2.0 * below
}

/// The value below which Student's t with `freedom` degrees of freedom stays with the probability `q`; infinite
/// without any freedom.
#[must_use]
pub fn student_quantile(q: f64, freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |d| d.inverse_cdf(q))
}

/// p-value of Welch's test that two sets of numbers have one mean (Welch 1947, with the degrees of
/// freedom of Satterthwaite 1946); NaN if either has fewer than two.
#[must_use]
pub fn welch(a: &Moments, b: &Moments) -> f64 {
    let [va, vb] = [a, b].map(|m| m.standard_error().powi(2));
    let freedom =
        (va + vb).powi(2) / (va * va / (a.count as f64 - 1.0) + vb * vb / (b.count as f64 - 1.0));
    if va + vb == 0.0 && a.count > 1 && b.count > 1 {
        return if a.mean == b.mean { 1.0 } else { 0.0 };
    }
    p_value(a.mean - b.mean, (va + vb).sqrt(), freedom)
}

/// Resamplings of a bootstrap: the ends of a 95 % interval then err by 0.5 % of probability.
const RESAMPLINGS: u32 = 2000;

/// The two ends of the central 95 % of `statistic` over resamplings with replacement of `0..count`
/// (percentile bootstrap, Efron 1979). It depends on `seed` only.
#[must_use]
pub fn bootstrap(count: usize, seed: u64, statistic: impl Fn(&[usize]) -> f64) -> (f64, f64) {
    let numbers = Independent::new(seed);
    let resampling = |r: u32| {
        let path = numbers.path(0, r);
        let draw = |i: usize| {
            ((numbers.get_1d(path, i as u32) * count as f32) as usize).min(count.saturating_sub(1))
        };
        let indices: Vec<usize> = (0..count).map(draw).collect();
        statistic(&indices)
    };
    let values = sorted((0..RESAMPLINGS).map(resampling));
    (quantile(&values, 0.025), quantile(&values, 0.975))
}

/// A straight line through points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Change of y for a step of 1 in x.
    pub slope: f64,
    /// Its standard error.
    pub slope_error: f64,
    /// Degrees of freedom of that error.
    pub freedom: f64,
}

/// The line through points `(x, y, standard error of y)` by least squares; errors have `freedom` degrees of
/// freedom each. `None` for fewer than two different x, or without any error.
///
/// All points weigh alike: errors that are estimated from few numbers would give most weight to the points that
/// are by chance too certain, and where a rare large number decides these are the points that lack it.
#[must_use]
pub fn fit_line(points: &[(f64, f64, f64)], freedom: f64) -> Option<Line> {
    let count = points.len() as f64;
    let x_mean = points.iter().map(|p| p.0).sum::<f64>() / count;
    let xx: f64 = points.iter().map(|p| (p.0 - x_mean).powi(2)).sum();
    let slope = points.iter().map(|p| (p.0 - x_mean) / xx * p.1).sum();
    let parts = || points.iter().map(|p| ((p.0 - x_mean) / xx * p.2).powi(2));
    let variance: f64 = parts().sum();
    // Satterthwaite 1946.
    let freedom = freedom * variance * variance / parts().map(|v| v * v).sum::<f64>();
    let line = Line { slope, slope_error: variance.sqrt(), freedom };
    (slope.is_finite() && line.freedom.is_finite()).then_some(line)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_and_quantiles_by_hand() {
        let moments = Moments::of(&[1.0, 2.0, 3.0, 6.0]);
        // Squared deviations 4, 1, 0 and 9 over 3 degrees of freedom.
        assert_eq!((moments.mean, moments.deviation), (3.0, (14.0_f64 / 3.0).sqrt()));
        assert_eq!(moments.standard_error(), (14.0_f64 / 3.0).sqrt() / 2.0);
        assert!(Moments::of(&[1.0]).deviation.is_nan() && Moments::of(&[]).mean.is_nan());
        assert_eq!(median([3.0, 1.0, 2.0, 10.0]), 2.5);
        assert_eq!(quantile(&[1.0, 2.0, 4.0], 1.0), 4.0);
        assert_eq!(quantile(&[1.0, 2.0, 4.0], 0.75), 3.0);
        assert!(quantile(&[], 0.5).is_nan());
    }

    /// Tables of Student's t and of the normal distribution: 2.364624 for 7 degrees of freedom and
    /// 1.959964 for infinitely many are the ends of the central 95 %.
    #[test]
    fn p_values_are_those_of_the_tables() {
        assert!((p_value(2.364_624, 1.0, 7.0) - 0.05).abs() < 1e-6);
        assert!((p_value(-1.959_964, 1.0, f64::INFINITY) - 0.05).abs() < 1e-6);
        assert!((student_quantile(0.975, 7.0) - 2.364_624).abs() < 1e-6);
        assert!((student_quantile(0.975, 1.0) - 12.706_205).abs() < 1e-5);
        assert_eq!(student_quantile(0.975, 0.0), f64::INFINITY);
        assert_eq!(p_value(0.0, 0.0, 7.0), 1.0);
        assert_eq!(p_value(1.0, 0.0, 7.0), 0.0);
        assert!((significance_each(0.05, 2) - (1.0 - 0.95_f64.sqrt())).abs() < 1e-12);
        let (a, b) = (Moments::of(&[1.0, 2.0, 3.0]), Moments::of(&[2.0, 4.0, 6.0, 8.0]));
        // t = −3/√(1/3 + 5/3) and Satterthwaite's 4/(1/18 + 25/27) = 4.0755 degrees of freedom.
        assert!((welch(&a, &b) - p_value(3.0, 2.0_f64.sqrt(), 4.075_471_7)).abs() < 1e-7);
        assert_eq!(welch(&Moments::of(&[1.0, 1.0]), &Moments::of(&[1.0, 1.0])), 1.0);
        assert!(welch(&a, &Moments::of(&[1.0])).is_nan());
    }

    /// A line is found exactly, and its error is that of the textbook: σ/√Σ(x − x̄)². The middle of three points
    /// does not matter, so the freedom is that of the other two.
    #[test]
    fn lines_are_fitted() {
        let points = [(0.0, 1.0, 0.1), (1.0, 0.5, 0.1), (2.0, 0.0, 0.1)];
        let line = fit_line(&points, 7.0).expect("three points");
        assert!((line.slope + 0.5).abs() < 1e-12);
        assert!((line.slope_error - 0.1 / 2.0_f64.sqrt()).abs() < 1e-12);
        assert!((line.freedom - 14.0).abs() < 1e-9);
        assert_eq!(fit_line(&points[..1], 7.0), None);
        assert_eq!(fit_line(&[(0.0, 1.0, 0.0), (1.0, 1.0, 0.0)], 7.0), None);
    }

    /// For the mean of 40 numbers the interval is close to the mean ± 1.96 standard errors: of 0 … 39
    /// that is 19.5 ± 1.96·11.54/√40 = 3.58 (the bootstrap divides by n, not n − 1); 2000 resamplings
    /// leave ±0.15 of it.
    #[test]
    fn the_bootstrap_finds_the_interval_of_a_mean() {
        let mean = |indices: &[usize]| indices.iter().sum::<usize>() as f64 / indices.len() as f64;
        let (low, high) = bootstrap(40, 1, mean);
        assert!((low - 15.92).abs() < 0.3 && (high - 23.08).abs() < 0.3, "{low} {high}");
        assert_eq!(bootstrap(40, 1, mean), (low, high));
    }
}
