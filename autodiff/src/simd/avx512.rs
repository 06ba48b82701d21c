//! The 512-bit registers of x86-64 (AVX-512) as lanes, for f64 and f32.
//!
//! `define.rs` says why the instructions may be used. Builds below optimisation level 2 leave these registers out,
//! because they are a third of the code of every kernel. The crate's own unit tests have them at every level.
#![allow(unsafe_code)]
// Masks are integers here. But the macro wraps their operations in `unsafe`, which other instruction sets need.
#![allow(unused_unsafe)]

use std::arch::x86_64::*;
use std::ops::{BitAnd, BitOr, Not};

use num_traits::Zero;

use crate::elementary::Elementary;
use crate::math::{self, Primitive, tanh_abreast};
use crate::operators::operators;
use crate::real::{Lane, Mask, Real};

/// A mask with one bit for each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BitMask<M>(M);

/// Returns mask bits that select the first `n` lanes.
#[inline(always)]
fn first_bits(n: usize) -> u16 {
    !(u16::MAX << n)
}

define_lanes!(
    F64x8: [f64; 8] in __m512d, mask BitMask<__mmask8>,
    _mm512_set1_pd _mm512_loadu_pd _mm512_storeu_pd
    _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd _mm512_sqrt_pd,
    fma _mm512_fmadd_pd, with one rounding _mm512_fmadd_pd, tanh tanh_abreast,
    part |from: &[f64]| _mm512_maskz_loadu_pd(first_bits(from.len()) as __mmask8, from.as_ptr()),
    |to: &mut [f64], a| _mm512_mask_storeu_pd(to.as_mut_ptr(), first_bits(to.len()) as __mmask8, a),
    |a, b| BitMask(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b)),
    |a, b| BitMask(_mm512_cmp_pd_mask::<_CMP_LE_OQ>(a, b)),
    |mask: BitMask<u8>, a, b| _mm512_mask_blend_pd(mask.0, b, a),
    |a, b| {
        // Tests the bits below the sign. Unlike a comparison, this is evaluated at compile time for constants.
        let bits = _mm512_set1_epi64(i64::MAX);
        _mm512_maskz_mov_pd(_mm512_test_epi64_mask(_mm512_castpd_si512(a), bits), b)
    },
    |partial, cotangent, term| {
        let bits = _mm512_set1_epi64(i64::MAX);
        let mask = _mm512_test_epi64_mask(_mm512_castpd_si512(cotangent), bits);
        _mm512_mask3_fmadd_pd(partial, cotangent, term, mask)
    },
    |shifted| {
        let biased = _mm512_add_epi64(_mm512_castpd_si512(shifted), _mm512_set1_epi64(1023));
        _mm512_castsi512_pd(_mm512_slli_epi64::<52>(biased))
    },
    |a| _mm512_abs_pd(a),
    |size, sign| _mm512_or_pd(size, _mm512_and_pd(_mm512_set1_pd(-0.0), sign)),
    |a: Self, b: Self| BitMask(a.0 & b.0),
    |a: Self, b: Self| BitMask(a.0 | b.0),
    |a: Self| BitMask(!a.0),
    |a: Self| a.0,
    |bits| BitMask(bits as __mmask8),
    |a, b| {
        let first = _mm512_set_epi64(11, 3, 10, 2, 9, 1, 8, 0);
        let second = _mm512_set_epi64(15, 7, 14, 6, 13, 5, 12, 4);
        [_mm512_permutex2var_pd(a, first, b), _mm512_permutex2var_pd(a, second, b)]
    }
);

define_lanes!(
    F32x16: [f32; 16] in __m512, mask BitMask<__mmask16>,
    _mm512_set1_ps _mm512_loadu_ps _mm512_storeu_ps
    _mm512_add_ps _mm512_sub_ps _mm512_mul_ps _mm512_div_ps _mm512_sqrt_ps,
    fma _mm512_fmadd_ps, with one rounding _mm512_fmadd_ps, tanh tanh_abreast,
    part |from: &[f32]| _mm512_maskz_loadu_ps(first_bits(from.len()) as __mmask16, from.as_ptr()),
    |to: &mut [f32], a| _mm512_mask_storeu_ps(to.as_mut_ptr(), first_bits(to.len()) as __mmask16, a),
    |a, b| BitMask(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b)),
    |a, b| BitMask(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b)),
    |mask: BitMask<u16>, a, b| _mm512_mask_blend_ps(mask.0, b, a),
    |a, b| {
        // Tests the bits below the sign. Unlike a comparison, this is evaluated at compile time for constants.
        let bits = _mm512_set1_epi32(i32::MAX);
        _mm512_maskz_mov_ps(_mm512_test_epi32_mask(_mm512_castps_si512(a), bits), b)
    },
    |partial, cotangent, term| {
        let bits = _mm512_set1_epi32(i32::MAX);
        let mask = _mm512_test_epi32_mask(_mm512_castps_si512(cotangent), bits);
        _mm512_mask3_fmadd_ps(partial, cotangent, term, mask)
    },
    |shifted| {
        let biased = _mm512_add_epi32(_mm512_castps_si512(shifted), _mm512_set1_epi32(127));
        _mm512_castsi512_ps(_mm512_slli_epi32::<23>(biased))
    },
    |a| _mm512_abs_ps(a),
    |size, sign| _mm512_or_ps(size, _mm512_and_ps(_mm512_set1_ps(-0.0), sign)),
    |a: Self, b: Self| BitMask(a.0 & b.0),
    |a: Self, b: Self| BitMask(a.0 | b.0),
    |a: Self| BitMask(!a.0),
    |a: Self| a.0,
    BitMask,
    |a, b| {
        let first = _mm512_set_epi32(23, 7, 22, 6, 21, 5, 20, 4, 19, 3, 18, 2, 17, 1, 16, 0);
        let second = _mm512_set_epi32(31, 15, 30, 14, 29, 13, 28, 12, 27, 11, 26, 10, 25, 9, 24, 8);
        [_mm512_permutex2var_ps(a, first, b), _mm512_permutex2var_ps(a, second, b)]
    }
);
