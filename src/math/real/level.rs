//! Which instructions wide code is compiled for, decided once for a piece of work.

use fearless_simd::{Level as Detected, Simd};

/// A piece of work over lanes, compiled once for each level.
pub trait Task {
    /// What comes out.
    type Output;

    /// Does the work with the instructions that `simd` stands for; the token of `f32x8<S>` and its like.
    ///
    /// `#[inline(always)]`, as is everything over lanes that it calls.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// What the processor has. There are two compiled forms of everything, so two levels: what lies between them
/// runs the lower, and AVX-512 the higher one, since eight lanes in its registers are no faster.
#[derive(Clone, Copy, Debug)]
pub struct Level(Form);

#[derive(Clone, Copy, Debug)]
enum Form {
    #[cfg(target_arch = "x86_64")]
    Avx2(fearless_simd::x86::Avx2),
    #[cfg(target_arch = "x86_64")]
    Sse2(fearless_simd::x86::Sse2),
    /// Of other processors: what every one of their kind has.
    #[cfg(not(target_arch = "x86_64"))]
    Baseline,
}

impl Level {
    /// The best level that this processor has.
    #[must_use]
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = Detected::new().as_avx2() {
            return Self(Form::Avx2(avx2));
        }
        Self::baseline()
    }

    /// The level that every processor of the target has: SSE2 on x86-64, NEON on AArch64.
    #[must_use]
    pub fn baseline() -> Self {
        #[cfg(target_arch = "x86_64")]
        return Self(Form::Sse2(Detected::baseline().as_sse2().expect("SSE2 is part of x86-64")));
        #[cfg(not(target_arch = "x86_64"))]
        Self(Form::Baseline)
    }

    /// The level that a token stands for.
    #[inline(always)]
    pub(super) fn of<S: Simd>(token: S) -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = token.level().as_avx2() {
            return Self(Form::Avx2(avx2));
        }
        #[cfg(target_arch = "x86_64")]
        return Self(Form::Sse2(token.level().as_sse2().expect("SSE2 is part of x86-64")));
        #[cfg(not(target_arch = "x86_64"))]
        {
            let _ = token;
            Self(Form::Baseline)
        }
    }

    /// Does a piece of work at this level.
    #[inline(always)]
    pub fn run<T: Task>(self, task: T) -> T::Output {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            Form::Avx2(simd) => simd.vectorize(
                #[inline(always)]
                || task.run(simd),
            ),
            #[cfg(target_arch = "x86_64")]
            Form::Sse2(simd) => task.run(simd),
            #[cfg(not(target_arch = "x86_64"))]
            Form::Baseline => {
                fearless_simd::dispatch!(Detected::baseline(), simd => task.run(simd))
            }
        }
    }
}
