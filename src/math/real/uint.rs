//! Whole numbers in lanes.

use std::ops::{BitAnd, BitOr, BitXor, Not, Shl, Shr};

use super::{Lanes, Lift, Real};

/// A whole number of 32 bits in each lane, as hashes and samplers need it; `u32` is one lane. Shifts are by
/// less than 32.
pub trait Uint:
    Lanes<Lane = u32>
    + Lift<Self>
    + Not<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
    + BitAnd<u32, Output = Self>
    + BitOr<u32, Output = Self>
    + BitXor<u32, Output = Self>
    + Shl<u32, Output = Self>
    + Shr<u32, Output = Self>
{
    /// Reals in as many lanes.
    type Real: Real<Uint = Self, Mask = Self::Mask, Token = Self::Token>;

    /// The sum modulo 2³².
    fn wrapping_add(self, other: impl Lift<Self>) -> Self;
    /// The difference modulo 2³².
    fn wrapping_sub(self, other: impl Lift<Self>) -> Self;
    /// The product modulo 2³².
    fn wrapping_mul(self, other: impl Lift<Self>) -> Self;
    /// Whether the numbers are the same.
    fn eq(self, other: impl Lift<Self>) -> Self::Mask;
    /// The nearest real to the number as two's complement: from 2³¹ on, the number less 2³².
    fn to_real(self) -> Self::Real;

    /// The bits moved up by `bits` from 1 to 31, those that leave at the top come in at the bottom.
    #[inline(always)]
    fn rotate_left(self, bits: u32) -> Self {
        (self << bits) | (self >> (32 - bits))
    }

    /// The highest bit first.
    #[inline(always)]
    fn reverse_bits(self) -> Self {
        let x = ((self >> 1) & 0x5555_5555) | ((self & 0x5555_5555) << 1);
        let x = ((x >> 2) & 0x3333_3333) | ((x & 0x3333_3333) << 2);
        let x = ((x >> 4) & 0x0f0f_0f0f) | ((x & 0x0f0f_0f0f) << 4);
        let x = ((x >> 8) & 0x00ff_00ff) | ((x & 0x00ff_00ff) << 8);
        x.rotate_left(16)
    }

    /// A real in [0, 1), evenly spaced: the upper 24 bits over 2²⁴.
    #[inline(always)]
    fn to_unit(self) -> Self::Real {
        (self >> 8).to_real() * (1.0 / 16_777_216.0)
    }
}
