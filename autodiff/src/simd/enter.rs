//! The only entry into code compiled for wider registers.
// `cargo bench -p benches --bench tapes` measures what it saves.
#![allow(unsafe_code)]

use super::level::{Level, level};
use super::x86::{F32x8, F32x16, F64x4, F64x8};
use crate::real::Vectorized;

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
pub(super) fn f64_avx512<V: Vectorized<f64>>(work: V) -> V::Output {
    work.run::<F64x8>()
}
#[target_feature(enable = "avx2,fma")]
pub(super) fn f64_avx2<V: Vectorized<f64>>(work: V) -> V::Output {
    work.run::<F64x4>()
}
#[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
pub(super) fn f32_avx512<V: Vectorized<f32>>(work: V) -> V::Output {
    work.run::<F32x16>()
}
#[target_feature(enable = "avx2,fma")]
pub(super) fn f32_avx2<V: Vectorized<f32>>(work: V) -> V::Output {
    work.run::<F32x8>()
}
