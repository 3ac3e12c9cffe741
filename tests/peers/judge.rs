//! Whether two sets of renders show the same picture.
//!
//! The renders of each side are independent, so Welch's t-test tells whether the sides agree on the mean
//! of some pixels (Jung, Hanika and Dachsbacher, "Detecting Bias in Monte Carlo Renderers using Welch's
//! t-test", 2020). It is asked on three scales: single pixels show what is out of place, the whole
//! picture what is a little too bright, and tiles what lies between.

use std::cmp::Ordering;
use std::fmt::{self, Display, Formatter};

use crate::mitsuba::Renders;
use crate::support::stats::{Moments, significance_each, welch};

/// Side of a tile in pixels.
const TILE: usize = 8;

/// The share of pixels, times channels, that must pass in Mitsuba's own tests of its renders
/// (`src/render/tests/test_renders.py`), where each is tested with a significance of 0.01 divided
/// among the pixels.
const SHARE_OF_PIXELS: f64 = 0.9975;

/// The variance of a sample is taken to be so large at least, as in those tests: where none of a few
/// hundred samples found what one in a thousand finds, such as the tail of a filter, the renders seem
/// to have no variance at all. It hides 0.1 % of the brightness 1 in a pixel, less in a mean.
const LEAST_VARIANCE: f64 = 1e-4;

/// What both sides say of the mean over a rectangle of pixels.
struct Comparison<'a> {
    channel: &'a str,
    x: usize,
    y: usize,
    ours: Moments,
    theirs: Moments,
    p_value: f64,
}

impl Display for Comparison<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { channel, x, y, ours, theirs, p_value } = self;
        let [(our_mean, our_error), (their_mean, their_error)] =
            [ours, theirs].map(|m| (m.mean(), m.standard_error()));
        write!(
            f,
            "{channel} at ({x}, {y}): ours {our_mean:.6} ± {our_error:.1e}, theirs {their_mean:.6} ± \
             {their_error:.1e}, p = {p_value:.1e}"
        )
    }
}

/// By Mitsuba's rule for pixels.
///
/// # Errors
/// The share of pixels that pass and the worst pixels, if those are too few.
pub(crate) fn pixels(ours: &Renders, theirs: &Renders) -> Result<(), String> {
    let comparisons = compare(ours, theirs, (1, 1))?;
    let level = significance_each(ours.width * ours.height);
    let passed = comparisons.iter().filter(|c| c.p_value > level).count();
    let share = passed as f64 / comparisons.len() as f64;
    if share >= SHARE_OF_PIXELS {
        return Ok(());
    }
    let worst = worst(comparisons);
    Err(format!("only {:.2} % of the pixels pass at {level:.1e}{worst}", 100.0 * share))
}

/// By the means of tiles and of the whole picture, as one of `scenes` that have the significance
/// together.
///
/// # Errors
/// The worst tiles, if one does not pass.
pub(crate) fn means(ours: &Renders, theirs: &Renders, scenes: usize) -> Result<(), String> {
    let mut comparisons = compare(ours, theirs, (TILE, TILE))?;
    comparisons.extend(compare(ours, theirs, (ours.width, ours.height))?);
    let level = significance_each(comparisons.len() * scenes);
    let total = comparisons.len();
    comparisons.retain(|c| c.p_value.partial_cmp(&level).is_none_or(Ordering::is_lt));
    if comparisons.is_empty() {
        return Ok(());
    }
    let (failed, worst) = (comparisons.len(), worst(comparisons));
    Err(format!("{failed} of {total} means do not pass at {level:.1e}{worst}"))
}

/// By both.
///
/// # Errors
/// What [`pixels`] and [`means`] say.
pub(crate) fn judge(ours: &Renders, theirs: &Renders, scenes: usize) -> Result<(), String> {
    pixels(ours, theirs)?;
    means(ours, theirs, scenes)
}

/// All rectangles of these sides that cover the picture, in each channel that we have.
fn compare<'a>(
    ours: &'a Renders,
    theirs: &Renders,
    (width, height): (usize, usize),
) -> Result<Vec<Comparison<'a>>, String> {
    let [our_size, their_size] = [ours, theirs].map(|r| (r.width, r.height));
    if our_size != their_size {
        return Err(format!("ours has {our_size:?} pixels, theirs {their_size:?}"));
    }
    let least_variance =
        LEAST_VARIANCE / (f64::from(ours.samples_per_pixel) * (width * height) as f64);
    let mut comparisons = Vec::new();
    for (channel, our_pictures) in &ours.channels {
        let Some(their_pictures) = theirs.channels.get(channel) else {
            let names: Vec<_> = theirs.channels.keys().collect();
            return Err(format!("theirs has no channel {channel} but {names:?}"));
        };
        for y in (0..ours.height).step_by(height) {
            for x in (0..ours.width).step_by(width) {
                let mean = |picture: &Vec<f32>| {
                    let rows = picture.chunks_exact(ours.width).skip(y).take(height);
                    let values = rows.flat_map(|row| row.iter().skip(x).take(width));
                    Moments::of(values.map(|v| f64::from(*v))).mean()
                };
                let [ours, theirs] =
                    [our_pictures, their_pictures].map(|p| Moments::of(p.iter().map(mean)));
                let p_value = welch(&ours, &theirs, least_variance);
                comparisons.push(Comparison { channel, x, y, ours, theirs, p_value });
            }
        }
    }
    Ok(comparisons)
}

/// A few lines.
fn worst(mut comparisons: Vec<Comparison<'_>>) -> String {
    comparisons.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
    comparisons.iter().take(4).map(|c| format!("\n    {c}")).collect()
}
