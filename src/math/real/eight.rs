//! Eight lanes, on the vectors of `fearless_simd`.

use std::array;
use std::convert::identity;
use std::fmt::Debug;

use fearless_simd::{Bytes, ExtractToken, Select, SimdBase, SimdFloat, SimdInt, SimdMask, i32x8};
use fearless_simd::{Simd, f32x8, f64x8, mask32x8, mask64x8, u32x8};

use super::{Double, Float, Lanes, Level, Lift, Mask, Real, Uint};

/// What a vector does as eight lanes.
macro_rules! eight_lanes {
    ($($vector:ident of $lane:ty, $mask:expr;)*) => {$(
        impl<S: Simd> Lanes for $vector<S> {
            type Lane = $lane;
            type Mask = mask32x8<S>;
            type Token = S;
            type Each<T: Copy + Debug> = [T; 8];

            const LANES: usize = 8;

            #[inline(always)]
            fn each<T: Copy + Debug>(of: impl FnMut(usize) -> T) -> [T; 8] {
                array::from_fn(of)
            }

            #[inline(always)]
            fn token(self) -> S {
                self.simd
            }

            #[inline(always)]
            fn splat(token: S, value: $lane) -> Self {
                SimdBase::splat(token, value)
            }

            #[inline(always)]
            fn from_fn(token: S, value: impl FnMut(usize) -> $lane) -> Self {
                SimdBase::from_fn(token, value)
            }

            #[inline(always)]
            fn lane(self, i: usize) -> $lane {
                self.as_slice()[i]
            }

            #[inline(always)]
            fn load(token: S, values: &[$lane]) -> Self {
                SimdBase::from_slice(token, values)
            }

            #[inline(always)]
            fn store(self, values: &mut [$lane]) {
                self.store_slice(values);
            }

            #[inline(always)]
            fn compress(self, mask: mask32x8<S>) -> Self {
                SimdBase::compress(self, $mask(mask))
            }

            #[inline(always)]
            fn select(mask: mask32x8<S>, yes: impl Lift<Self>, no: impl Lift<Self>) -> Self {
                let token = Mask::token(mask);
                Select::select($mask(mask), yes.lift(token), no.lift(token))
            }
        }

        impl<S: Simd> Lift<Self> for $vector<S> {
            #[inline(always)]
            fn lift(self, _: S) -> Self {
                self
            }
        }
    )*};
}

eight_lanes! {
    f32x8 of f32, identity;
    u32x8 of u32, identity;
    f64x8 of f64, widen;
}

/// The mask of lanes twice as wide.
#[inline(always)]
fn widen<S: Simd>(mask: mask32x8<S>) -> mask64x8<S> {
    let simd = Mask::token(mask);
    let (low, high) = simd.widen_mask32x8(mask);
    simd.combine_mask64x4(low, high)
}

/// The mask of lanes half as wide.
#[inline(always)]
fn narrow<S: Simd>(mask: mask64x8<S>) -> mask32x8<S> {
    let simd = ExtractToken::token(&mask);
    let (low, high) = simd.split_mask64x8(mask);
    simd.narrow_mask64x4(low, high)
}

impl<S: Simd> Mask for mask32x8<S> {
    type Token = S;

    #[inline(always)]
    fn token(self) -> S {
        ExtractToken::token(&self)
    }

    #[inline(always)]
    fn from_bits(token: S, bits: u32) -> Self {
        SimdMask::from_bitmask(token, u64::from(bits & 0xff))
    }

    #[inline(always)]
    fn bits(self) -> u32 {
        self.to_bitmask() as u32
    }

    #[inline(always)]
    fn all(self) -> bool {
        self.all_true()
    }
}

/// What both kinds of reals do as eight lanes.
macro_rules! eight_floats {
    ($($vector:ident, $mask:expr;)*) => {$(
        impl<S: Simd> Float for $vector<S> {
            #[inline(always)]
            fn lt(self, other: impl Lift<Self>) -> mask32x8<S> {
                $mask(self.simd_lt(other.lift(self.simd)))
            }

            #[inline(always)]
            fn le(self, other: impl Lift<Self>) -> mask32x8<S> {
                $mask(self.simd_le(other.lift(self.simd)))
            }

            #[inline(always)]
            fn eq(self, other: impl Lift<Self>) -> mask32x8<S> {
                $mask(self.simd_eq(other.lift(self.simd)))
            }

            #[inline(always)]
            fn abs(self) -> Self {
                SimdBase::abs(self)
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                SimdFloat::sqrt(self)
            }
        }
    )*};
}

eight_floats! {
    f32x8, identity;
    f64x8, narrow;
}

impl<S: Simd> Double for f64x8<S> {
    type Real = f32x8<S>;

    #[inline(always)]
    fn narrow(self) -> f32x8<S> {
        let (low, high) = self.simd.split_f64x8(self);
        self.simd.narrow_f64x4(low, high)
    }
}

impl<S: Simd> Real for f32x8<S> {
    type Uint = u32x8<S>;
    type Double = f64x8<S>;

    #[inline(always)]
    fn level(token: S) -> Level {
        Level::of(token)
    }

    #[inline(always)]
    fn vectorize<T>(token: S, work: impl FnOnce() -> T) -> T {
        token.vectorize(work)
    }

    #[inline(always)]
    fn widen(self) -> f64x8<S> {
        let (low, high) = self.simd.widen_f32x8(self);
        self.simd.combine_f64x4(low, high)
    }

    /// On x86 the instruction itself is defined like this; others treat NaN and zeros in ways of their own.
    #[inline(always)]
    fn min(self, other: impl Lift<Self>) -> Self {
        let other = other.lift(self.simd);
        if cfg!(any(target_arch = "x86", target_arch = "x86_64")) {
            SimdBase::min(self, other)
        } else {
            Self::select(self.lt(other), self, other)
        }
    }

    /// As [`Real::min`].
    #[inline(always)]
    fn max(self, other: impl Lift<Self>) -> Self {
        let other = other.lift(self.simd);
        if cfg!(any(target_arch = "x86", target_arch = "x86_64")) {
            SimdBase::max(self, other)
        } else {
            Self::select(other.lt(self), self, other)
        }
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        SimdFloat::copysign(self, sign)
    }

    #[inline(always)]
    fn floor(self) -> Self {
        SimdFloat::floor(self)
    }

    #[inline(always)]
    fn to_bits(self) -> u32x8<S> {
        self.bitcast()
    }

    #[inline(always)]
    fn from_bits(bits: u32x8<S>) -> Self {
        bits.bitcast()
    }
}

impl<S: Simd> Uint for u32x8<S> {
    type Real = f32x8<S>;

    #[inline(always)]
    fn wrapping_add(self, other: impl Lift<Self>) -> Self {
        self + other.lift(self.simd)
    }

    #[inline(always)]
    fn wrapping_sub(self, other: impl Lift<Self>) -> Self {
        self - other.lift(self.simd)
    }

    #[inline(always)]
    fn wrapping_mul(self, other: impl Lift<Self>) -> Self {
        self * other.lift(self.simd)
    }

    #[inline(always)]
    fn eq(self, other: impl Lift<Self>) -> mask32x8<S> {
        self.simd_eq(other.lift(self.simd))
    }

    #[inline(always)]
    fn to_real(self) -> f32x8<S> {
        self.bitcast::<i32x8<S>>().to_float()
    }
}
