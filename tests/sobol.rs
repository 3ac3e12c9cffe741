//! Sobol's points fill the cube evenly, and integrals show it.

use telamon::sampler::{Independent, Sampler, Sobol};

/// Points of a pixel, from `first` on, in the block of four dimensions that begins at `dimension`.
fn points(sampler: &dyn Sampler, pixel: u32, samples: std::ops::Range<u32>) -> Vec<[f32; 4]> {
    let point = |sample| {
        let path = sampler.path(pixel, sample);
        let (a, b) = (sampler.get_2d(path, 4), sampler.get_2d(path, 6));
        [a.x, a.y, b.x, b.y]
    };
    samples.map(point).collect()
}

/// Whether all boxes of volume 2^−`digits` whose sides are powers of 2 (elementary intervals) hold the
/// same number of points.
fn evenly_spread<const D: usize>(points: &[[f32; D]], digits: u32) -> bool {
    let each = points.len() >> digits;
    shapes::<D>(digits).into_iter().all(|shape| {
        let mut counts = vec![0; 1 << digits];
        for point in points {
            let cell = point.iter().zip(shape).fold(0, |cell, (x, digits)| {
                (cell << digits) | (x * (1_u32 << digits) as f32) as usize
            });
            counts[cell] += 1;
        }
        counts.iter().all(|&count| count == each)
    })
}

/// All ways to share `digits` among D axes.
fn shapes<const D: usize>(digits: u32) -> Vec<[u32; D]> {
    let all = (0..(digits + 1).pow(D as u32)).map(|mut code| {
        std::array::from_fn(|_| {
            let digit = code % (digits + 1);
            code /= digits + 1;
            digit
        })
    });
    all.filter(|shape: &[u32; D]| shape.iter().sum::<u32>() == digits).collect()
}

/// Runs of 2^k samples that begin at a multiple of 2^k.
fn runs() -> impl Iterator<Item = (u32, u32, std::ops::Range<u32>)> {
    (0..10_u32).flat_map(|k| {
        [(0, 0), (1, 3), (77, 1), (262_143, 12)].map(|(pixel, run)| {
            let first = run << k;
            (k, pixel, first..first + (1 << k))
        })
    })
}

/// The first two dimensions of a block are (0, m, 2)-nets in base 2, and so are pairs beyond blocks.
#[test]
fn pairs_are_nets() {
    for (k, pixel, run) in runs() {
        let sampler = Sobol::new(u64::from(k));
        let first = points(&sampler, pixel, run.clone()).into_iter().map(|[x, y, ..]| [x, y]);
        assert!(evenly_spread(&first.collect::<Vec<_>>(), k), "{run:?} of pixel {pixel}");
        let odd = run.clone().map(|i| sampler.get_2d(sampler.path(pixel, i), 9).to_array());
        assert!(evenly_spread(&odd.collect::<Vec<_>>(), k), "{run:?} of pixel {pixel}, odd");
    }
}

/// Sobol's first four dimensions are a (3, 4)-sequence: the degrees of their polynomials, less 1 each, make
/// 0 + 0 + 1 + 2 (Niederreiter 1992, theorem 4.49).
#[test]
fn blocks_are_nets() {
    for (k, pixel, run) in runs().filter(|(k, ..)| *k >= 3) {
        let points = points(&Sobol::new(9), pixel, run.clone());
        assert!(evenly_spread(&points, k - 3), "{run:?} of pixel {pixel}");
    }
}

#[test]
fn single_numbers_are_stratified() {
    let sampler = Sobol::new(3);
    for (k, pixel, run) in runs() {
        for dimension in [0, 1, 4, 1_000_001] {
            let number = |i| [sampler.get_1d(sampler.path(pixel, i), dimension)];
            let numbers: Vec<_> = run.clone().map(number).collect();
            assert!(evenly_spread(&numbers, k), "{run:?} of pixel {pixel}, {dimension}");
        }
    }
}

/// Points that are not spread evenly do not pass: independent ones, runs that begin anywhere, and two
/// dimensions of different blocks.
#[test]
fn other_points_are_no_nets() {
    let pairs = |points: Vec<[f32; 4]>| points.into_iter().map(|[x, y, ..]| [x, y]).collect();
    let independent: Vec<_> = pairs(points(&Independent::new(1), 0, 0..64));
    assert!(!evenly_spread(&independent, 6));
    let begun_late: Vec<_> = pairs(points(&Sobol::new(1), 0, 5..69));
    assert!(!evenly_spread(&begun_late, 6));
    let sampler = Sobol::new(1);
    let padded = (0..64).map(|i| {
        let path = sampler.path(0, i);
        [sampler.get_2d(path, 0).x, sampler.get_2d(path, 4).x]
    });
    assert!(!evenly_spread(&padded.collect::<Vec<_>>(), 6));
}

/// The slope of the error over the number of samples, in logarithms, for ∏(1 + (x − ½)) over a block: from
/// the root of the mean squared error of 512 pixels at 16 and at 1,024 samples.
fn slope(sampler: &dyn Sampler) -> f64 {
    let error = |count: u32| {
        let squares = (0..512).map(|pixel| {
            let values = points(sampler, pixel, 0..count).into_iter();
            let sum: f64 =
                values.map(|p| p.iter().map(|&x| 0.5 + f64::from(x)).product::<f64>()).sum();
            (sum / f64::from(count) - 1.0).powi(2)
        });
        (squares.sum::<f64>() / 512.0).sqrt()
    };
    (error(1024) / error(16)).ln() / 64_f64.ln()
}

/// A root mean square of 512 has a relative standard error near 1/√1024, so a slope has one of
/// √2/32/ln 64 = 0.011. Chance makes −1/2; scrambled nets make −3/2 but for a power of log n (Owen
/// 1997), which with four dimensions at these counts is worth less than 1/4.
#[test]
fn errors_fall_faster_than_by_chance() {
    let (by_chance, sobol) = (slope(&Independent::new(5)), slope(&Sobol::new(5)));
    assert!((by_chance + 0.5).abs() < 3.0 * 0.011, "{by_chance}");
    assert!(sobol < -1.25, "{sobol}");
}
