//! What numbers, whole numbers and conditions in lanes have in common.

use std::fmt::Debug;
use std::ops::{BitAnd, BitAndAssign, BitOr, BitOrAssign, BitXor, Not};

/// A value in each lane.
pub trait Lanes: Copy + Debug + 'static {
    /// What one lane holds.
    type Lane: Copy + Debug + Default;
    /// A condition in each lane.
    type Mask: Mask<Token = Self::Token>;
    /// The proof that the processor has the instructions in use; every value carries it and it takes no room.
    type Token: Copy;
    /// Anything for each lane, as an array.
    type Each<T: Copy + Debug>: Copy + Debug + AsRef<[T]> + AsMut<[T]>;

    /// How many there are.
    const LANES: usize;

    /// What `of` says of each lane.
    fn each<T: Copy + Debug>(of: impl FnMut(usize) -> T) -> Self::Each<T>;

    /// The proof that the value carries.
    fn token(self) -> Self::Token;
    /// The same in each lane.
    fn splat(token: Self::Token, value: Self::Lane) -> Self;
    /// What `value` says of each lane.
    fn from_fn(token: Self::Token, value: impl FnMut(usize) -> Self::Lane) -> Self;
    /// What lane `i` holds.
    ///
    /// # Panics
    /// There is no such lane.
    fn lane(self, i: usize) -> Self::Lane;
    /// What lies in memory.
    ///
    /// # Panics
    /// `values` are not as many as lanes.
    fn load(token: Self::Token, values: &[Self::Lane]) -> Self;
    /// Into memory.
    ///
    /// # Panics
    /// `values` are not as many as lanes.
    fn store(self, values: &mut [Self::Lane]);
    /// The lanes that are set first, in their order; what the others hold is not said.
    fn compress(self, mask: Self::Mask) -> Self;

    /// The mask of the lanes of which `is_set` says so.
    #[inline(always)]
    fn mask(token: Self::Token, is_set: impl Fn(usize) -> bool) -> Self::Mask {
        let bits = (0..Self::LANES).fold(0, |bits, i| bits | u32::from(is_set(i)) << i);
        Self::Mask::from_bits(token, bits)
    }

    /// `yes` in lanes where the mask is set, `no` elsewhere.
    fn select(mask: Self::Mask, yes: impl Lift<Self>, no: impl Lift<Self>) -> Self;
}

/// What can stand for a value in each lane: the value itself, or a constant for all.
pub trait Lift<T: Lanes> {
    /// The value in each lane.
    fn lift(self, token: T::Token) -> T;
}

impl<T: Lanes<Lane = f32>> Lift<T> for f32 {
    #[inline(always)]
    fn lift(self, token: T::Token) -> T {
        T::splat(token, self)
    }
}

impl<T: Lanes<Lane = f64>> Lift<T> for f64 {
    #[inline(always)]
    fn lift(self, token: T::Token) -> T {
        T::splat(token, self)
    }
}

impl<T: Lanes<Lane = u32>> Lift<T> for u32 {
    #[inline(always)]
    fn lift(self, token: T::Token) -> T {
        T::splat(token, self)
    }
}

/// What can be put together from lanes of two.
pub trait Select: Sized {
    /// The condition in each lane.
    type Mask: Mask;

    /// `yes` in lanes where the mask is set, `no` elsewhere.
    fn selected(mask: Self::Mask, yes: Self, no: Self) -> Self;
}

impl<T: Lanes + Lift<T>> Select for T {
    type Mask = T::Mask;

    #[inline(always)]
    fn selected(mask: T::Mask, yes: Self, no: Self) -> Self {
        Self::select(mask, yes, no)
    }
}

impl<A: Select, B: Select<Mask = A::Mask>> Select for (A, B) {
    type Mask = A::Mask;

    #[inline(always)]
    fn selected(mask: A::Mask, yes: Self, no: Self) -> Self {
        (A::selected(mask, yes.0, no.0), B::selected(mask, yes.1, no.1))
    }
}

/// A condition in each lane; `bool` is one lane. `!`, `&`, `|` and `^` combine two.
pub trait Mask:
    Copy
    + Debug
    + 'static
    + Not<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
    + BitAndAssign
    + BitOrAssign
{
    /// See [`Lanes::Token`].
    type Token: Copy;

    /// The same in each lane.
    #[inline(always)]
    fn splat(token: Self::Token, set: bool) -> Self {
        Self::from_bits(token, if set { u32::MAX } else { 0 })
    }

    /// The proof that the mask carries.
    fn token(self) -> Self::Token;
    /// Lane i is set where bit i is; higher bits mean nothing.
    fn from_bits(token: Self::Token, bits: u32) -> Self;
    /// Bit i: whether lane i is set.
    fn bits(self) -> u32;
    /// Whether all lanes are set.
    fn all(self) -> bool;

    /// What `yes` says in lanes where the mask is set, what `no` says elsewhere.
    #[inline(always)]
    fn select(self, yes: Self, no: Self) -> Self {
        (self & yes) | (!self & no)
    }

    /// Whether any lane is set.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }

    /// What `yes` finds in lanes where the mask is set and `no` elsewhere. What no lane needs is not looked for.
    #[inline(always)]
    fn either<T: Select<Mask = Self>>(self, yes: impl FnOnce() -> T, no: impl FnOnce() -> T) -> T {
        // Each is called in one place, so that it is compiled once; not by `bool::then`, into which it is inlined, and which
        // is then too long to be inlined itself.
        let yes = if self.any() { Some(yes()) } else { None };
        let no = if self.all() { None } else { Some(no()) };
        match (yes, no) {
            (Some(yes), Some(no)) => T::selected(self, yes, no),
            (Some(all), None) | (None, Some(all)) => all,
            (None, None) => unreachable!("there are lanes"),
        }
    }

    /// How many lanes are set.
    #[inline(always)]
    fn count(self) -> u32 {
        self.bits().count_ones()
    }

    /// Whether lane `i` is set.
    #[inline(always)]
    fn lane(self, i: usize) -> bool {
        self.bits() >> i & 1 != 0
    }
}
