//! SIMD lanes as a [`Real`]: many evaluations at once, in the widest registers that the
//! processor has, chosen at run time. Nothing has to be set at compile time.

#[cfg(target_arch = "x86_64")]
mod x86;

use crate::real::Real;

/// The most lanes that any type has.
pub(crate) const WIDEST: usize = 16;

/// A number type that holds `N` scalars of type `S`, one a lane.
pub trait Lane<S>: Real {
    /// How many scalars.
    const N: usize;
    /// The same scalar in every lane.
    fn splat(value: S) -> Self;
    /// The first `N` scalars of a slice.
    fn load(from: &[S]) -> Self;
    /// Writes the lanes to the first `N` places of a slice.
    fn store(self, to: &mut [S]);
}

/// Every number is a lane of itself.
impl<R: Real> Lane<R> for R {
    const N: usize = 1;
    #[inline(always)]
    fn splat(value: R) -> R {
        value
    }
    #[inline(always)]
    fn load(from: &[R]) -> R {
        from[0]
    }
    #[inline(always)]
    fn store(self, to: &mut [R]) {
        to[0] = self;
    }
}

/// Work that is written for any lane width; see [`Real::vectorize`].
pub trait Vectorized<S: Real> {
    /// What the work returns.
    type Output;
    /// Does the work in lanes of type `L`. Implementations are `#[inline(always)]`, all the way
    /// down: only then does the code take on the instruction set it was entered with.
    fn run<L: Lane<S>>(self) -> Self::Output;
}

/// The registers in use on this machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// What every processor of the target has; scalar code.
    Baseline,
    /// 256-bit registers and fused multiply-add.
    Avx2,
    /// 512-bit registers.
    Avx512,
}

/// The widest level that this machine has.
#[inline]
pub fn level() -> Level {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
            return Level::Avx512;
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            return Level::Avx2;
        }
    }
    Level::Baseline
}

#[cfg(target_arch = "x86_64")]
pub(crate) use enter::{f32_lanes, f64_lanes};

#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn f64_lanes<V: Vectorized<f64>>(work: V) -> V::Output {
    work.run::<f64>()
}

#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn f32_lanes<V: Vectorized<f32>>(work: V) -> V::Output {
    work.run::<f32>()
}

/// The one door into code compiled for wider registers.
#[cfg(target_arch = "x86_64")]
mod enter {
    #![allow(unsafe_code)] // `cargo bench --bench rollout`: what makes the lanes' speed safe.

    use super::x86::{F32x8, F32x16, F64x4, F64x8};
    use super::{Level, Vectorized, level};

    #[inline]
    pub(crate) fn f64_lanes<V: Vectorized<f64>>(work: V) -> V::Output {
        match level() {
            // SAFETY: the level says that the processor has the instructions.
            Level::Avx512 => unsafe { f64_avx512(work) },
            Level::Avx2 => unsafe { f64_avx2(work) },
            Level::Baseline => work.run::<f64>(),
        }
    }

    #[inline]
    pub(crate) fn f32_lanes<V: Vectorized<f32>>(work: V) -> V::Output {
        match level() {
            // SAFETY: as above.
            Level::Avx512 => unsafe { f32_avx512(work) },
            Level::Avx2 => unsafe { f32_avx2(work) },
            Level::Baseline => work.run::<f32>(),
        }
    }

    #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
    fn f64_avx512<V: Vectorized<f64>>(work: V) -> V::Output {
        work.run::<F64x8>()
    }
    #[target_feature(enable = "avx2,fma")]
    fn f64_avx2<V: Vectorized<f64>>(work: V) -> V::Output {
        work.run::<F64x4>()
    }
    #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
    fn f32_avx512<V: Vectorized<f32>>(work: V) -> V::Output {
        work.run::<F32x16>()
    }
    #[target_feature(enable = "avx2,fma")]
    fn f32_avx2<V: Vectorized<f32>>(work: V) -> V::Output {
        work.run::<F32x8>()
    }
}
