//! What ends a render early, and which samples come first.

use std::time::Duration;

/// What ends a render before it has all samples that its sampler is told to take, and where they
/// go and come first. Of this, scene files can say `error`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// Time to render in. The first sample of each pixel is always taken, and every pass finished.
    pub time: Option<Duration>,
    /// relMSE to reach, above 0: the mean over pixels and channels of (I − R)²/(R² + 0.01) with the value
    /// I and its expectation R.
    pub error: Option<f64>,
    /// Noise level to reach, above 0: what the root of the same quotient, averaged over the channels, is at
    /// most in 95 % of the pixels.
    pub noise_level: Option<f64>,
    /// Whether noisy parts of the picture get more samples than others, at the same number on average.
    pub adaptive: bool,
    /// Whether one pixel in each square of 8x8 gets its first sample before all the others: who watches a large
    /// film sees the whole of it soon. The picture is the same, and the first pass takes a little longer.
    pub coarse_first: bool,
}

impl Effort {
    /// Whether the samples have to be kept in two independent halves.
    #[must_use]
    pub fn needs_halves(&self) -> bool {
        self.needs_error() || self.adaptive
    }

    /// Whether an estimate of the error is needed.
    #[must_use]
    pub fn needs_error(&self) -> bool {
        self.error.is_some() || self.noise_level.is_some()
    }
}
