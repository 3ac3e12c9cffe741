//! Sums of samples over a rectangle of pixels.

use glam::DVec3;

use super::Content;
use crate::math::Rgb;
use crate::scene::settings::Crop;

/// A rectangle of pixels, with no more of their samples than was asked for.
#[derive(Debug)]
pub struct Tile {
    area: Crop,
    picture: Vec<PictureSum>,
    /// Sums of squared deviations from the mean radiance, if asked for.
    squares: Vec<DVec3>,
    /// Components of the layers that are averaged, pixel by pixel.
    numbers: Vec<f64>,
    /// Layers that are not, pixel by pixel.
    indices: Vec<u32>,
    samples: Vec<u32>,
    numbers_per_pixel: usize,
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
        let indices_per_pixel = content.layers.iter().filter(|l| l.kind.is_index()).count();
        let numbers_per_pixel = content
            .layers
            .iter()
            .filter(|l| !l.kind.is_index())
            .map(|l| l.kind.components().len())
            .sum();
        let if_kept = |kept| if kept { pixels } else { 0 };
        Self {
            area,
            picture: vec![PictureSum::default(); if_kept(content.picture)],
            squares: vec![DVec3::ZERO; if_kept(content.picture && content.variance)],
            numbers: vec![0.0; pixels * numbers_per_pixel],
            indices: vec![0; pixels * indices_per_pixel],
            samples: vec![0; pixels],
            numbers_per_pixel,
            indices_per_pixel,
        }
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

    /// Samples that a pixel has.
    #[must_use]
    pub fn samples(&self, pixel: usize) -> u32 {
        self.samples[pixel]
    }

    /// The same of all pixels.
    pub(super) fn counts(&self) -> impl Iterator<Item = u32> + '_ {
        self.samples.iter().copied()
    }

    /// Adds one sample of the picture to a pixel.
    pub fn add_picture(&mut self, pixel: usize, radiance: Rgb, alpha: f32) {
        let sum = &mut self.picture[pixel];
        let radiance = radiance.as_dvec3();
        sum.radiance += radiance;
        sum.alpha += f64::from(alpha);
        if let Some(squares) = self.squares.get_mut(pixel) {
            let before = f64::from(self.samples[pixel]);
            if before > 0.0 {
                // Youngs and Cramer 1971: from the deviation of the new sample from the new mean.
                let deviation = radiance - sum.radiance / (before + 1.0);
                *squares += deviation * deviation * ((before + 1.0) / before);
            }
        }
    }

    /// The sums of a pixel's averaged layers, and the values of its others.
    pub fn layers_mut(&mut self, pixel: usize) -> (&mut [f64], &mut [u32]) {
        let (n, i) = (self.numbers_per_pixel, self.indices_per_pixel);
        (&mut self.numbers[pixel * n..][..n], &mut self.indices[pixel * i..][..i])
    }

    /// Counts one more sample of a pixel, after all of it was added.
    pub fn count(&mut self, pixel: usize) {
        self.samples[pixel] += 1;
    }

    pub(super) fn radiance(&self, pixel: usize) -> DVec3 {
        self.picture[pixel].radiance / self.divisor(pixel)
    }

    pub(super) fn alpha(&self, pixel: usize) -> f64 {
        self.picture[pixel].alpha / self.divisor(pixel)
    }

    pub(super) fn variance(&self, pixel: usize) -> DVec3 {
        match self.samples[pixel] {
            0 | 1 => DVec3::INFINITY,
            count => self.squares[pixel] / f64::from(count - 1),
        }
    }

    pub(super) fn number(&self, pixel: usize, component: usize) -> f64 {
        self.numbers[pixel * self.numbers_per_pixel + component] / self.divisor(pixel)
    }

    pub(super) fn index(&self, pixel: usize, layer: usize) -> u32 {
        self.indices[pixel * self.indices_per_pixel + layer]
    }

    /// A pixel without samples is black, not NaN.
    fn divisor(&self, pixel: usize) -> f64 {
        f64::from(self.samples[pixel].max(1))
    }
}
