//! Tests of hypotheses. Each returns an error with the figures, to be shown where it fails.

use std::fmt::Write;

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};
use telamon::measure::statistics::p_value;

/// Probability that a test function rejects code that is right.
pub(crate) const SIGNIFICANCE: f64 = 0.01;

/// Cells with fewer expected counts are pooled: below, the statistic does not follow its
/// distribution (Cochran 1954).
const LEAST_EXPECTED: f64 = 5.0;

/// The significance of one of `checks` independent checks that together have [`SIGNIFICANCE`]
/// (Šidák 1967).
pub(crate) fn significance_each(checks: usize) -> f64 {
    -((-SIGNIFICANCE).ln_1p() / checks as f64).exp_m1()
}

/// Pearson's chi-squared test of counts against expected counts, as one of `checks` checks.
///
/// # Errors
/// The table, if the counts do not come from the expected distribution, or if one lies in a cell
/// that can have none.
pub(crate) fn chi_squared(observed: &[u64], expected: &[f64], checks: usize) -> Result<(), String> {
    assert_eq!(observed.len(), expected.len(), "one expected count for each cell");
    let mut order: Vec<usize> = (0..expected.len()).collect();
    order.sort_by(|&a, &b| expected[a].total_cmp(&expected[b]));
    let (mut statistic, mut cells) = (0.0, 0);
    let mut pool = (0.0, 0.0);
    for cell in order {
        let (o, e) = (observed[cell], expected[cell]);
        if e <= 0.0 && o > 0 {
            let table = table(observed, expected);
            return Err(format!("cell {cell} has {o} counts where none can be\n{table}"));
        }
        // From the smallest up, so that no pool is left over for want of another cell.
        pool = (pool.0 + o as f64, pool.1 + e);
        if pool.1 >= LEAST_EXPECTED {
            statistic += (pool.0 - pool.1).powi(2) / pool.1;
            cells += 1;
            pool = (0.0, 0.0);
        }
    }
    if cells < 2 {
        return Err(format!("{cells} cells with enough counts: nothing to test"));
    }
    let distribution =
        ChiSquared::new(f64::from(cells - 1)).expect("at least one degree of freedom");
    let p_value = 1.0 - distribution.cdf(statistic);
    let level = significance_each(checks);
    // NaN is rejected too.
    if p_value >= level {
        return Ok(());
    }
    let table = table(observed, expected);
    Err(format!(
        "chi-squared {statistic:.2} over {cells} cells: p = {p_value:.3e} < {level:.3e}\n{table}"
    ))
}

fn table(observed: &[u64], expected: &[f64]) -> String {
    let mut text = String::from("cell: observed / expected\n");
    for (cell, (o, e)) in observed.iter().zip(expected).enumerate() {
        writeln!(text, "{cell}: {o} / {e:.2}").expect("a string takes all that is written");
    }
    text
}

/// Mean and variance of a stream of numbers (Welford 1962).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moments {
    count: u64,
    mean: f64,
    /// Sum of squared deviations from the mean.
    squares: f64,
}

impl Moments {
    pub(crate) fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut moments = Self::default();
        for value in values {
            moments.count += 1;
            let deviation = value - moments.mean;
            moments.mean += deviation / moments.count as f64;
            moments.squares += deviation * (value - moments.mean);
        }
        moments
    }

    pub(crate) fn mean(&self) -> f64 {
        self.mean
    }

    /// Standard error of the mean.
    pub(crate) fn standard_error(&self) -> f64 {
        (self.squares / (self.count as f64 - 1.0) / self.count as f64).sqrt()
    }

    /// Student's two-sided t-test of the mean, as one of `checks` checks. A deviation of 1e-6 of the
    /// expected value is forgiven: the f32 numbers in the mean carry up to 16 roundings of 2⁻²⁴.
    ///
    /// # Errors
    /// The figures, if the mean is not the expected one.
    pub(crate) fn has_mean(&self, expected: f64, checks: usize) -> Result<(), String> {
        let deviation = ((self.mean - expected).abs() - 1e-6 * expected.abs()).max(0.0);
        let error = self.standard_error();
        let t = if deviation == 0.0 { 0.0 } else { deviation / error };
        let distribution =
            StudentsT::new(0.0, 1.0, self.count as f64 - 1.0).expect("at least two numbers");
        let p_value = if t.is_infinite() { 0.0 } else { 2.0 * (1.0 - distribution.cdf(t)) };
        let level = significance_each(checks);
        if p_value >= level {
            return Ok(());
        }
        let Self { count, mean, .. } = self;
        Err(format!(
            "mean {mean:.9e} ± {error:.2e} of {count}, expected {expected:.9e}: \
             p = {p_value:.3e} < {level:.3e}"
        ))
    }
}

/// The p-value of Welch's two-sided t-test that two streams have the same mean (Welch 1947), if the
/// variance of the numbers in each is `least_variance` at least. A difference of 1e-5 of the mean is
/// forgiven: the other side may have summed up to 128 numbers in f32, each time with a rounding of 2⁻²⁴.
pub(crate) fn welch(a: &Moments, b: &Moments, least_variance: f64) -> f64 {
    let forgiven = 1e-5 * a.mean.abs().max(b.mean.abs());
    let difference = (a.mean - b.mean).abs() - forgiven;
    if difference <= 0.0 {
        return 1.0;
    }
    let [a, b] = [a, b].map(|m| {
        let (count, freedom) = (m.count as f64, m.count as f64 - 1.0);
        ((m.squares / freedom).max(least_variance) / count, freedom)
    });
    let variance = a.0 + b.0;
    // The degrees of freedom after Welch and Satterthwaite.
    let freedom = variance.powi(2) / (a.0.powi(2) / a.1 + b.0.powi(2) / b.1);
    p_value(difference, variance.sqrt(), freedom)
}
