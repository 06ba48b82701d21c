//! The only place where the program enters code that computes in SIMD lanes. On x86-64, that code is compiled for wider
//! registers than the rest of the program.
#![cfg_attr(lanes = "x86", allow(unsafe_code))]

#[cfg(lanes = "neon")]
use super::aarch64::{F32x4, F64x2};
#[cfg(lanes = "x86")]
use super::avx2::{F32x8, F64x4};
#[cfg(any(lanes_512, all(test, lanes = "x86")))]
use super::avx512::{F32x16, F64x8};
use super::level;
#[cfg(lanes = "simd128")]
use super::wasm::{F32x4, F64x2};
use crate::real::Vectorized;

#[inline]
pub(crate) fn f64_lanes<V: Vectorized<f64>>(work: V) -> V::Output {
    match level() {
        #[cfg(any(lanes_512, all(test, lanes = "x86")))]
        // SAFETY: `level` checked that the processor has the instructions.
        level::Level::Avx512 => unsafe { f64_avx512(work) },
        #[cfg(lanes = "x86")]
        // SAFETY: `level` checked that the processor has the instructions.
        level::Level::Avx2 => unsafe { f64_avx2(work) },
        #[cfg(any(lanes = "neon", lanes = "simd128"))]
        level::Level::Neon | level::Level::Simd128 => work.run::<F64x2>(),
        _ => work.run::<f64>(),
    }
}

#[inline]
pub(crate) fn f32_lanes<V: Vectorized<f32>>(work: V) -> V::Output {
    match level() {
        #[cfg(any(lanes_512, all(test, lanes = "x86")))]
        // SAFETY: `level` checked that the processor has the instructions.
        level::Level::Avx512 => unsafe { f32_avx512(work) },
        #[cfg(lanes = "x86")]
        // SAFETY: `level` checked that the processor has the instructions.
        level::Level::Avx2 => unsafe { f32_avx2(work) },
        #[cfg(any(lanes = "neon", lanes = "simd128"))]
        level::Level::Neon | level::Level::Simd128 => work.run::<F32x4>(),
        _ => work.run::<f32>(),
    }
}

#[cfg(any(lanes_512, all(test, lanes = "x86")))]
#[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
pub(super) fn f64_avx512<V: Vectorized<f64>>(work: V) -> V::Output {
    work.run::<F64x8>()
}
#[cfg(lanes = "x86")]
#[target_feature(enable = "avx2,fma")]
pub(super) fn f64_avx2<V: Vectorized<f64>>(work: V) -> V::Output {
    work.run::<F64x4>()
}
#[cfg(any(lanes_512, all(test, lanes = "x86")))]
#[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
pub(super) fn f32_avx512<V: Vectorized<f32>>(work: V) -> V::Output {
    work.run::<F32x16>()
}
#[cfg(lanes = "x86")]
#[target_feature(enable = "avx2,fma")]
pub(super) fn f32_avx2<V: Vectorized<f32>>(work: V) -> V::Output {
    work.run::<F32x8>()
}
