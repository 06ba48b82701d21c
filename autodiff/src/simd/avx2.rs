//! The 256-bit registers of x86-64 (AVX2 with FMA) as lanes, for f64 and f32.
//!
//! `define.rs` says why the instructions may be used.
#![allow(unsafe_code)]

use std::arch::x86_64::*;
use std::ops::{BitAnd, BitOr, Not};

use num_traits::Zero;

use crate::elementary::Elementary;
use crate::math::{self, Primitive, tanh_abreast};
use crate::operators::operators;
use crate::real::{Lane, Mask, Real};

/// A mask: in each lane, all bits are set or none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneMask<M>(M);

/// Returns a mask of four lanes: all bits set in the first `n` lanes, none in the others.
#[inline(always)]
fn first_i64(n: usize) -> __m256i {
    const ONES: [i64; 8] = [-1, -1, -1, -1, 0, 0, 0, 0];
    // The window of four numbers that begins with `n` ones.
    let window: &[i64; 4] = ONES[4 - n..8 - n]
        .try_into()
        .expect("the slice has the length of the array");
    // SAFETY: only lanes call this function, and the reference is as long as a register.
    unsafe { _mm256_loadu_si256(window.as_ptr().cast()) }
}

/// Returns a mask of eight lanes: all bits set in the first `n` lanes, none in the others.
#[inline(always)]
fn first_i32(n: usize) -> __m256i {
    const ONES: [i32; 16] = [-1, -1, -1, -1, -1, -1, -1, -1, 0, 0, 0, 0, 0, 0, 0, 0];
    let window: &[i32; 8] = ONES[8 - n..16 - n]
        .try_into()
        .expect("the slice has the length of the array");
    // SAFETY: only lanes call this function, and the reference is as long as a register.
    unsafe { _mm256_loadu_si256(window.as_ptr().cast()) }
}

define_lanes!(
    F64x4: [f64; 4] in __m256d, mask LaneMask<__m256d>,
    _mm256_set1_pd _mm256_loadu_pd _mm256_storeu_pd
    _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd _mm256_sqrt_pd,
    fma _mm256_fmadd_pd, with one rounding _mm256_fmadd_pd, tanh tanh_abreast,
    part |from: &[f64]| _mm256_maskload_pd(from.as_ptr(), first_i64(from.len())),
    |to: &mut [f64], a| _mm256_maskstore_pd(to.as_mut_ptr(), first_i64(to.len()), a),
    |a, b| LaneMask(_mm256_cmp_pd::<_CMP_LT_OQ>(a, b)),
    |a, b| LaneMask(_mm256_cmp_pd::<_CMP_LE_OQ>(a, b)),
    |mask: LaneMask<__m256d>, a, b| _mm256_blendv_pd(b, a, mask.0),
    |a, b| _mm256_and_pd(_mm256_cmp_pd::<_CMP_NEQ_UQ>(a, _mm256_setzero_pd()), b),
    |partial, cotangent, term| {
        let mask = _mm256_cmp_pd::<_CMP_NEQ_UQ>(cotangent, _mm256_setzero_pd());
        _mm256_blendv_pd(term, _mm256_fmadd_pd(partial, cotangent, term), mask)
    },
    |shifted| {
        let biased = _mm256_add_epi64(_mm256_castpd_si256(shifted), _mm256_set1_epi64x(1023));
        _mm256_castsi256_pd(_mm256_slli_epi64::<52>(biased))
    },
    |a| _mm256_andnot_pd(_mm256_set1_pd(-0.0), a),
    |size, sign| _mm256_or_pd(size, _mm256_and_pd(_mm256_set1_pd(-0.0), sign)),
    |a: Self, b: Self| LaneMask(_mm256_and_pd(a.0, b.0)),
    |a: Self, b: Self| LaneMask(_mm256_or_pd(a.0, b.0)),
    |a: Self| LaneMask(_mm256_xor_pd(a.0, _mm256_castsi256_pd(_mm256_set1_epi64x(-1)))),
    |a: Self| _mm256_movemask_pd(a.0),
    |bits| {
        let lane = _mm256_set_epi64x(8, 4, 2, 1);
        let set = _mm256_and_si256(_mm256_set1_epi64x(i64::from(bits)), lane);
        LaneMask(_mm256_castsi256_pd(_mm256_cmpeq_epi64(set, lane)))
    },
    |a, b| {
        let [low, high] = [_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b)];
        [_mm256_permute2f128_pd::<0x20>(low, high), _mm256_permute2f128_pd::<0x31>(low, high)]
    }
);

define_lanes!(
    F32x8: [f32; 8] in __m256, mask LaneMask<__m256>,
    _mm256_set1_ps _mm256_loadu_ps _mm256_storeu_ps
    _mm256_add_ps _mm256_sub_ps _mm256_mul_ps _mm256_div_ps _mm256_sqrt_ps,
    fma _mm256_fmadd_ps, with one rounding _mm256_fmadd_ps, tanh tanh_abreast,
    part |from: &[f32]| _mm256_maskload_ps(from.as_ptr(), first_i32(from.len())),
    |to: &mut [f32], a| _mm256_maskstore_ps(to.as_mut_ptr(), first_i32(to.len()), a),
    |a, b| LaneMask(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b)),
    |a, b| LaneMask(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)),
    |mask: LaneMask<__m256>, a, b| _mm256_blendv_ps(b, a, mask.0),
    |a, b| _mm256_and_ps(_mm256_cmp_ps::<_CMP_NEQ_UQ>(a, _mm256_setzero_ps()), b),
    |partial, cotangent, term| {
        let mask = _mm256_cmp_ps::<_CMP_NEQ_UQ>(cotangent, _mm256_setzero_ps());
        _mm256_blendv_ps(term, _mm256_fmadd_ps(partial, cotangent, term), mask)
    },
    |shifted| {
        let biased = _mm256_add_epi32(_mm256_castps_si256(shifted), _mm256_set1_epi32(127));
        _mm256_castsi256_ps(_mm256_slli_epi32::<23>(biased))
    },
    |a| _mm256_andnot_ps(_mm256_set1_ps(-0.0), a),
    |size, sign| _mm256_or_ps(size, _mm256_and_ps(_mm256_set1_ps(-0.0), sign)),
    |a: Self, b: Self| LaneMask(_mm256_and_ps(a.0, b.0)),
    |a: Self, b: Self| LaneMask(_mm256_or_ps(a.0, b.0)),
    |a: Self| LaneMask(_mm256_xor_ps(a.0, _mm256_castsi256_ps(_mm256_set1_epi32(-1)))),
    |a: Self| _mm256_movemask_ps(a.0),
    |bits| {
        let lane = _mm256_set_epi32(128, 64, 32, 16, 8, 4, 2, 1);
        let set = _mm256_and_si256(_mm256_set1_epi32(i32::from(bits)), lane);
        LaneMask(_mm256_castsi256_ps(_mm256_cmpeq_epi32(set, lane)))
    },
    |a, b| {
        let [low, high] = [_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b)];
        [_mm256_permute2f128_ps::<0x20>(low, high), _mm256_permute2f128_ps::<0x31>(low, high)]
    }
);
