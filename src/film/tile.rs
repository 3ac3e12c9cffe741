//! Sums of samples over a rectangle of pixels.

use std::ops::{Add, Div, Range};

use glam::DVec3;

use super::error::REL_MSE_FLOOR;
use super::{Content, Crop};
use crate::math::Rgb;

/// A rectangle of pixels, with no more of their samples than was asked for.
///
/// Samples are summed in cells. A pixel has one, or two if its halves are kept apart; its value is then
/// the mean of both means, however many samples each has.
#[derive(Debug)]
pub struct Tile {
    area: Crop,
    halves: usize,
    picture: Vec<PictureSum>,
    /// Sums of squared deviations from the mean radiance, if asked for.
    squares: Vec<DVec3>,
    /// Components of the layers that are averaged, cell by cell.
    numbers: Vec<f64>,
    /// Layers that are not, pixel by pixel.
    indices: Vec<u32>,
    samples: Vec<u32>,
    /// What was recorded of each half's noise.
    noise: [Vec<f64>; 2],
    numbers_per_cell: usize,
    indices_per_pixel: usize,
}

/// Sums in f64: in f32, a million samples of 0.1 are 1 % off.
#[derive(Clone, Copy, Debug, Default)]
struct PictureSum {
    radiance: DVec3,
    alpha: f64,
}

impl Tile {
    /// An empty tile.
    pub(super) fn new(area: Crop, content: &Content) -> Self {
        let pixels = (area.width * area.height) as usize;
        let (numbers_per_cell, indices_per_pixel) = layer_counts(content);
        let halves = if content.halves { 2 } else { 1 };
        let cells = pixels * halves;
        let if_kept = |kept| if kept { cells } else { 0 };
        Self {
            area,
            halves,
            picture: vec![PictureSum::default(); if_kept(content.picture)],
            squares: vec![DVec3::ZERO; if_kept(content.picture && content.variance)],
            numbers: vec![0.0; cells * numbers_per_cell],
            indices: vec![0; pixels * indices_per_pixel],
            samples: vec![0; cells],
            noise: [Vec::new(), Vec::new()],
            numbers_per_cell,
            indices_per_pixel,
        }
    }

    /// Bytes that each pixel of a tile takes.
    pub(super) fn bytes_per_pixel(content: &Content) -> u64 {
        let (numbers, indices) = layer_counts(content);
        let if_kept = |kept, bytes| if kept { bytes } else { 0 };
        let cell = if_kept(content.picture, size_of::<PictureSum>())
            + if_kept(content.picture && content.variance, size_of::<DVec3>())
            + numbers * size_of::<f64>()
            + size_of::<u32>();
        let cells = if content.halves { 2 } else { 1 };
        (cells * cell + indices * size_of::<u32>()) as u64
    }

    /// The pixels that the tile covers.
    #[must_use]
    pub fn area(&self) -> Crop {
        self.area
    }

    /// Coordinates on the whole film of its pixels, in the order of their indices.
    pub fn pixels(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let Crop { x, y, width, height } = self.area;
        (y..y + height).flat_map(move |y| (x..x + width).map(move |x| (x, y)))
    }

    /// The cell of one half of a pixel; of the only one, 0, if halves are not kept apart.
    #[must_use]
    pub fn cell(&self, pixel: usize, half: usize) -> usize {
        debug_assert!(half < self.halves, "half {half} of {}", self.halves);
        pixel * self.halves + half
    }

    /// Samples that a cell has.
    #[must_use]
    pub fn count(&self, cell: usize) -> u32 {
        self.samples[cell]
    }

    /// Samples that a pixel has.
    #[must_use]
    pub fn samples(&self, pixel: usize) -> u32 {
        self.cells(pixel).map(|cell| self.samples[cell]).sum()
    }

    /// Adds one sample of the picture to a cell.
    pub fn add_picture(&mut self, cell: usize, radiance: Rgb, alpha: f32) {
        let sum = &mut self.picture[cell];
        let radiance = radiance.as_dvec3();
        sum.radiance += radiance;
        sum.alpha += f64::from(alpha);
        if let Some(squares) = self.squares.get_mut(cell) {
            let before = f64::from(self.samples[cell]);
            if before > 0.0 {
                // Youngs and Cramer 1971: from the deviation of the new sample from the new mean.
                let deviation = radiance - sum.radiance / (before + 1.0);
                *squares += deviation * deviation * ((before + 1.0) / before);
            }
        }
    }

    /// The sums of a cell's averaged layers, and the values of its pixel's others.
    pub fn layers_mut(&mut self, cell: usize) -> (&mut [f64], &mut [u32]) {
        let (n, i) = (self.numbers_per_cell, self.indices_per_pixel);
        let pixel = cell / self.halves;
        (&mut self.numbers[cell * n..][..n], &mut self.indices[pixel * i..][..i])
    }

