//! The film: where samples of a pixel are summed, and what becomes of the sums.

use crate::math::Rgb;

mod atomic_file;
pub mod error;
pub mod exr;
pub(crate) mod exr_size;
pub mod filter;
pub mod layer;
pub mod output;
pub mod picture;
pub mod png;
pub mod read;
pub mod settings;
mod tile;

pub use filter::{Filter, FilterSampler};
pub use layer::{AovKind, AovLayer};
pub use settings::{ComponentFormat, Crop, FilmSettings};
pub use tile::Tile;

/// Side of a tile in pixels.
pub(crate) const TILE: u32 = 16;

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
    /// Whether the variance of the picture's samples is kept.
    pub variance: bool,
    /// Whether each pixel's samples are kept in two halves, which tell its error if they are independent.
    pub halves: bool,
    /// Layers beside it.
    pub layers: Vec<AovLayer>,
}

impl Film {
    /// An empty film.
    #[must_use]
    pub fn new(settings: &FilmSettings, content: Content) -> Self {
        let Crop { x, y, width, height } = settings.crop;
        let tile = |tile_x: u32, tile_y: u32| {
            let area = Crop {
                x: x + tile_x,
                y: y + tile_y,
                width: TILE.min(width - tile_x),
                height: TILE.min(height - tile_y),
            };
            Tile::new(area, &content)
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

    /// Bytes of the film that [`Film::new`] would make.
    #[must_use]
    pub fn bytes(settings: &FilmSettings, content: &Content) -> u64 {
        let Crop { width, height, .. } = settings.crop;
        (u64::from(width) * u64::from(height)).saturating_mul(Tile::bytes_per_pixel(content))
    }

    /// The tiles, which together are the crop.
    pub fn tiles_mut(&mut self) -> &mut [Tile] {
        &mut self.tiles
    }

    /// The same, to be read.
    #[must_use]
    pub fn tiles(&self) -> &[Tile] {
        &self.tiles
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
        let counts = || {
            self.tiles.iter().flat_map(|tile| (0..tile.pixels().count()).map(|i| tile.samples(i)))
        };
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
        self.by_rows(|tile, i| tile.radiance(i).as_vec3a())
    }

    /// Mean alpha likewise.
    #[must_use]
    pub fn alpha(&self) -> Vec<f32> {
        self.by_rows(|tile, i| tile.alpha(i) as f32)
    }

    /// Unbiased sample variance of one sample's radiance, per channel, likewise; infinite where there are
    /// fewer than two samples. Only of a film that keeps it. If the halves of a pixel's samples differ in
    /// size it is larger by as much as the variance of the mean is then.
    ///
    /// Divided by the number of samples it is the variance of a pixel's mean if the samples are
    /// independent. Those of a low-discrepancy sampler are not: they cover their domain evenly, so that
    /// their mean varies less than that.
    #[must_use]
    pub fn variance(&self) -> Vec<Rgb> {
        self.by_rows(|tile, i| tile.variance(i).as_vec3a())
    }

    /// Samples that each pixel has, likewise.
    #[must_use]
    pub fn samples(&self) -> Vec<u32> {
        self.by_rows(Tile::samples)
    }

    /// Mean of component number `component`, counted over all layers that are averaged.
    #[must_use]
    pub fn number(&self, component: usize) -> Vec<f32> {
        self.by_rows(|tile, i| tile.number(i, component) as f32)
    }

    /// Values of layer number `layer`, counted over those that are not averaged.
    #[must_use]
    pub fn index(&self, layer: usize) -> Vec<u32> {
        self.by_rows(|tile, i| tile.index(i, layer))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{ComponentFormat, Filter};

    fn content(variance: bool) -> Content {
        Content { picture: true, variance, halves: false, layers: Vec::new() }
    }

    fn one_pixel(variance: bool) -> Film {
        let settings = FilmSettings {
            width: 1,
            height: 1,
            crop: Crop { x: 0, y: 0, width: 1, height: 1 },
            filter: Filter::Box,
            alpha: false,
            component: ComponentFormat::Float,
            variance: false,
            clamp: None,
        };
        Film::new(&settings, content(variance))
    }

    /// The mean of a million equal samples is the sample: f64 sums err by 1e-10 at most, and the result
    /// is rounded once to f32.
    #[test]
    fn a_million_samples_keep_their_mean() {
        let mut film = one_pixel(false);
        let tile = &mut film.tiles_mut()[0];
        for _ in 0..1_000_000 {
            tile.add_picture(0, Rgb::splat(0.1), 1.0);
            tile.count_sample(0);
        }
        assert_eq!(film.radiance(), [Rgb::splat(0.1)]);
        assert_eq!(film.alpha(), [1.0]);
    }

    /// 1e9 and a million ones: f32 would still have 1e9.
    #[test]
    fn a_bright_sample_does_not_swallow_the_rest() {
        let mut film = one_pixel(false);
        let tile = &mut film.tiles_mut()[0];
        tile.add_picture(0, Rgb::splat(1e9), 1.0);
        tile.count_sample(0);
        for _ in 0..1_000_000 {
            tile.add_picture(0, Rgb::ONE, 1.0);
            tile.count_sample(0);
        }
        assert_eq!(film.radiance()[0].x, (1.001e9 / 1_000_001.0) as f32);
    }

    /// Mean 1e6, values one apart: a plain sum of squares, 1e18, would have lost them at its 53 bits.
    #[test]
    fn variance_survives_a_large_mean_and_many_samples() {
        let mut film = one_pixel(true);
        let tile = &mut film.tiles_mut()[0];
        for i in 0..1_000_000_u32 {
            let value = 1e6 + (i % 3) as f32;
            tile.add_picture(0, Rgb::new(value, 2.0 * value, 0.25), 1.0);
            tile.count_sample(0);
        }
        let [red, green, blue] = film.variance()[0].to_array();
        // 0, 1, 2 have variance 2/3. The mean that is updated has an error of 2⁻⁵³·1e6 at most.
        assert!((red - 2.0 / 3.0).abs() < 2e-6, "{red}");
        assert!((green - 8.0 / 3.0).abs() < 8e-6, "{green}");
        assert_eq!(blue, 0.0);
        assert_eq!(film.samples(), [1_000_000]);
    }

    #[test]
    fn variance_is_unknown_before_the_second_sample() {
        let mut film = one_pixel(true);
        for (value, variance) in [(1.0, f32::INFINITY), (3.0, 2.0), (5.0, 4.0)] {
            let tile = &mut film.tiles_mut()[0];
            tile.add_picture(0, Rgb::splat(value), 1.0);
            tile.count_sample(0);
            assert_eq!(film.variance(), [Rgb::splat(variance)]);
        }
    }

    /// Six samples of variance 6/5, of which four are in one half: the mean of both halves' means has the
    /// variance (1/4 + 1/2)/4 times that, and not 1/6.
    #[test]
    fn variance_is_that_of_halves_of_any_size() {
        let content = Content { halves: true, ..content(true) };
        let mut film = Film::new(&one_pixel(true).settings, content);
        let tile = &mut film.tiles_mut()[0];
        for (half, value) in [(0, 1.0), (0, 3.0), (1, 1.0), (0, 1.0), (0, 3.0), (1, 3.0)] {
            tile.add_picture(tile.cell(0, half), Rgb::splat(value), 1.0);
            tile.count_sample(tile.cell(0, half));
        }
        assert_eq!(film.variance(), [Rgb::splat(6.0 / 5.0 * 6.0 * 0.75 / 4.0)]);
    }

    #[test]
    fn tiles_cover_the_crop_once() {
        let crop = Crop { x: 3, y: 5, width: 37, height: 17 };
        let settings =
            FilmSettings { width: 64, height: 64, crop, ..one_pixel(false).settings().clone() };
        let film = Film::new(&settings, content(false));
        let mut seen: Vec<_> = film.tiles.iter().flat_map(Tile::pixels).collect();
        seen.sort_unstable();
        let mut expected: Vec<_> = (3..40).flat_map(|x| (5..22).map(move |y| (x, y))).collect();
        expected.sort_unstable();
        assert_eq!(seen, expected);
    }
}
