//! Sobol' points with Owen's scrambling.
//!
//! The first four dimensions of Sobol's sequence, with the direction numbers of Joe and Kuo ("Constructing
//! Sobol sequences with better two-dimensional projections", 2008), serve as a block. Further blocks are
//! padded: each is the same four dimensions in an order and with a scrambling of its own (Burley,
//! "Practical Hash-based Owen Scrambling", 2020), and so are single numbers and pairs across the border of
//! two blocks. Any first 2^k samples of a pixel are spread evenly, and so is any count of them nearly.
//!
//! Pixels are scrambled independently. Sequences that run from pixel to pixel (Ahmed and Wonka 2020;
//! `ZSobolSampler` of pbrt) have the same error in each pixel and spread it as blue noise, at the price
//! of a count of samples that must be known before the first one, and of noise that hangs together.

use super::bits::{GOLDEN, lowbias32, mix, pcg3d};
use super::{About, PathKey, PathKeys, Sequence};
use crate::math::real::{Mask, Uint};

pub(super) static ABOUT: About = About {
    name: "sobol",
    help: "Sobol' points with Owen's scrambling, spread evenly for any number of samples and best for powers \
           of 2; the sampler of sensors that have none (not in Mitsuba).",
    independent: false,
    build: |seed| Box::new(Sobol::new(seed)),
};

/// Numbers that are spread more evenly than by chance. The error of a smooth integrand falls nearly as
/// n^(−3/2), that of a rough one no slower than with [`super::Independent`].
#[derive(Clone, Copy, Debug)]
pub struct Sobol {
    /// The seed, mixed.
    seed: u64,
}

impl Sobol {
    /// Different seeds give unrelated numbers.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { seed: mix(seed ^ GOLDEN) }
    }

    /// The index of the path's point in the order of one of its sequences, and bits to scramble its coordinates.
    #[inline(always)]
    fn point<U: Uint>(&self, path: PathKeys<U>, sequence: U) -> (U, [U; 2]) {
        let [low, high] = [self.seed as u32, (self.seed >> 32) as u32];
        let [order, x, y] = pcg3d([path.high ^ low, sequence ^ high, sequence]);
        // Scrambling the index keeps every aligned run of 2^k samples together.
        (scramble(path.low, order).reverse_bits(), [x, y])
    }

    /// Two coordinates, the first binary digit highest, and bits that belong to both.
    #[inline(always)]
    fn pair<U: Uint>(&self, path: PathKeys<U>, dimension: U) -> ([U; 2], U) {
        let in_block = (dimension & 1).eq(0);
        let sequence = U::select(in_block, (dimension >> 2) | BLOCKS, dimension);
        let (index, [mut seed_x, mut seed_y]) = self.point(path, sequence);
        let [mut x, mut y] = [index, second(index)];
        let in_second_half = (dimension & 3).eq(2);
        if in_second_half.any() {
            let [third, fourth] = third_and_fourth(index);
            x = U::select(in_second_half, third, x);
            y = U::select(in_second_half, fourth, y);
            seed_x = U::select(in_second_half, lowbias32(seed_x), seed_x);
            seed_y = U::select(in_second_half, lowbias32(seed_y), seed_y);
        }
        let (x, y) = (scramble(x, seed_x), scramble(y, seed_y));
        ([x.reverse_bits(), y.reverse_bits()], seed_x)
    }
}

impl Sequence for Sobol {
    fn path(&self, pixel: u32, sample: u32) -> PathKey {
        // Reversed, as `scramble` takes it.
        PathKey((u64::from(pixel) << 32) | u64::from(sample.reverse_bits()))
    }

    #[inline(always)]
    fn one<U: Uint>(&self, path: PathKeys<U>, dimension: U) -> U {
        let (index, [seed, _]) = self.point(path, dimension);
        scramble(index, seed).reverse_bits()
    }

    #[inline(always)]
    fn two<U: Uint>(&self, path: PathKeys<U>, dimension: U) -> [U; 2] {
        self.pair(path, dimension).0
    }

