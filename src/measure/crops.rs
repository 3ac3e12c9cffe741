//! The same part of the picture in several settings, for the eye: at equal time and at equal error.

use std::sync::atomic::AtomicBool;

use super::bench::{Bench, Run};
use super::image::Image;
use super::knobs::Setting;
use super::metrics::Metrics;
use super::plan::Candidate;
use super::statistics::{quantile, sorted};
use super::summary::{Findings, Summary};
use crate::film::Crop;
use crate::film::png::png_bytes;
use crate::math::Rgb;

/// Side of a crop in pixels.
const SIDE: u32 = 96;
/// Settings that are shown at most.
const MOST: usize = 8;
/// Shots that take longer than this are not taken.
const LONGEST_SECONDS: f64 = 20.0;
const SEED: u64 = 0x5eed;

/// Pictures side by side.
#[derive(Clone, Debug, PartialEq)]
pub struct Shots {
    /// The reference, as PNG.
    pub reference: Vec<u8>,
    /// The time that all of [`Shots::equal_time`] take for a whole picture.
    pub seconds: f64,
    /// One of each series.
    pub equal_time: Vec<Shot>,
    /// The relMSE of all of [`Shots::equal_error`] over the whole picture.
    pub target: f64,
    /// One of each series that reaches it.
    pub equal_error: Vec<Shot>,
    /// Series that would reach it, but not soon enough to be shown, with the seconds of a whole picture.
    pub too_slow: Vec<(String, f64)>,
}

/// One of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    /// Its series.
    pub label: String,
    /// Samples per pixel.
    pub samples_per_pixel: u32,
    /// Time for a whole picture.
    pub seconds: f64,
    /// relMSE of what is shown.
    pub rel_mse: f64,
    /// As PNG.
    pub png: Vec<u8>,
}

/// Renders them: where the reference varies most, with as many samples as the measured times and errors ask
/// for. `None` if it was cancelled or if nothing was measured.
pub fn take(
    bench: &mut Bench<'_>,
    candidates: &[Candidate],
    (findings, runs): (&Findings, &[Run]),
    reference: &Image,
    target: f64,
    cancel: &AtomicBool,
) -> Option<Shots> {
    let whole = bench.description().film.crop;
    let crop = window(reference);
    bench.description_mut().film.crop = crop;
    let shots =
        Camera { bench, candidates, reference, whole, crop, cancel }.shots(findings, runs, target);
    bench.description_mut().film.crop = whole;
    shots
}

struct Camera<'a, 'b> {
    bench: &'a mut Bench<'b>,
    candidates: &'a [Candidate],
    reference: &'a Image,
    whole: Crop,
    crop: Crop,
    cancel: &'a AtomicBool,
}

impl Camera<'_, '_> {
    fn shots(&mut self, findings: &Findings, runs: &[Run], target: f64) -> Option<Shots> {
        let cut = Image { crop: self.crop, pixels: Vec::new(), variance: None, ..*self.reference };
        let reference = self.reference.cut_to(&cut).ok()?;
        let seconds = findings.base()?.seconds.value;
        let reaches = findings.reaches(runs, target);
        let (mut equal_time, mut equal_error, mut too_slow) = (Vec::new(), Vec::new(), Vec::new());
        for (summary, reach) in reaches.iter().take(MOST) {
            let each = f64::from(summary.samples_per_pixel) / summary.seconds.value;
            if self.is_short(seconds) {
                equal_time.push(self.shot(summary, seconds * each, &reference)?);
            }
            match reach.measured() {
                Some(reach) if self.is_short(reach.seconds.value) => {
                    let samples = f64::from(reach.samples_per_pixel);
                    equal_error.push(self.shot(summary, samples, &reference)?);
                }
                Some(reach) => too_slow.push((summary.series.clone(), reach.seconds.value)),
                None => {}
            }
        }
        let reference = png_bytes(&reference.to_picture(1), 0.0)?;
        Some(Shots { reference, seconds, equal_time, target, equal_error, too_slow })
    }

    /// Whether the part of a picture of so many seconds that is shown takes little time.
    fn is_short(&self, seconds: f64) -> bool {
        let area = |c: Crop| f64::from(c.width) * f64::from(c.height);
        seconds * area(self.crop) / area(self.whole) <= LONGEST_SECONDS
    }

    /// A shot; `None` if it was cancelled.
    fn shot(&mut self, summary: &Summary, samples: f64, reference: &Image) -> Option<Shot> {
        let samples_per_pixel = samples.round().clamp(1.0, f64::from(u32::MAX)) as u32;
        let each = summary.seconds.value / f64::from(summary.samples_per_pixel);
        let seconds = f64::from(samples_per_pixel) * each;
        let candidate = self.candidates.iter().find(|c| c.label() == summary.setting)?;
        let setting = Setting { samples_per_pixel, ..candidate.setting.clone() };
        let (image, ..) = self.bench.picture(&setting, SEED, &|_| (), self.cancel)?;
        let metrics = Metrics::of(&image, reference)?;
        let png = png_bytes(&image.to_picture(1), 0.0)?;
        let rel_mse = metrics.true_rel_mse();
        let label = summary.series.clone();
        Some(Shot { label, samples_per_pixel, seconds, rel_mse, png })
    }
}

/// The window in which the reference's relative variance, without its largest hundredth, is largest; the
/// middle where no variance is known.
fn window(reference: &Image) -> Crop {
    let crop = reference.crop;
    let (width, height) = (SIDE.min(crop.width), SIDE.min(crop.height));
    let Some(variance) = &reference.variance else {
        let (x, y) = (crop.x + (crop.width - width) / 2, crop.y + (crop.height - height) / 2);
        return Crop { x, y, width, height };
    };
    let relative = |(v, r): (&Rgb, &Rgb)| {
        let value = f64::from((*v / (*r * *r + 0.01)).element_sum());
        if value.is_finite() { value } else { 0.0 }
    };
    let scores: Vec<f64> = variance.iter().zip(&reference.pixels).map(relative).collect();
    let most = quantile(&sorted(scores.iter().copied()), 0.99);
    let score = |x: u32, y: u32| -> f64 {
        let row = |y: u32| {
            let start = (y * crop.width + x) as usize;
            scores[start..start + width as usize].iter().map(|s| s.min(most)).sum::<f64>()
        };
        (y..y + height).map(row).sum()
    };
    let starts = |all: u32, side: u32| (0..=all - side).step_by((side / 4).max(1) as usize);
    let all =
        starts(crop.height, height).flat_map(|y| starts(crop.width, width).map(move |x| (x, y)));
    let best = all.max_by(|a, b| score(a.0, a.1).total_cmp(&score(b.0, b.1)));
    let (x, y) = best.unwrap_or((0, 0));
    Crop { x: crop.x + x, y: crop.y + y, width, height }
}
