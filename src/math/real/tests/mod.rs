//! The same bits in one lane and in eight, at every level that the machine has.

use fearless_simd::Level as Detected;

use super::*;
use crate::sampler::{Independent, PathSampler};

mod functions;
mod geometry;

/// Does a task at all levels, also at those that [`Level`] passes over; with a word for each.
fn at_every_level<T: Task + Copy>(task: T) -> Vec<(&'static str, T::Output)> {
    let mut outputs =
        vec![("baseline", Level::baseline().run(task)), ("best", Level::detect().run(task))];
    #[cfg(target_arch = "x86_64")]
    {
        let level = Detected::new();
        outputs.extend(level.as_sse4_2().map(|s| ("SSE4.2", s.vectorize(|| task.run(s)))));
        outputs.extend(level.as_avx512().map(|s| ("AVX-512", s.vectorize(|| task.run(s)))));
    }
    outputs
}

/// What the operations make of `a` and `b`, as bits; of NaN always the same ones.
macro_rules! operations {
    (|$a:ident, $b:ident| reals { $($real:expr),* } conditions { $($mask:expr),* } bits { $($bits:expr),* }) => {
        const NAMES: &[&str] =
            &[$(stringify!($real),)* $(stringify!($mask),)* $(stringify!($bits)),*];

        #[inline(always)]
        fn results<R: Real>($a: R, $b: R) -> [R::Uint; NAMES.len()] {
            let real = |x: R| R::select(x.eq(x), x, f32::NAN).to_bits();
            let mask = |x: R::Mask| R::Uint::select(x, 1, 0);
            [$(real($real),)* $(mask($mask),)* $($bits),*]
        }
    };
}

operations! {
    |a, b|
    reals {
        -a, a + b, a - b, a * b, a / b, a * b + a, a + 1.5, a - 1.5, a * 1.5, a / 1.5,
        { let mut c = a; c += b; c *= a; c -= b; c /= b; c += 0.1; c },
        a.abs(), a.sqrt(), a.floor(), a.copysign(b), a.recip(), a.one_minus(),
        a.min(b), a.max(b), a.min(0.0), a.max(0.0), a.clamp(b, 1.0), a.clamp(-0.0, 1.0),
        R::select(a.lt(b), a, 0.5), R::select(a.lt(b) ^ b.lt(0.0), b, a),
        a.to_bits().to_real(), a.to_bits().to_unit(),
        a.sin(), a.cos(), a.exp(), a.ln(), a.atan2(b), (a * 1e-3).sin_cos().1
    }
    conditions {
        a.lt(b), a.le(b), a.gt(b), a.ge(b), a.eq(b), !a.eq(b), a.is_sign_negative(),
        a.lt(b) & a.lt(0.0), a.lt(b) | a.lt(0.0), a.to_bits().eq(b.to_bits()), a.to_bits().eq(0)
    }
    bits {
        a.to_bits().wrapping_add(b.to_bits()), a.to_bits().wrapping_add(0x9e37_79b9),
        a.to_bits().wrapping_sub(b.to_bits()), a.to_bits().wrapping_mul(b.to_bits()),
        a.to_bits().wrapping_mul(0x3d20_adea), a.to_bits() & b.to_bits(), a.to_bits() | b.to_bits(),
        a.to_bits() ^ b.to_bits(), !a.to_bits(), a.to_bits() & 0xff00_ff00, a.to_bits() | 1,
        a.to_bits() ^ 0x0552_6c56, a.to_bits() << 7, a.to_bits() >> 31, a.to_bits().rotate_left(1),
        a.to_bits().rotate_left(31), a.to_bits().reverse_bits()
    }
}

/// Numbers that are special in one way or another.
const SPECIAL: [f32; 24] = [
    0.0,
    -0.0,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    1e-45,
    -1e-45,
    1e-39,
    f32::MAX,
    f32::MIN,
    1.0,
    -1.0,
    0.5,
    -0.5,
    1.5,
    -2.5,
    8_388_607.5,
    -8_388_607.5,
    2_147_483_648.0,
    1.0 - f32::EPSILON / 2.0,
    std::f32::consts::PI,
    8192.0,
];

/// Pairs of special numbers, of any bits, and of numbers as they occur.
fn pairs() -> Vec<[f32; 2]> {
    let mut pairs: Vec<_> = SPECIAL.iter().flat_map(|&a| SPECIAL.map(|b| [a, b])).collect();
    let sampler = Independent::new(1);
    for i in 0..50_000 {
        let mut u = PathSampler::new(&sampler, i, 0);
        let mut any = || {
            f32::from_bits(
                (u.next_1d() * 65_536.0) as u32 * 65_536 + (u.next_1d() * 65_536.0) as u32,
            )
        };
        pairs.push([any(), any()]);
        pairs.push([4.0 * u.next_1d() - 2.0, 4.0 * u.next_1d() - 2.0]);
    }
    pairs
}

/// The results of eight pairs at a time, by pair.
#[derive(Clone, Copy)]
struct Eight<'a>(&'a [[f32; 2]]);

impl Task for Eight<'_> {
    type Output = Vec<[u32; NAMES.len()]>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let eight = |pairs: &[[f32; 2]]| {
            let side = |side: usize| f32x8::from_fn(simd, |i| pairs[i][side]);
            let results = results(side(0), side(1));
            [0, 1, 2, 3, 4, 5, 6, 7].map(|i| results.map(|result| result.lane(i)))
        };
        self.0.chunks_exact(8).flat_map(eight).collect()
    }
}

