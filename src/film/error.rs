//! How far a picture is from the truth, as its own samples tell.
//!
//! A pixel's samples are kept in two independent halves with means A and B. Its value is I = (A + B)/2
//! and its unknown expectation R. Half the difference, D = (A − B)/2, has exactly the variance of I, for
//! any sampler whose halves are randomised independently: within one half the samples may depend on each
//! other as those of low-discrepancy samplers do, whose error is never seen from the spread within one
//! set. And D does not only have the size of the error, it follows it: for two equal halves
//! (I − R)² − D² = (A − R)(B − R), which has mean 0, and is negative where a rare bright sample fell into
//! one half.
//!
//! The relative squared error e of a pixel is the mean over the three channels of (I − R)²/(R² + 0.01);
//! the mean of e over the pixels is the picture's relMSE. Its estimate ê has D² in the place of (I − R)².
//! In the place of R² it has max(I² − 3D², min(A, B)²): I² alone hides each bright outlier behind itself
//! (an outlier f in the mean counts as f²/f² = 1 and not as f²/R²), and min(A, B)², which no outlier in
//! one half moves, overestimates where noise is moderate. For an outlier in one half the quotient is too
//! small by 1.5 at most.

use rayon::prelude::*;

use super::{Film, Tile};

/// What relMSE adds to the square of the true value, so that pixels that are almost black do not count
/// without limit (Rousselle et al. 2011).
pub const REL_MSE_FLOOR: f64 = 0.01;
/// Side in pixels of the blocks in which neighbours are assumed to have errors of one size.
const BLOCK: u32 = 4;
/// Quantile of the normal distribution at 0.95, the probability with which a bound holds.
const QUANTILE: f64 = 1.645;
/// Part of the pixels to which a noise level applies.
const MOST_PIXELS: f64 = 0.95;

/// An estimate and what the true value is at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Upper bound, which takes into account how much both the estimate and the picture's true error
    /// vary; infinite where there are too few pixels to tell.
    pub bound: f64,
}

impl Film {
    /// Estimates the picture's relMSE: the mean over pixels and channels of (I − R)²/(R² + 0.01) with the
    /// value I and its expectation R. `None` unless the film keeps halves and each has a sample.
    ///
    /// Light that no sample has met so far is not in the estimate.
    #[must_use]
    pub fn rel_mse(&self) -> Option<Estimate> {
        let tiles = self.relative_squares()?;
        let (mut sum, mut sum_of_squares, mut pixels) = (0.0, 0.0, 0.0);
        for (tile, squares) in self.tiles.iter().zip(&tiles) {
            for (block_sum, count) in block_sums(tile, squares) {
                sum += block_sum;
                sum_of_squares += block_sum * block_sum / count;
                pixels += count;
            }
        }
        let value = sum / pixels;
        if sum == 0.0 {
            return Some(Estimate { value, bound: value });
        }
        // Satterthwaite 1946: a sum of squares of very different sizes is about χ² with fewer degrees of
        // freedom than it has terms. The sizes are those of blocks, since one D² says little of its own.
        let freedom = sum * sum / sum_of_squares;
        Some(Estimate { value, bound: value * f_quantile(freedom) })
    }

    /// Estimates the picture's noise level: what 95 % of the pixels have as √e at most, the root of their
    /// relative squared error. `None` as for [`Self::rel_mse`]; the bound is infinite below 103 pixels.
    #[must_use]
    pub fn noise_level(&self) -> Option<Estimate> {
        let mut squares = self.relative_squares()?.concat();
        squares.sort_unstable_by(f64::total_cmp);
        let pixels = squares.len() as f64;
        let at = |fraction: f64| {
            let rank = (fraction * pixels).ceil() as usize;
            squares.get(rank.saturating_sub(1)).map_or(f64::INFINITY, |s| s.sqrt())
        };
        // How many pixels are beyond a level is binomial, both for the estimate and for the truth.
        let margin = QUANTILE * (2.0 * MOST_PIXELS * (1.0 - MOST_PIXELS) / pixels).sqrt();
        let bound =
            if MOST_PIXELS + margin < 1.0 { at(MOST_PIXELS + margin) } else { f64::INFINITY };
        Some(Estimate { value: at(MOST_PIXELS), bound })
    }

    /// ê of each pixel, tile by tile.
    fn relative_squares(&self) -> Option<Vec<Vec<f64>>> {
        if !(self.content.picture && self.content.halves) {
            return None;
        }
        let of_tile = |tile: &Tile| {
            (0..tile.pixels().count()).map(|i| relative_square(tile, i)).collect::<Option<Vec<_>>>()
        };
        self.tiles.par_iter().map(of_tile).collect()
    }
}

