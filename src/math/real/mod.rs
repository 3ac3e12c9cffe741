//! Real numbers in lanes.
//!
//! [`Real`] is a real number in each lane: `f32` is one lane, [`f32x8`] is eight. What is written once over it
//! runs for one path and for eight, with the same bits in each lane, on every processor: all operations are
//! those of IEEE 754, none is fused with another, and functions such as [`Real::sin`] are polynomials of our
//! own and not the system's. The bits of NaN are the exception: one NaN is as good as another.
//!
//! ```
//! use telamon::math::real::Real;
//!
//! /// The reflectance of a smooth conductor after Schlick.
//! #[inline(always)]
//! fn schlick<R: Real>(f0: R, cos_theta: R) -> R {
//!     let x = cos_theta.clamp(0.0, 1.0).one_minus();
//!     let x2 = x * x;
//!     f0 + f0.one_minus() * (x2 * x2 * x)
//! }
//! assert_eq!(schlick(0.5, 0.0), 1.0);
//! ```
//!
//! Two rules:
//! - Code over lanes is `#[inline(always)]` up to the [`Task`] that [`Level::run`] starts. What is not, is
//!   compiled for the baseline whatever the processor has, which costs two to seven times the time without
//!   a word. `.ci/check-inlining` looks for it.
//! - A condition is a [`Mask`] and takes effect by `select`; both sides are computed, so neither may panic. A
//!   lane that holds NaN or infinity does not touch its neighbours.
//!
//! Left out because processors disagree: minimum and maximum of NaN (ours are a comparison and a choice),
//! conversions of what is out of range, approximate reciprocals, fused multiplication and addition, and shifts
//! by 32 or more.

use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

pub use fearless_simd::{Simd, f32x8, f64x8, mask32x8, u32x8};

mod columns;
mod eight;
mod functions;
mod lanes;
mod level;
mod one;
mod rows;
#[cfg(test)]
mod tests;
mod uint;

pub use columns::{Column, Columns};
pub(in crate::math) use functions::{polynomial, sin_cos_octant};
pub use lanes::{Lanes, Lift, Mask, Select};
pub use level::{Level, Task};
pub use rows::Rows;
pub use uint::Uint;

/// The four operations, also with assignment.
pub trait Arithmetic<Rhs = Self>:
    Sized
    + Add<Rhs, Output = Self>
    + Sub<Rhs, Output = Self>
    + Mul<Rhs, Output = Self>
    + Div<Rhs, Output = Self>
    + AddAssign<Rhs>
    + SubAssign<Rhs>
    + MulAssign<Rhs>
    + DivAssign<Rhs>
{
}

impl<T, Rhs> Arithmetic<Rhs> for T where
    T: Add<Rhs, Output = T>
        + Sub<Rhs, Output = T>
        + Mul<Rhs, Output = T>
        + Div<Rhs, Output = T>
        + AddAssign<Rhs>
        + SubAssign<Rhs>
        + MulAssign<Rhs>
        + DivAssign<Rhs>
{
}

/// What real numbers of both precisions have in common.
pub trait Float:
    Lanes + Lift<Self> + Neg<Output = Self> + Arithmetic + Arithmetic<Self::Lane>
{
    /// Whether `self < other`; false where either is NaN.
    fn lt(self, other: impl Lift<Self>) -> Self::Mask;
    /// Whether `self <= other`; false where either is NaN.
    fn le(self, other: impl Lift<Self>) -> Self::Mask;
    /// Whether `self == other`; false where either is NaN.
    fn eq(self, other: impl Lift<Self>) -> Self::Mask;
    /// Without the sign.
    fn abs(self) -> Self;
    /// The square root, rounded once; NaN of what is below zero.
    fn sqrt(self) -> Self;

    /// Whether `self > other`; false where either is NaN.
    #[inline(always)]
    fn gt(self, other: impl Lift<Self>) -> Self::Mask {
        other.lift(self.token()).lt(self)
    }

    /// Whether `self >= other`; false where either is NaN.
    #[inline(always)]
    fn ge(self, other: impl Lift<Self>) -> Self::Mask {
        other.lift(self.token()).le(self)
    }
}