    /// Counts one more sample of a cell, after all of it was added.
    pub fn count_sample(&mut self, cell: usize) {
        self.samples[cell] += 1;
    }

    /// Mean radiance of a pixel; 0 where there is no sample.
    #[must_use]
    pub fn radiance(&self, pixel: usize) -> DVec3 {
        self.mean(pixel, |cell| self.picture[cell].radiance)
    }

    /// Mean alpha of a pixel likewise.
    #[must_use]
    pub fn alpha(&self, pixel: usize) -> f64 {
        self.mean(pixel, |cell| self.picture[cell].alpha)
    }

    /// Mean of a pixel's component number `component`, counted over all layers that are averaged.
    #[must_use]
    pub fn number(&self, pixel: usize, component: usize) -> f64 {
        self.mean(pixel, |cell| self.numbers[cell * self.numbers_per_cell + component])
    }

    /// A pixel's value of layer number `layer`, counted over those that are not averaged.
    #[must_use]
    pub fn index(&self, pixel: usize, layer: usize) -> u32 {
        self.indices[pixel * self.indices_per_pixel + layer]
    }

    /// The mean of the means of a pixel's cells. Those without samples do not count, and a pixel without
    /// any is black, not NaN.
    fn mean<T>(&self, pixel: usize, sum: impl Fn(usize) -> T) -> T
    where
        T: Default + Add<Output = T> + Div<f64, Output = T>,
    {
        let cells = || self.cells(pixel).filter(|&cell| self.samples[cell] > 0);
        let total = cells()
            .map(|cell| sum(cell) / f64::from(self.samples[cell]))
            .fold(T::default(), T::add);
        total / cells().count().max(1) as f64
    }

    /// The variance of the pixel's mean times its number of samples.
    pub(super) fn variance(&self, pixel: usize) -> DVec3 {
        let (mut count, mut mean, mut squares) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for cell in self.cells(pixel).filter(|&cell| self.samples[cell] > 0) {
            // Chan, Golub and LeVeque 1979: two sets as one.
            let more = f64::from(self.samples[cell]);
            let apart = self.picture[cell].radiance / more - mean;
            squares += self.squares[cell] + apart * apart * (count * more / (count + more));
            mean += apart * (more / (count + more));
            count += more;
        }
        if count < 2.0 {
            return DVec3::INFINITY;
        }
        squares / (count - 1.0) * self.spread_of_mean(pixel, count)
    }

    /// By what the variance of a pixel's mean exceeds that of one sample over `count`, their number, since
    /// cells weigh alike however many samples each has.
    fn spread_of_mean(&self, pixel: usize, count: f64) -> f64 {
        let counts = || self.cells(pixel).map(|cell| f64::from(self.samples[cell]));
        let used = counts().filter(|n| *n > 0.0).count() as f64;
        let of_mean: f64 = counts().filter(|n| *n > 0.0).map(f64::recip).sum();
        count * of_mean / (used * used)
    }

    /// Mean radiance of both halves of a pixel; `None` if one has no sample.
    pub(super) fn half_means(&self, pixel: usize) -> Option<[DVec3; 2]> {
        let mean = |half| {
            let cell = self.cell(pixel, half);
            let count = self.samples[cell];
            (count > 0).then(|| self.picture[cell].radiance / f64::from(count))
        };
        Some([mean(0)?, mean(1)?])
    }

    /// Records how noisy a half is now: the mean over pixels and channels of its relative variance, the
    /// sample variance over (mean² + 0.01). Only of a film that keeps both variance and halves.
    pub fn record_noise(&mut self, half: usize) {
        let pixels = self.samples.len() / self.halves;
        let of_pixel = |pixel| {
            let cell = self.cell(pixel, half);
            let count = f64::from(self.samples[cell]);
            let mean = self.picture[cell].radiance / count.max(1.0);
            let variance = self.squares[cell] / (count - 1.0).max(1.0);
            (variance / (mean * mean + REL_MSE_FLOOR)).element_sum() / 3.0
        };
        let noise = (0..pixels).map(of_pixel).sum::<f64>() / pixels as f64;
        self.noise[half].push(noise);
    }

    /// What was recorded so.
    #[must_use]
    pub fn noise(&self, half: usize, record: usize) -> f64 {
        self.noise[half][record]
    }

    fn cells(&self, pixel: usize) -> Range<usize> {
        pixel * self.halves..(pixel + 1) * self.halves
    }
}

/// Components of the layers that are averaged, and layers that are not.
fn layer_counts(content: &Content) -> (usize, usize) {
    let (indices, numbers): (Vec<_>, Vec<_>) =
        content.layers.iter().partition(|layer| layer.kind.is_index());
    (numbers.iter().map(|layer| layer.kind.components().len()).sum(), indices.len())
}
