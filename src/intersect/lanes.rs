//! Eight numbers at a time, without `unsafe` and with the same bits on every machine.
//!
//! Each operation is that of IEEE 754 on each lane, and none is fused with another, so both
//! implementations give the same results. Which one runs is decided once, from the processor.

/// Numbers in a vector: children of a node, triangles of a leaf.
pub(super) const LANES: usize = 8;

/// Eight numbers in memory, aligned to one load.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub(super) struct F32x8(pub(super) [f32; LANES]);

/// Eight whole numbers in memory, aligned to one load.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(32))]
pub(super) struct U32x8(pub(super) [u32; LANES]);

/// Operations on eight numbers.
pub(super) trait Lanes: Copy {
    /// Eight numbers in a register.
    type Vector: Copy;
    fn load(self, numbers: &F32x8) -> Self::Vector;
    fn store(self, v: Self::Vector) -> F32x8;
    fn splat(self, number: f32) -> Self::Vector;
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn abs(self, a: Self::Vector) -> Self::Vector;
    /// `a < b ? a : b` in each lane: `b` where either is NaN.
    fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a > b ? a : b` in each lane: `b` where either is NaN.
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Bit i: `a[i] <= b[i]`, false where either is NaN.
    fn le(self, a: Self::Vector, b: Self::Vector) -> u32;
    /// Bit i: `a[i] < b[i]`, false where either is NaN.
    fn lt(self, a: Self::Vector, b: Self::Vector) -> u32;
    /// Bit i: the highest bit of number i.
    fn high_bits(self, numbers: &U32x8) -> u32;
}

/// A piece of work that is compiled once for each kind of processor.
pub(super) trait Task {
    type Output;
    /// To be inlined always, or it is compiled for the wrong processor.
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// What the processor has.
#[derive(Clone, Copy, Debug)]
pub(super) enum Simd {
    /// Vectors of 256 bits.
    #[cfg(target_arch = "x86_64")]
    Avx2(pulp::x86::V3),
    /// What the target that this crate is compiled for guarantees.
    Portable,
}

impl Simd {
    pub(super) fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(token) = pulp::x86::V3::try_new() {
            return Self::Avx2(token);
        }
        Self::Portable
    }

    #[inline(always)]
    pub(super) fn run<T: Task>(self, task: T) -> T::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(token) => token.vectorize(avx2::WithToken(token, task)),
            Self::Portable => task.run(Portable),
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::{__m256, _CMP_LE_OQ, _CMP_LT_OQ};

    use pulp::NullaryFnOnce;
    use pulp::x86::V3;

    use super::{F32x8, LANES, Lanes, Task, U32x8};

    /// A task with the proof that the processor has AVX2.
    pub(super) struct WithToken<T>(pub(super) V3, pub(super) T);

    impl<T: Task> NullaryFnOnce for WithToken<T> {
        type Output = T::Output;

        #[inline(always)]
        fn call(self) -> T::Output {
            self.1.run(self.0)
        }
    }

    impl Lanes for V3 {
        type Vector = __m256;

        #[inline(always)]
        fn load(self, numbers: &F32x8) -> __m256 {
            pulp::cast::<[f32; LANES], __m256>(numbers.0)
        }

        #[inline(always)]
        fn store(self, v: __m256) -> F32x8 {
            F32x8(pulp::cast(v))
        }

        #[inline(always)]
        fn splat(self, number: f32) -> __m256 {
            self.avx._mm256_set1_ps(number)
        }

        #[inline(always)]
        fn add(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_add_ps(a, b)
        }

        #[inline(always)]
        fn sub(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_sub_ps(a, b)
        }

        #[inline(always)]
        fn mul(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_mul_ps(a, b)
        }

        #[inline(always)]
        fn abs(self, a: __m256) -> __m256 {
            self.avx._mm256_andnot_ps(self.splat(-0.0), a)
        }

        #[inline(always)]
        fn min(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_min_ps(a, b)
        }

        #[inline(always)]
        fn max(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_max_ps(a, b)
        }

        #[inline(always)]
        fn le(self, a: __m256, b: __m256) -> u32 {
            let le = self.avx._mm256_cmp_ps::<_CMP_LE_OQ>(a, b);
            self.avx._mm256_movemask_ps(le) as u32
        }

        #[inline(always)]
        fn lt(self, a: __m256, b: __m256) -> u32 {
            let lt = self.avx._mm256_cmp_ps::<_CMP_LT_OQ>(a, b);
            self.avx._mm256_movemask_ps(lt) as u32
        }

        #[inline(always)]
        fn high_bits(self, numbers: &U32x8) -> u32 {
            self.avx._mm256_movemask_ps(pulp::cast(numbers.0)) as u32
        }
    }
}

/// Plain Rust, which the compiler turns into whatever vectors the target has.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portable;

#[inline(always)]
fn zip(a: F32x8, b: F32x8, f: impl Fn(f32, f32) -> f32) -> F32x8 {
    F32x8(std::array::from_fn(|i| f(a.0[i], b.0[i])))
}

#[inline(always)]
fn mask(a: F32x8, b: F32x8, f: impl Fn(f32, f32) -> bool) -> u32 {
    (0..LANES).fold(0, |mask, i| mask | u32::from(f(a.0[i], b.0[i])) << i)
}

impl Lanes for Portable {
    type Vector = F32x8;

    #[inline(always)]
    fn load(self, numbers: &F32x8) -> F32x8 {
        *numbers
    }

    #[inline(always)]
    fn store(self, v: F32x8) -> F32x8 {
        v
    }

    #[inline(always)]
    fn splat(self, number: f32) -> F32x8 {
        F32x8([number; LANES])
    }

    #[inline(always)]
    fn add(self, a: F32x8, b: F32x8) -> F32x8 {
        zip(a, b, |a, b| a + b)
    }

    #[inline(always)]
    fn sub(self, a: F32x8, b: F32x8) -> F32x8 {
        zip(a, b, |a, b| a - b)
    }

    #[inline(always)]
    fn mul(self, a: F32x8, b: F32x8) -> F32x8 {
        zip(a, b, |a, b| a * b)
    }

    #[inline(always)]
    fn abs(self, a: F32x8) -> F32x8 {
        F32x8(a.0.map(f32::abs))
    }

    #[inline(always)]
    fn min(self, a: F32x8, b: F32x8) -> F32x8 {
        zip(a, b, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn max(self, a: F32x8, b: F32x8) -> F32x8 {
        zip(a, b, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn le(self, a: F32x8, b: F32x8) -> u32 {
        mask(a, b, |a, b| a <= b)
    }

    #[inline(always)]
    fn lt(self, a: F32x8, b: F32x8) -> u32 {
        mask(a, b, |a, b| a < b)
    }

    #[inline(always)]
    fn high_bits(self, numbers: &U32x8) -> u32 {
        (0..LANES).fold(0, |mask, i| mask | (numbers.0[i] >> 31) << i)
    }
}
