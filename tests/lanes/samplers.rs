//! Random numbers.

use std::array;

use telamon::math::real::{Lanes, Level, Mask, Simd, Task, f32x8, f64x8, u32x8};
use telamon::sampler::{Independent, PathKeys, PathSampler, PathSamplers, Sampler, Sobol};

/// A number each, a pair, a choice and a pair again, of which lanes take what `used` says.
#[derive(Clone, Copy)]
struct Draw<'a> {
    sampler: &'a dyn Sampler,
    keys: [PathKeys<u32>; 8],
    used: [u32; 4],
}

type Numbers = [([f32; 5], [f64; 2], u32); 8];

impl Task for Draw<'_> {
    type Output = Numbers;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Numbers {
        let keys = PathKeys {
            high: u32x8::from_fn(simd, |i| self.keys[i].high),
            low: u32x8::from_fn(simd, |i| self.keys[i].low),
        };
        let used = self.used.map(|bits| Mask::from_bits(simd, bits));
        let mut numbers = PathSamplers::<f32x8<S>>::new(self.sampler, keys, Lanes::splat(simd, 0));
        let one = numbers.next_1d(used[0]);
        let two = numbers.next_2d(used[1]);
        let choice = numbers.next_choice(used[2]);
        let last = numbers.next_2d(used[3]);
        array::from_fn(|i| {
            let [a, b, c, d] = [two.x, two.y, last.x, last.y].map(|x| x.lane(i));
            let choice: [f64x8<S>; 2] = choice.to_array();
            ([one.lane(i), a, b, c, d], choice.map(|x| x.lane(i)), numbers.dimension.lane(i))
        })
    }
}

#[test]
fn numbers_have_one_form() {
    let samplers: [&dyn Sampler; 2] = [&Independent::new(3), &Sobol::new(3)];
    for sampler in samplers {
        for turn in 0..200u32 {
            let used = [0b1011_0110, 0xff, 0b0101_1100, 0xff]
                .map(|bits: u32| bits.rotate_left(turn) | (bits >> (turn % 8)));
            let path = |lane: u32| PathSampler::new(sampler, turn * 77, 8 * turn + lane);
            let keys = array::from_fn(|lane| path(lane as u32).parts().1);
            for level in [Level::baseline(), Level::detect()] {
                let drawn = level.run(Draw { sampler, keys, used });
                for (lane, (numbers, choice, dimension)) in drawn.into_iter().enumerate() {
                    let mut alone = path(lane as u32);
                    // What is not used is the next number again.
                    let mut next = |turn: usize, dimensions: u32| {
                        let (.., before) = alone.parts();
                        let numbers = match dimensions {
                            1 => vec![f64::from(alone.next_1d())],
                            2 => alone.next_2d().as_dvec2().to_array().to_vec(),
                            _ => alone.next_choice().to_array().to_vec(),
                        };
                        if used[turn] >> lane & 1 == 0 {
                            alone.go_to(before);
                        }
                        numbers
                    };
                    let expected = [next(0, 1), next(1, 2), next(2, 3), next(3, 2)].concat();
                    let [one, a, b, c, d] = numbers.map(f64::from);
                    let [x, y] = choice;
                    assert_eq!([one, a, b, x, y, c, d][..], expected, "{sampler:?} {level:?}");
                    assert_eq!(dimension, alone.parts().2);
                }
            }
        }
    }
}