#[test]
fn eight_lanes_have_the_bits_of_one() {
    let pairs = pairs();
    let expected: Vec<_> = pairs.iter().map(|&[a, b]| results(a, b)).collect();
    for (level, found) in at_every_level(Eight(&pairs)) {
        assert_eq!(found.len(), pairs.len() / 8 * 8);
        for ((pair, expected), found) in pairs.iter().zip(&expected).zip(&found) {
            for (name, (expected, found)) in NAMES.iter().zip(expected.iter().zip(found)) {
                assert_eq!(found, expected, "{level}: {name} of {pair:?}");
            }
        }
    }
}

/// Were `a * b + a` fused anywhere, the numbers of the test above would show it: with one rounding in the place of
/// two, a third of them give other bits.
#[test]
fn a_fused_operation_would_be_caught() {
    let pairs = pairs();
    let differ = pairs.iter().filter(|[a, b]| {
        let (fused, rounded) = (a.mul_add(*b, *a), a * b + a);
        fused != rounded && !fused.is_nan()
    });
    assert!(differ.count() > pairs.len() / 10);
}

#[test]
fn a_special_lane_leaves_its_neighbours_alone() {
    let ordinary: [_; 8] = std::array::from_fn(|i| [0.3 + i as f32, 1.7 - i as f32]);
    let expected = ordinary.map(|[a, b]| results(a, b));
    for special in SPECIAL {
        for lane in 0..8 {
            let mut pairs = ordinary;
            pairs[lane] = [special, special];
            for (level, found) in at_every_level(Eight(&pairs)) {
                for i in (0..8).filter(|&i| i != lane) {
                    assert_eq!(
                        found[i], expected[i],
                        "{level}: {special} in lane {lane}, lane {i}"
                    );
                }
            }
        }
    }
}

/// What goes in comes out, and masks count their lanes.
#[derive(Clone, Copy)]
struct Loads;

impl Task for Loads {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let numbers = [1.0, -2.0, 3.0, -0.0, 5.0, f32::INFINITY, 7.0, 8.0];
        let x = f32x8::load(simd, &numbers);
        let mut stored = [0.0; 8];
        x.store(&mut stored);
        assert_eq!((stored, x.lane(5)), (numbers, f32::INFINITY));
        assert_eq!(f32x8::splat(simd, 2.0).lane(7), 2.0);
        assert_eq!(u32x8::from_fn(simd, |i| 1 << i).lane(7), 128);
        let negative = x.is_sign_negative();
        assert_eq!((negative.bits(), negative.count(), x.lt(0.0).bits()), (0b1010, 2, 0b10));
        assert!(negative.lane(3) && !negative.lane(4) && negative.any() && !negative.all());
        assert!(!x.lt(-3.0).any() && x.le(f32::INFINITY).all());
        for bits in 0..256 {
            assert_eq!(mask32x8::from_bits(simd, bits | 0xf00).bits(), bits);
        }
        assert_eq!(f32x8::vectorize(simd, || x.lane(0)), 1.0);
    }
}

#[test]
fn lanes_are_loaded_stored_and_counted() {
    at_every_level(Loads);
    assert_eq!((f32::load((), &[3.0]), 3.0.lane(0), bool::from_bits((), 3).bits()), (3.0, 3.0, 1));
    assert!(std::panic::catch_unwind(|| f32::load((), &[1.0, 2.0])).is_err());
    assert!(std::panic::catch_unwind(|| 1.0.lane(1)).is_err());
}

#[test]
fn whole_numbers_become_reals() {
    for (bits, real, unit) in [
        (0, 0.0, 0.0),
        (0x100, 256.0, 1.0 / 16_777_216.0),
        (0x8000_0000, -2_147_483_648.0, 0.5),
        (u32::MAX, -1.0, 1.0 - f32::EPSILON / 2.0),
    ] {
        assert_eq!((bits.to_real(), bits.to_unit()), (real, unit));
    }
    // The trait's own, and not that of `u32`.
    for bits in [1, 0x8000_0000, 0x1234_5678, 0xdead_beef] {
        assert_eq!(Uint::reverse_bits(bits), bits.reverse_bits());
        assert_eq!(Uint::rotate_left(bits, 5), bits.rotate_left(5));
    }
}

/// What some lane needs is asked for, and nothing else.
#[test]
fn either_asks_for_what_is_needed() {
    struct Either(u32);

    impl Task for Either {
        type Output = ([f32; 8], [bool; 2]);

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            let mut asked = [false; 2];
            let [yes, no] = &mut asked;
            let number = mask32x8::<S>::from_bits(simd, self.0).either(
                || {
                    *yes = true;
                    f32x8::splat(simd, 1.0)
                },
                || {
                    *no = true;
                    f32x8::splat(simd, 0.0)
                },
            );
            let mut lanes = [0.0; 8];
            Lanes::store(number, &mut lanes);
            (lanes, asked)
        }
    }

    for bits in 0..256 {
        for level in [Level::baseline(), Level::detect()] {
            let (lanes, asked) = level.run(Either(bits));
            assert_eq!(lanes, std::array::from_fn(|i| (bits >> i & 1) as f32), "{bits:#b}");
            assert_eq!(asked, [bits != 0, bits != 255], "{bits:#b}");
        }
    }
}
