//! One lane: plain `f32`, `f64`, `u32` and `bool`.

use std::array;
use std::fmt::Debug;

use super::{Double, Float, Lanes, Level, Lift, Mask, Real, Uint};

/// What a plain number of Rust does as one lane.
macro_rules! one_lane {
    ($($lane:ty),*) => {$(
        impl Lanes for $lane {
            type Lane = Self;
            type Mask = bool;
            type Token = ();
            type Each<T: Copy + Debug> = [T; 1];

            const LANES: usize = 1;

            #[inline(always)]
            fn each<T: Copy + Debug>(of: impl FnMut(usize) -> T) -> [T; 1] {
                array::from_fn(of)
            }

            #[inline(always)]
            fn token(self) {}

            #[inline(always)]
            fn splat((): (), value: Self) -> Self {
                value
            }

            #[inline(always)]
            fn from_fn((): (), mut value: impl FnMut(usize) -> Self) -> Self {
                value(0)
            }

            #[inline(always)]
            fn lane(self, i: usize) -> Self {
                [self][i]
            }

            #[inline(always)]
            fn load((): (), values: &[Self]) -> Self {
                let [value] = values else { panic!("one lane, {} values", values.len()) };
                *value
            }

            #[inline(always)]
            fn store(self, values: &mut [Self]) {
                values.copy_from_slice(&[self]);
            }

            #[inline(always)]
            fn compress(self, _: bool) -> Self {
                self
            }

            #[inline(always)]
            fn select(mask: bool, yes: impl Lift<Self>, no: impl Lift<Self>) -> Self {
                let (yes, no) = (yes.lift(()), no.lift(()));
                if mask { yes } else { no }
            }
        }
    )*};
}

one_lane!(f32, f64, u32);

impl Mask for bool {
    type Token = ();

    #[inline(always)]
    fn token(self) {}

    #[inline(always)]
    fn from_bits((): (), bits: u32) -> Self {
        bits & 1 != 0
    }

    #[inline(always)]
    fn bits(self) -> u32 {
        self.into()
    }

    #[inline(always)]
    fn all(self) -> bool {
        self
    }
}

/// What both kinds of reals do as one lane.
macro_rules! one_float {
    ($($float:ty),*) => {$(
        impl Float for $float {
            #[inline(always)]
            fn lt(self, other: impl Lift<Self>) -> bool {
                self < other.lift(())
            }

            #[inline(always)]
            fn le(self, other: impl Lift<Self>) -> bool {
                self <= other.lift(())
            }

            #[inline(always)]
            fn eq(self, other: impl Lift<Self>) -> bool {
                self == other.lift(())
            }

            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
        }
    )*};
}

one_float!(f32, f64);

impl Double for f64 {
    type Real = f32;

    #[inline(always)]
    fn narrow(self) -> f32 {
        self as f32
    }
}

impl Real for f32 {
    type Uint = u32;
    type Double = f64;

    #[inline(always)]
    fn level((): ()) -> Level {
        Level::baseline()
    }

    #[inline(always)]
    fn vectorize<T>((): (), work: impl FnOnce() -> T) -> T {
        work()
    }

    #[inline(always)]
    fn widen(self) -> f64 {
        self.into()
    }

    #[inline(always)]
    fn min(self, other: impl Lift<Self>) -> Self {
        let other = other.lift(());
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn max(self, other: impl Lift<Self>) -> Self {
        let other = other.lift(());
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        self.copysign(sign)
    }

    #[inline(always)]
    fn floor(self) -> Self {
        self.floor()
    }

    #[inline(always)]
    fn to_bits(self) -> u32 {
        self.to_bits()
    }

    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self::from_bits(bits)
    }
}

impl Uint for u32 {
    type Real = f32;

    #[inline(always)]
    fn wrapping_add(self, other: impl Lift<Self>) -> Self {
        self.wrapping_add(other.lift(()))
    }

    #[inline(always)]
    fn wrapping_sub(self, other: impl Lift<Self>) -> Self {
        self.wrapping_sub(other.lift(()))
    }

    #[inline(always)]
    fn wrapping_mul(self, other: impl Lift<Self>) -> Self {
        self.wrapping_mul(other.lift(()))
    }

    #[inline(always)]
    fn eq(self, other: impl Lift<Self>) -> bool {
        self == other.lift(())
    }

    #[inline(always)]
    fn to_real(self) -> f32 {
        self.cast_signed() as f32
    }
}
