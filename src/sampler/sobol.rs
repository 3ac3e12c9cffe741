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

use glam::{DVec2, Vec2};

use super::bits::{GOLDEN, mix, to_unit};
use super::{About, PathKey, Sampler};

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

    /// The index of the path's point in the order of one of its sequences, and 64 bits to scramble its
    /// coordinates.
    fn point(&self, path: PathKey, sequence: u32) -> (u32, u64) {
        let pixel = path.0 & !u64::from(u32::MAX);
        let hash = mix(self.seed ^ (pixel | u64::from(sequence)));
        // Scrambling the index keeps every aligned run of 2^k samples together.
        (scramble(path.0 as u32, hash as u32).reverse_bits(), hash)
    }

    /// Two coordinates, the first binary digit highest, and bits that belong to both.
    fn pair(&self, path: PathKey, dimension: u32) -> (u32, u32, u64) {
        let in_block = dimension.is_multiple_of(2);
        let sequence = if in_block { BLOCKS | (dimension / 4) } else { dimension };
        let (index, hash) = self.point(path, sequence);
        let (x, y, hash) = if in_block && dimension % 4 == 2 {
            let (x, y) = third_and_fourth(index);
            (x, y, hash.wrapping_mul(SECOND_HALF))
        } else {
            (index, second(index), hash)
        };
        let x = scramble(x, (hash >> 32) as u32);
        let y = scramble(y, (hash.wrapping_mul(GOLDEN) >> 32) as u32);
        // Both at once.
        let reversed = ((u64::from(y) << 32) | u64::from(x)).reverse_bits();
        ((reversed >> 32) as u32, reversed as u32, hash)
    }
}

impl Sampler for Sobol {
    fn path(&self, pixel: u32, sample: u32) -> PathKey {
        // Reversed, as `scramble` takes it.
        PathKey((u64::from(pixel) << 32) | u64::from(sample.reverse_bits()))
    }

    fn get_1d(&self, path: PathKey, dimension: u32) -> f32 {
        let (index, hash) = self.point(path, dimension);
        to_unit(scramble(index, (hash >> 32) as u32).reverse_bits())
    }

    fn get_2d(&self, path: PathKey, dimension: u32) -> Vec2 {
        let (x, y, _) = self.pair(path, dimension);
        Vec2::new(to_unit(x), to_unit(y))
    }

    /// The first has 40 bits, the last 8 of which are Owen's scrambling of a coordinate that ends before them.
    fn get_choice(&self, path: PathKey, dimension: u32) -> DVec2 {
        const ULP: f64 = 1.0 / (1u64 << 40) as f64;
        let (x, y, hash) = self.pair(path, dimension);
        let end = mix(hash ^ u64::from(x)) >> 56;
        DVec2::new(((u64::from(x) << 8) | end) as f64 * ULP, to_unit(y).into())
    }
}

/// Tells the sequences of blocks from those of single dimensions.
const BLOCKS: u32 = 1 << 31;

/// Makes other bits for the second half of a block (an odd number whose bits look random).
const SECOND_HALF: u64 = 0xd6e8_feb8_6659_fd93;

/// Owen's scrambling of a number whose bits are reversed, last digit first: whether a digit is flipped
/// depends on `seed` and on the digits before it. The hash is Laine and Karras's (2011), with Vegdahl's
/// constants ("Building a Better LK Hash", 2021).
fn scramble(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// The second coordinate of point `index`, its bits reversed. (The first is `index` itself.) Its
/// matrix is Pascal's triangle modulo 2, a product of five shifts (Ahmed, "An Implementation Algorithm of
/// 2D Sobol Sequence Fast, Elegant, and Compact", 2024).
fn second(index: u32) -> u32 {
    let mut x = index;
    x ^= x >> 16;
    x ^= (x & 0xff00_ff00) >> 8;
    x ^= (x & 0xf0f0_f0f0) >> 4;
    x ^= (x & 0xcccc_cccc) >> 2;
    x ^ ((x & 0xaaaa_aaaa) >> 1)
}

/// The third and the fourth coordinate of point `index`, their bits reversed.
fn third_and_fourth(index: u32) -> (u32, u32) {
    let mut digits = index;
    let mut both = 0;
    for table in &THIRD_AND_FOURTH {
        both ^= table[(digits & 15) as usize];
        digits >>= 4;
    }
    (both as u32, (both >> 32) as u32)
}

/// For each four bits of an index what they add to the third coordinate (low half) and to the fourth.
static THIRD_AND_FOURTH: [[u64; 16]; 8] = {
    let third = directions([1, 3, 0], 2);
    let fourth = directions([1, 3, 1], 3);
    let mut tables = [[0; 16]; 8];
    let mut bit = 0;
    while bit < 32 {
        let both = (fourth[bit].reverse_bits() as u64) << 32 | third[bit].reverse_bits() as u64;
        let mut digits = 0;
        while digits < 16 {
            if digits >> (bit % 4) & 1 == 1 {
                tables[bit / 4][digits] ^= both;
            }
            digits += 1;
        }
        bit += 1;
    }
    tables
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
            let (third, fourth) = third_and_fourth(i);
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