/// ê of a pixel.
fn relative_square(tile: &Tile, pixel: usize) -> Option<f64> {
    let [a, b] = tile.half_means(pixel)?;
    let (value, apart) = (0.5 * (a + b), 0.5 * (a - b));
    let (value, apart) = (value * value, apart * apart);
    let truth = (value - 3.0 * apart).max(a.abs().min(b.abs()).powf(2.0));
    Some((apart / (truth + REL_MSE_FLOOR)).element_sum() / 3.0)
}

/// Sum and number of what is in each block of a tile.
fn block_sums(tile: &Tile, squares: &[f64]) -> Vec<(f64, f64)> {
    let area = tile.area();
    let columns = area.width.div_ceil(BLOCK);
    let mut sums = vec![(0.0, 0.0); (columns * area.height.div_ceil(BLOCK)) as usize];
    for (index, square) in (0..).zip(squares) {
        let (x, y) = (index % area.width, index / area.width);
        let (sum, count) = &mut sums[(y / BLOCK * columns + x / BLOCK) as usize];
        *sum += square;
        *count += 1.0;
    }
    sums
}

/// The quantile of the ratio of two independent χ²/ν with the same ν degrees of freedom that
/// [`QUANTILE`] belongs to, by Paulson's approximation (1942), which takes the cube roots to be normal.
/// Infinite where that has no solution, below ν = 1.04.
fn f_quantile(freedom: f64) -> f64 {
    let variance = 2.0 / (9.0 * freedom);
    let mean = (1.0 - variance).powi(2);
    let q = mean - QUANTILE * QUANTILE * variance;
    if q > 0.0 { ((mean + (mean * mean - q * q).sqrt()) / q).powi(3) } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::super::Content;
    use super::*;
    use crate::film::{ComponentFormat, Crop, FilmSettings, Filter};
    use crate::math::Rgb;
    use crate::sampler::{Independent, PathSampler};

    const SIDE: u32 = 24;
    const TRUTH: f64 = 0.5;
    const FILMS: u32 = 400;

    fn empty(width: u32, height: u32) -> Film {
        let settings = FilmSettings {
            width,
            height,
            crop: Crop { x: 0, y: 0, width, height },
            filter: Filter::Box,
            alpha: false,
            component: ComponentFormat::Float,
            variance: false,
            clamp: None,
        };
        let content = Content { picture: true, variance: false, halves: true, layers: Vec::new() };
        Film::new(&settings, content)
    }

    /// A film whose halves have the means that `half_mean` makes of column, row and half.
    fn film(width: u32, height: u32, mut half_mean: impl FnMut(u32, u32, usize) -> f64) -> Film {
        let mut film = empty(width, height);
        for tile in film.tiles_mut() {
            for (pixel, (x, y)) in tile.pixels().enumerate() {
                for half in 0..2 {
                    let cell = tile.cell(pixel, half);
                    tile.add_picture(cell, Rgb::splat(half_mean(x, y, half) as f32), 1.0);
                    tile.count_sample(cell);
                }
            }
        }
        film
    }

    /// Noise with mean 0 at a pixel, from random numbers.
    type Noise = fn(u32, u32, &mut PathSampler<'_>) -> f64;

    fn normal(sigma: f64, numbers: &mut PathSampler<'_>) -> f64 {
        let u = numbers.next_2d();
        let radius = (-2.0 * (1.0 - f64::from(u.x)).ln()).sqrt();
        sigma * radius * (std::f64::consts::TAU * f64::from(u.y)).cos()
    }

    /// Small everywhere.
    const EVEN: Noise = |_, _, numbers| normal(0.1, numbers);
    /// Large in one block, so that the picture's error is that of 16 pixels.
    const UNEVEN: Noise =
        |x, y, numbers| normal(if x < 4 && y < 4 { 0.05 } else { 0.0001 }, numbers);
    /// One half mean in fifty has an outlier of 2, four times the truth.
    const OUTLIERS: Noise = |_, _, numbers| if numbers.next_1d() < 0.02 { 1.96 } else { -0.04 };

    /// In how many of [`FILMS`] films the true relMSE is at most what `bound` says.
    fn held(noise: Noise, bound: impl Fn(&Film) -> f64) -> u32 {
        let sampler = Independent::new(1);
        let holds = |index: u32| {
            let mut numbers = PathSampler::new(&sampler, index, 0);
            let film = film(SIDE, SIDE, |x, y, _| TRUTH + noise(x, y, &mut numbers));
            let error =
                |rgb: &Rgb| (f64::from(rgb.x) - TRUTH).powi(2) / (TRUTH * TRUTH + REL_MSE_FLOOR);
            let errors: f64 = film.radiance().iter().map(error).sum();
            errors / f64::from(SIDE * SIDE) <= bound(&film)
        };
        (0..FILMS).map(|index| u32::from(holds(index))).sum()
    }

    /// A bound that holds with probability 0.95 holds in fewer than 367 of 400 films with a probability of
    /// 0.0024 (binomial): 0.01 for all three after Šidák, with room.
    const FEWEST: u32 = 367;

    #[test]
    fn the_bound_holds_in_95_of_100() {
        let bound = |film: &Film| film.rel_mse().expect("has halves").bound;
        for (name, noise) in [("even", EVEN), ("uneven", UNEVEN), ("outliers", OUTLIERS)] {
            let count = held(noise, bound);
            assert!(count >= FEWEST, "{name}: {count} of {FILMS}");
        }
    }

    /// The estimate alone is too low in many films, and with I² in the place of R² it is in all films with
    /// outliers, even if it is doubled.
    #[test]
    fn less_would_not_do() {
        let value = |film: &Film| film.rel_mse().expect("has halves").value;
        assert!(held(UNEVEN, value) < FEWEST);
        let naive = |film: &Film| {
            let of_tile = |tile: &Tile| -> f64 {
                let of_pixel = |pixel| {
                    let [a, b] = tile.half_means(pixel).expect("has samples");
                    (0.5 * (a.x - b.x)).powi(2) / ((0.5 * (a.x + b.x)).powi(2) + REL_MSE_FLOOR)
                };
                (0..tile.pixels().count()).map(of_pixel).sum()
            };
            2.0 * film.tiles().iter().map(of_tile).sum::<f64>() / f64::from(SIDE * SIDE)
        };
        assert_eq!(held(OUTLIERS, naive), 0);
    }

    /// Quantiles of F(ν, ν) at 0.95, from tables. Paulson's approximation is within 2 % of them from 5
    /// degrees of freedom on and too high below.
    #[test]
    fn quantiles_are_those_of_tables() {
        for (freedom, tabulated) in [(5.0, 5.0503), (10.0, 2.9782), (20.0, 2.1242), (120.0, 1.3519)]
        {
            let ratio = f_quantile(freedom) / tabulated;
            assert!((ratio - 1.0).abs() < 0.02, "{freedom}: {ratio}");
        }
        assert!(f_quantile(2.0) > 19.0);
        assert!(f_quantile(1.0) > 161.0);
    }

    /// 400 pixels with the truth 1 and errors 0/400, 1/400, …: 95 % of them are at 379/400 at most, and the
    /// margin is 1.645 √(2 · 0.95 · 0.05 / 400) = 0.0254, so that the bound is at rank ⌈390.1⌉.
    #[test]
    fn the_noise_level_is_a_quantile() {
        let of = |width, height| {
            let apart = |x: u32, y: u32| f64::from(y * width + x) / 40_000.0;
            let film = film(width, height, |x, y, half| {
                1.0 + if half == 0 { apart(x, y) } else { -apart(x, y) }
            });
            film.noise_level().expect("has halves")
        };
        let Estimate { value, bound } = of(20, 20);
        // (1 − 3D² + 0.01) in the denominator, and values in f32.
        let expected = |d: f64| d / (1.01 - 3.0 * d * d).sqrt();
        assert!((value - expected(379.0 / 40_000.0)).abs() < 1e-7, "{value}");
        assert!((bound - expected(390.0 / 40_000.0)).abs() < 1e-7, "{bound}");
        assert_eq!(of(17, 6).bound, f64::INFINITY);
        assert!(of(103, 1).bound.is_finite());
    }

    #[test]
    fn there_is_no_estimate_without_two_halves() {
        let mut film = empty(2, 1);
        assert_eq!((film.rel_mse(), film.noise_level()), (None, None));
        let tile = &mut film.tiles_mut()[0];
        for (pixel, half) in [(0, 0), (0, 1), (1, 0)] {
            let cell = tile.cell(pixel, half);
            tile.add_picture(cell, Rgb::ONE, 1.0);
            tile.count_sample(cell);
        }
        assert_eq!(film.rel_mse(), None);
        let tile = &mut film.tiles_mut()[0];
        let cell = tile.cell(1, 1);
        tile.add_picture(cell, Rgb::ONE, 1.0);
        tile.count_sample(cell);
        // Where there is no noise there is no doubt.
        assert_eq!(film.rel_mse(), Some(Estimate { value: 0.0, bound: 0.0 }));
    }
}
