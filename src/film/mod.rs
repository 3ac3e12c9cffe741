//! The film: where samples of a pixel are summed, and what becomes of the sums.

use glam::DVec3;

use crate::math::Rgb;
use crate::scene::settings::{AovKind, AovLayer, Crop, FilmSettings};

pub mod exr;
pub mod filter;
pub mod output;
pub mod picture;
pub mod png;
pub mod read;

pub use filter::FilterSampler;

/// Side of a tile in pixels.
const TILE: u32 = 16;

/// Sums of samples, per pixel and tile by tile, so that threads never share one.
#[derive(Debug)]
pub struct Film {
    settings: FilmSettings,
    content: Content,
    tiles: Vec<Tile>,
}

/// What is kept of each sample.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Content {
    /// Whether there is a picture, and not only layers.
    pub picture: bool,
    /// Layers beside it.
    pub layers: Vec<AovLayer>,
}

/// A rectangle of pixels.
#[derive(Debug)]
pub struct Tile {
    area: Crop,
    picture: Vec<PictureSum>,
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

impl AovKind {
    /// Names of the components, as after the dot in a channel's name.
    #[must_use]
    pub fn components(self) -> &'static [&'static str] {
        match self {
            Self::Depth => &["T"],
            Self::Position | Self::GeometricNormal | Self::ShadingNormal => &["X", "Y", "Z"],
            Self::Uv => &["U", "V"],
            Self::Albedo => &["R", "G", "B"],
            Self::ShapeIndex | Self::PrimitiveIndex => &["I"],
        }
    }

    /// Whether the layer holds whole numbers, of which no mean makes sense.
    #[must_use]
    pub fn is_index(self) -> bool {
        matches!(self, Self::ShapeIndex | Self::PrimitiveIndex)
    }
}

impl Film {
    /// An empty film.
    #[must_use]
    pub fn new(settings: &FilmSettings, content: Content) -> Self {
        let Crop { x, y, width, height } = settings.crop;
        let indices_per_pixel = content.layers.iter().filter(|l| l.kind.is_index()).count();
        let numbers_per_pixel = content
            .layers
            .iter()
            .filter(|l| !l.kind.is_index())
            .map(|l| l.kind.components().len())
            .sum();
        let tile = |tile_x: u32, tile_y: u32| {
            let area = Crop {
                x: x + tile_x,
                y: y + tile_y,
                width: TILE.min(width - tile_x),
                height: TILE.min(height - tile_y),
            };
            let pixels = (area.width * area.height) as usize;
            Tile {
                area,
                picture: vec![PictureSum::default(); if content.picture { pixels } else { 0 }],
                numbers: vec![0.0; pixels * numbers_per_pixel],
                indices: vec![0; pixels * indices_per_pixel],
                samples: vec![0; pixels],
                numbers_per_pixel,
                indices_per_pixel,
            }
        };
        let tiles = (0..height)
            .step_by(TILE as usize)
            .flat_map(|tile_y| {
                (0..width).step_by(TILE as usize).map(move |tile_x| (tile_x, tile_y))
            })
            .map(|(tile_x, tile_y)| tile(tile_x, tile_y))
            .collect();
        Self { settings: settings.clone(), content, tiles }
    }

    /// The tiles, which together are the crop.
    pub fn tiles_mut(&mut self) -> &mut [Tile] {
        &mut self.tiles
    }

    /// The settings that it was made from.
    #[must_use]
    pub fn settings(&self) -> &FilmSettings {
        &self.settings
    }

    /// What it keeps.
    #[must_use]
    pub fn content(&self) -> &Content {
        &self.content
    }

    /// Smallest and largest number of samples that any pixel has.
    #[must_use]
    pub fn samples_per_pixel(&self) -> (u32, u32) {
        let counts = || self.tiles.iter().flat_map(|t| t.samples.iter().copied());
        (counts().min().unwrap_or(0), counts().max().unwrap_or(0))
    }