/// A real number of twice the precision in each lane, for positions; `f64` is one lane. In eight lanes, it costs twice
/// what [`Real`] does.
pub trait Double: Float<Lane = f64> {
    /// Reals in as many lanes.
    type Real: Real<Double = Self, Mask = Self::Mask, Token = Self::Token>;

    /// The nearest real.
    fn narrow(self) -> Self::Real;

    /// `1 / x`.
    #[inline(always)]
    fn recip(self) -> Self {
        Self::splat(self.token(), 1.0) / self
    }
}

/// A real number in each lane. A constant may stand on the right of an operator and in the place of any
/// argument: `x * 2.0`, `x.max(0.0)`.
pub trait Real: Float<Lane = f32> {
    /// Whole numbers in as many lanes, for hashes and bits.
    type Uint: Uint<Real = Self, Mask = Self::Mask, Token = Self::Token>;
    /// Reals of twice the precision in as many lanes.
    type Double: Double<Real = Self, Mask = Self::Mask, Token = Self::Token>;

    /// The level that the token stands for.
    fn level(token: Self::Token) -> Level;

    /// Runs `work` compiled for the instructions that the token stands for, however far that is from where
    /// the level was chosen: behind a trait object, or where a function is too long to be inlined everywhere.
    fn vectorize<T>(token: Self::Token, work: impl FnOnce() -> T) -> T;

    /// The same number in twice the precision.
    fn widen(self) -> Self::Double;

    /// `self < other ? self : other`: `other` where either is NaN, and of two zeros.
    fn min(self, other: impl Lift<Self>) -> Self;
    /// `self > other ? self : other`: `other` where either is NaN, and of two zeros.
    fn max(self, other: impl Lift<Self>) -> Self;

    /// With the sign of `sign`, be it of a zero.
    fn copysign(self, sign: Self) -> Self;
    /// The largest whole number that is not above.
    fn floor(self) -> Self;

    /// The bits of each number.
    fn to_bits(self) -> Self::Uint;
    /// The number of each lane's bits.
    fn from_bits(bits: Self::Uint) -> Self;

    /// Whether the sign bit is set, be it of a zero.
    #[inline(always)]
    fn is_sign_negative(self) -> Self::Mask {
        (self.to_bits() >> 31).eq(1)
    }

    /// `low` where the number is below it, `high` where it is above that; NaN stays.
    #[inline(always)]
    fn clamp(self, low: impl Lift<Self>, high: impl Lift<Self>) -> Self {
        let (low, high) = (low.lift(self.token()), high.lift(self.token()));
        high.min(low.max(self))
    }

    /// `1 / x`.
    #[inline(always)]
    fn recip(self) -> Self {
        Self::splat(self.token(), 1.0) / self
    }

    /// `1 - x`.
    #[inline(always)]
    fn one_minus(self) -> Self {
        Self::splat(self.token(), 1.0) - self
    }

    /// Sine and cosine of an angle in radians. NaN beyond ±8192.
    ///
    /// Within 1.6 ulp for angles up to 2π; beyond, within 2⁻²³ of the true value.
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        functions::sin_cos(self)
    }

    /// The sine: see [`Real::sin_cos`].
    #[inline(always)]
    fn sin(self) -> Self {
        self.sin_cos().0
    }

    /// The cosine: see [`Real::sin_cos`].
    #[inline(always)]
    fn cos(self) -> Self {
        self.sin_cos().1
    }

    /// e to the power of x, within 1 ulp everywhere.
    #[inline(always)]
    fn exp(self) -> Self {
        functions::exp(self)
    }

    /// The natural logarithm, within 1 ulp everywhere: −∞ of zeros, NaN of what is below.
    #[inline(always)]
    fn ln(self) -> Self {
        functions::ln(self)
    }

    /// The angle of the point `(x, self)` from the x axis in [−π, π], within 1.6 ulp, with the values of IEEE 754
    /// for zeros and infinities.
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        functions::atan2(self, x)
    }
}
