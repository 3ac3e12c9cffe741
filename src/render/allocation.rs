//! How many samples each tile gets, if not all get the same.
//!
//! A mean of samples is biased if those samples had a say in how many there are (Kirk and Arvo 1991): who
//! goes on where it is noisy dilutes the bright outliers that it has seen, and stays with the dark means
//! that have none. So each half of a film goes where the *other* half found noise. Given the other half,
//! the number of its samples is fixed, its mean is unbiased, and so is the mean of both halves' means.
//! For that, what a half found must not depend on how many samples it was given itself: noise is recorded
//! when each pixel has 4, 8, 16, … samples, and what is read was recorded before any tile can have fewer.

use crate::film::{Film, Tile};

/// Samples per pixel when noise is recorded first; and then each time that they have doubled.
const FIRST_RECORD: u32 = 4;
/// Each tile has at least the mean number of samples divided by this.
const LEAST: u32 = 4;
/// Each tile has at most the mean number of samples times this, since a few samples do not tell more.
const MOST: u32 = 8;
/// Samples of each pixel after which tiles begin to differ.
pub const FIRST_ALLOCATION: u32 = LEAST * FIRST_RECORD;

/// Samples for each pixel of each tile of both halves, `mean` in all per pixel on average; `done` is what
/// `mean` was before. All tiles get the same until there is a record.
pub(super) fn allocate(film: &Film, done: u32, mean: u32) -> Vec<[u32; 2]> {
    let uniform = [mean.div_ceil(2), mean / 2];
    let Some(record) = (done / FIRST_ALLOCATION).checked_ilog2() else {
        return vec![uniform; film.tiles().len()];
    };
    let [first, second] =
        [0, 1].map(|half| allocate_half(film.tiles(), half, record as usize, uniform[half], mean));
    first.into_iter().zip(second).map(|(a, b)| [a, b]).collect()
}

/// The number of samples of a half, now and then, after which noise is recorded: the first after `count`.
pub(super) fn next_record(count: u32) -> u32 {
    (count + 1).next_power_of_two().max(FIRST_RECORD / 2)
}