    /// What comes after the first 32 bits is Owen's scrambling of a coordinate that ends before them.
    #[inline(always)]
    fn choice<U: Uint>(&self, path: PathKeys<U>, dimension: U) -> [U; 3] {
        let ([x, y], seed) = self.pair(path, dimension);
        [x, lowbias32(seed ^ x), y]
    }
}

/// Tells the sequences of blocks from those of single dimensions.
const BLOCKS: u32 = 1 << 31;

/// Owen's scrambling of a number whose bits are reversed, last digit first: whether a digit is flipped
/// depends on `seed` and on the digits before it. The hash is Laine and Karras's (2011), with Vegdahl's
/// constants ("Building a Better LK Hash", 2021).
#[inline(always)]
fn scramble<U: Uint>(x: U, seed: U) -> U {
    let x = x ^ x.wrapping_mul(0x3d20_adea);
    let x = x.wrapping_add(seed).wrapping_mul((seed >> 16) | 1);
    let x = x ^ x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// The second coordinate of point `index`, its bits reversed. (The first is `index` itself.) Its
/// matrix is Pascal's triangle modulo 2, a product of five shifts (Ahmed, "An Implementation Algorithm of
/// 2D Sobol Sequence Fast, Elegant, and Compact", 2024).
#[inline(always)]
fn second<U: Uint>(index: U) -> U {
    let x = index ^ (index >> 16);
    let x = x ^ ((x & 0xff00_ff00) >> 8);
    let x = x ^ ((x & 0xf0f0_f0f0) >> 4);
    let x = x ^ ((x & 0xcccc_cccc) >> 2);
    x ^ ((x & 0xaaaa_aaaa) >> 1)
}

/// The third and the fourth coordinate of point `index`, their bits reversed.
#[inline(always)]
fn third_and_fourth<U: Uint>(index: U) -> [U; 2] {
    let none = U::splat(index.token(), 0);
    let mut both = [none; 2];
    for (bit, [third, fourth]) in THIRD_AND_FOURTH.into_iter().enumerate() {
        // All ones where the bit is set.
        let set = none.wrapping_sub((index >> bit as u32) & 1);
        both = [both[0] ^ (set & third), both[1] ^ (set & fourth)];
    }
    both
}

/// For each bit of an index, from the lowest on, what it adds to the third coordinate and to the fourth, bits reversed.
const THIRD_AND_FOURTH: [[u32; 2]; 32] = {
    let third = directions([1, 3, 0], 2);
    let fourth = directions([1, 3, 1], 3);
    let mut columns = [[0; 2]; 32];
    let mut bit = 0;
    while bit < 32 {
        columns[bit] = [third[bit].reverse_bits(), fourth[bit].reverse_bits()];
        bit += 1;
    }
    columns
};

/// Direction numbers from the first `degree` odd integers, for the polynomials x² + x + 1 and x³ + x + 1
/// (Bratley and Fox 1988, equation 2).
const fn directions(first: [u32; 3], degree: usize) -> [u32; 32] {
    let mut v = [0; 32];
    let mut i = 0;
    while i < 32 {
        v[i] = if i < degree {
            first[i] << (31 - i)
        } else {
            // Of the coefficients between the first and the last, only that of x is 1.
            v[i - degree] ^ (v[i - degree] >> degree) ^ v[i + 1 - degree]
        };
        i += 1;
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first points as Joe and Kuo print them, in order of index instead of Gray code.
    #[test]
    fn first_points_are_sobols() {
        let eighths = |x: u32| x.reverse_bits() >> 29;
        let points = (0..8).map(|i| {
            let [third, fourth] = third_and_fourth::<u32>(i);
            [i, second(i), third, fourth].map(eighths)
        });
        assert_eq!(
            points.collect::<Vec<_>>(),
            [
                [0, 0, 0, 0],
                [4, 4, 4, 4],
                [2, 6, 6, 6],
                [6, 2, 2, 2],
                [1, 5, 3, 1],
                [5, 1, 7, 5],
                [3, 3, 5, 7],
                [7, 7, 1, 3],
            ]
        );
    }
}