    /// For each pixel of the crop, row by row, what `read` makes of its tile and its index there.
    fn by_rows<T: Copy + Default>(&self, read: impl Fn(&Tile, usize) -> T) -> Vec<T> {
        let crop = self.settings.crop;
        let mut values = vec![T::default(); crop.width as usize * crop.height as usize];
        for tile in &self.tiles {
            for (index, (x, y)) in tile.pixels().enumerate() {
                let place = (y - crop.y) as usize * crop.width as usize + (x - crop.x) as usize;
                values[place] = read(tile, index);
            }
        }
        values
    }

    /// Mean radiance of each pixel of the crop, row by row; 0 where there is no sample.
    #[must_use]
    pub fn radiance(&self) -> Vec<Rgb> {
        self.by_rows(|tile, i| (tile.picture[i].radiance / tile.divisor(i)).as_vec3a())
    }

    /// Mean alpha likewise.
    #[must_use]
    pub fn alpha(&self) -> Vec<f32> {
        self.by_rows(|tile, i| (tile.picture[i].alpha / tile.divisor(i)) as f32)
    }

    /// Mean of component number `component`, counted over all layers that are averaged.
    #[must_use]
    pub fn number(&self, component: usize) -> Vec<f32> {
        self.by_rows(|tile, i| {
            (tile.numbers[i * tile.numbers_per_pixel + component] / tile.divisor(i)) as f32
        })
    }

    /// Values of layer number `layer`, counted over those that are not averaged.
    #[must_use]
    pub fn index(&self, layer: usize) -> Vec<u32> {
        self.by_rows(|tile, i| tile.indices[i * tile.indices_per_pixel + layer])
    }
}

impl Tile {
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

    /// Adds one sample of the picture to a pixel.
    pub fn add_picture(&mut self, pixel: usize, radiance: Rgb, alpha: f32) {
        let sum = &mut self.picture[pixel];
        sum.radiance += radiance.as_dvec3();
        sum.alpha += f64::from(alpha);
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

    /// A pixel without samples is black, not NaN.
    fn divisor(&self, pixel: usize) -> f64 {
        f64::from(self.samples[pixel].max(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::settings::{ComponentFormat, Filter};

    fn one_pixel() -> Film {
        let settings = FilmSettings {
            width: 1,
            height: 1,
            crop: Crop { x: 0, y: 0, width: 1, height: 1 },
            filter: Filter::Box,
            alpha: false,
            component: ComponentFormat::Float,
        };
        Film::new(&settings, Content { picture: true, layers: Vec::new() })
    }

    /// The mean of a million equal samples is the sample: f64 sums err by 1e-10 at most, and the result
    /// is rounded once to f32.
    #[test]
    fn a_million_samples_keep_their_mean() {
        let mut film = one_pixel();
        let tile = &mut film.tiles_mut()[0];
        for _ in 0..1_000_000 {
            tile.add_picture(0, Rgb::splat(0.1), 1.0);
            tile.count(0);
        }
        assert_eq!(film.radiance(), [Rgb::splat(0.1)]);
        assert_eq!(film.alpha(), [1.0]);
    }

    /// 1e9 and a million ones: f32 would still have 1e9.
    #[test]
    fn a_bright_sample_does_not_swallow_the_rest() {
        let mut film = one_pixel();
        let tile = &mut film.tiles_mut()[0];
        tile.add_picture(0, Rgb::splat(1e9), 1.0);
        tile.count(0);
        for _ in 0..1_000_000 {
            tile.add_picture(0, Rgb::ONE, 1.0);
            tile.count(0);
        }
        assert_eq!(film.radiance()[0].x, (1.001e9 / 1_000_001.0) as f32);
    }

    #[test]
    fn tiles_cover_the_crop_once() {
        let crop = Crop { x: 3, y: 5, width: 37, height: 17 };
        let settings =
            FilmSettings { width: 64, height: 64, crop, ..one_pixel().settings().clone() };
        let film = Film::new(&settings, Content { picture: true, layers: Vec::new() });
        let mut seen: Vec<_> = film.tiles.iter().flat_map(Tile::pixels).collect();
        seen.sort_unstable();
        let mut expected: Vec<_> = (3..40).flat_map(|x| (5..22).map(move |y| (x, y))).collect();
        expected.sort_unstable();
        assert_eq!(seen, expected);
    }
}