/// For one half. The variance of the picture's mean is least if the samples are in proportion to the
/// standard deviation; relMSE counts it relative to √(mean² + 0.01).
fn allocate_half(tiles: &[Tile], half: usize, record: usize, share: u32, mean: u32) -> Vec<u32> {
    let noise: Vec<_> = tiles.iter().map(|t| t.noise(1 - half, record).sqrt()).collect();
    let least = mean / (2 * LEAST);
    let most = share.saturating_mul(MOST);
    let count = |tile: &Tile, noise: f64, scale: f64| {
        // A product that is none (0 times infinity) becomes 0.
        ((scale * noise) as u32).clamp(least, most).max(tile.count(tile.cell(0, half)))
    };
    let pixels = |tile: &Tile| u64::from(tile.area().width * tile.area().height);
    let total = |scale: f64| -> u64 {
        tiles.iter().zip(&noise).map(|(t, n)| pixels(t) * u64::from(count(t, *n, scale))).sum()
    };
    let budget = tiles.iter().map(pixels).sum::<u64>() * u64::from(share);
    let loudest = noise.iter().copied().fold(0.0, f64::max);
    if loudest <= 0.0 {
        return vec![share; tiles.len()];
    }
    // The largest scale that does not exceed the budget. Where most tiles are quiet, none does.
    let (mut low, mut high) = (0.0, f64::from(most) / loudest);
    for _ in 0..64 {
        if total(high) > budget {
            break;
        }
        (low, high) = (high, 2.0 * high);
    }
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if total(middle) <= budget { low = middle } else { high = middle }
    }
    tiles.iter().zip(&noise).map(|(t, n)| count(t, *n, low)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{ComponentFormat, Content, Crop, FilmSettings, Filter};
    use crate::math::Rgb;
    use crate::sampler::{Independent, PathSampler};

    /// One row of pixels: a tile of 16, and a tile of one.
    fn film() -> Film {
        let settings = FilmSettings {
            width: 17,
            height: 1,
            crop: Crop { x: 0, y: 0, width: 17, height: 1 },
            filter: Filter::Box,
            alpha: false,
            component: ComponentFormat::Float,
            variance: false,
            clamp: None,
        };
        let content = Content { picture: true, variance: true, halves: true, layers: Vec::new() };
        Film::new(&settings, content)
    }

    /// Takes samples as a render does; `value` makes them of the tile's and the sample's number.
    fn sample(film: &mut Film, ends: &[[u32; 2]], mut value: impl FnMut(usize, u32) -> f32) {
        for (index, (tile, ends)) in film.tiles_mut().iter_mut().zip(ends).enumerate() {
            for (half, &end) in ends.iter().enumerate() {
                for count in tile.count(tile.cell(0, half))..end {
                    for pixel in 0..tile.pixels().count() {
                        let cell = tile.cell(pixel, half);
                        tile.add_picture(cell, Rgb::splat(value(index, count)), 1.0);
                        tile.count_sample(cell);
                    }
                    if count + 1 == next_record(count) {
                        tile.record_noise(half);
                    }
                }
            }
        }
    }

    #[test]
    fn records_are_made_when_samples_have_doubled() {
        let next = [(0, 2), (1, 2), (2, 4), (3, 4), (4, 8), (9, 16)];
        assert!(next.iter().all(|&(count, record)| next_record(count) == record));
    }

    /// Relative deviations of 1 and 4 around means that are large beside √0.01, at 17 pixels of which 16 are
    /// quiet: with a mean of 64 the numbers are s and 4s with 16 s + 4 s = 17 · 64, thus 54.4 and 217.6.
    #[test]
    fn samples_are_in_proportion_to_the_deviation() {
        let mut film = film();
        let value = |tile: usize, count: u32| {
            let deviation = if tile == 0 { 1.0 } else { 4.0 };
            if count.is_multiple_of(2) { 100.0 + deviation } else { 100.0 - deviation }
        };
        sample(&mut film, &[[8, 8]; 2], value);
        let ends = allocate(&film, 16, 64);
        for half in [0, 1] {
            let [quiet, noisy] = [ends[0][half], ends[1][half]];
            assert!(quiet.abs_diff(27) <= 1 && noisy.abs_diff(109) <= 4, "{ends:?}");
            assert!(16 * quiet + noisy <= 17 * 32, "{ends:?}");
        }
        // Before there is a record, and without noise, all are alike; odd numbers are split.
        assert_eq!(allocate(&film, 15, 31), [[16, 15]; 2]);
        let mut still = self::film();
        sample(&mut still, &[[8, 8]; 2], |_, _| 1.0);
        assert_eq!(allocate(&still, 16, 64), [[32, 32]; 2]);
    }

    /// Mean and standard error of the pixel that is a tile, over many films whose samples are 10 with
    /// probability 0.1 and else 0.
    fn mean_of_pixel(allocate: impl Fn(&Film) -> Vec<[u32; 2]>) -> (f64, f64) {
        let numbers = Independent::new(3);
        let (mut sum, mut squares, films) = (0.0, 0.0, 20_000);
        for index in 0..films {
            let mut film = film();
            let mut numbers = PathSampler::new(&numbers, index, 0);
            let mut value = |_, _| if numbers.next_1d() < 0.1 { 10.0 } else { 0.0 };
            sample(&mut film, &[[8, 8]; 2], &mut value);
            let ends = allocate(&film);
            sample(&mut film, &ends, &mut value);
            let value = f64::from(film.radiance()[16].x);
            sum += value;
            squares += value * value;
        }
        let mean = sum / f64::from(films);
        (mean, ((squares / f64::from(films) - mean * mean) / f64::from(films)).sqrt())
    }

    /// The expectation is 1. 2.576 standard errors are passed with probability 0.01.
    #[test]
    fn the_mean_is_unbiased() {
        let (mean, error) = mean_of_pixel(|film| allocate(film, 16, 64));
        assert!((mean - 1.0).abs() < 2.576 * error, "{mean} ± {error}");
        // If each half goes where it has found noise itself, what it has found is diluted.
        let (mean, error) =
            mean_of_pixel(|film| allocate(film, 16, 64).into_iter().map(|[a, b]| [b, a]).collect());
        assert!(mean < 1.0 - 5.0 * error, "{mean} ± {error}");
    }
}
