//! The only place where the program enters code that computes in SIMD lanes. On x86-64, that code is compiled for wider
//! registers than the rest of the program.
#![cfg_attr(lanes = "x86", allow(unsafe_code))]

#[cfg(lanes = "neon")]
use super::aarch64 as narrow;
#[cfg(lanes = "x86")]
use super::avx2;
#[cfg(any(lanes_512, all(test, lanes = "x86")))]
use super::avx512;
use super::level;
#[cfg(lanes = "simd128")]
use super::wasm as narrow;
use crate::real::{Real, Vectorized};

/// See [`Real::KERNELS_NEED_LANES`]. The other targets either always have lanes or never. Miri has none, and checks the
/// code of kernels on scalars.
pub(crate) const F64_NEEDS_LANES: bool = cfg!(all(lanes = "x86", not(miri)));
/// Test builds, which have optimisation level 1, have no lanes of `f32`, because every kernel would be compiled for them.
pub(crate) const F32_NEEDS_LANES: bool = cfg!(all(lanes = "x86", lanes_f32, not(miri)));

#[inline]
pub(crate) fn f64_lanes<V: Vectorized<f64>>(work: V) -> V::Output {
    match level() {
        #[cfg(any(lanes_512, all(test, lanes = "x86")))]
        // SAFETY: `level` checked that the processor has the instructions.
        level::Level::Avx512 if const { V::HAS_512 } => unsafe { f64_avx512(work) },
        #[cfg(lanes = "x86")]
        // SAFETY: `level` checked that the processor has the instructions.
        level::Level::Avx2 | level::Level::Avx512 => unsafe { f64_avx2(work) },
        #[cfg(any(lanes = "neon", lanes = "simd128"))]
        level::Level::Neon | level::Level::Simd128 => f64_narrow(work),
        _ => scalars(work),
    }
}

#[inline]
pub(crate) fn f32_lanes<V: Vectorized<f32>>(work: V) -> V::Output {
    match level() {
        #[cfg(any(all(lanes_512, lanes_f32), all(test, lanes = "x86")))]
        // SAFETY: `level` checked that the processor has the instructions.
        level::Level::Avx512 if const { V::HAS_512 } => unsafe { f32_avx512(work) },
        #[cfg(all(lanes = "x86", any(lanes_f32, test)))]
        // SAFETY: `level` checked that the processor has the instructions.
        level::Level::Avx2 | level::Level::Avx512 => unsafe { f32_avx2(work) },
        #[cfg(all(any(lanes = "neon", lanes = "simd128"), any(lanes_f32, test)))]
        level::Level::Neon | level::Level::Simd128 => f32_narrow(work),
        _ => scalars(work),
    }
}

/// Does the work without lanes.
#[inline]
fn scalars<S: Real, V: Vectorized<S>>(work: V) -> V::Output {
    if const { S::KERNELS_NEED_LANES && !V::HAS_SCALARS } {
        unreachable!("a kernel was compiled for wider registers than this thread may use");
    }
    work.run::<S>()
}

#[cfg(any(lanes_512, all(test, lanes = "x86")))]
#[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
pub(super) fn f64_avx512<V: Vectorized<f64>>(work: V) -> V::Output {
    work.run::<avx512::F64x8>()
}
#[cfg(lanes = "x86")]
#[target_feature(enable = "avx2,fma")]
pub(super) fn f64_avx2<V: Vectorized<f64>>(work: V) -> V::Output {
    work.run::<avx2::F64x4>()
}
#[cfg(any(all(lanes_512, lanes_f32), all(test, lanes = "x86")))]
#[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
pub(super) fn f32_avx512<V: Vectorized<f32>>(work: V) -> V::Output {
    work.run::<avx512::F32x16>()
}
#[cfg(all(lanes = "x86", any(lanes_f32, test)))]
#[target_feature(enable = "avx2,fma")]
pub(super) fn f32_avx2<V: Vectorized<f32>>(work: V) -> V::Output {
    work.run::<avx2::F32x8>()
}

// These functions are not inlined, as those for wider registers are not. A replay enters lanes at many places, and would contain
// a copy of all its longer functions at each of them.
#[cfg(any(lanes = "neon", lanes = "simd128"))]
#[inline(never)]
fn f64_narrow<V: Vectorized<f64>>(work: V) -> V::Output {
    work.run::<narrow::F64x2>()
}
#[cfg(all(any(lanes = "neon", lanes = "simd128"), any(lanes_f32, test)))]
#[inline(never)]
fn f32_narrow<V: Vectorized<f32>>(work: V) -> V::Output {
    work.run::<narrow::F32x4>()
}
