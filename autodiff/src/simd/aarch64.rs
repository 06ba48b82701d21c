//! The registers of aarch64 as lanes: NEON, for f64 and f32. Every aarch64 processor has NEON with a fused
//! multiply-add.
#![allow(unsafe_code)]
// Most of these instructions are safe to call, because every aarch64 processor has them. But the macro wraps all calls
// in `unsafe`, which other instruction sets need.
#![allow(unused_unsafe)]

use std::arch::aarch64::*;
use std::ops::{BitAnd, BitOr, Not};

use num_traits::Zero;

use super::narrow::{padded, store_first};
use crate::elementary::Elementary;
use crate::math::{self, Primitive, tanh_abreast};
use crate::operators::operators;
use crate::real::{Lane, Mask, Real};

/// A mask: in each lane, all bits are set or none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneMask<M>(M);

/// Computes `a * b + c` with one rounding.
#[inline(always)]
fn fused_f64(a: float64x2_t, b: float64x2_t, c: float64x2_t) -> float64x2_t {
    // SAFETY: every aarch64 processor has the instruction.
    unsafe { vfmaq_f64(c, a, b) }
}

/// Computes `a * b + c` with one rounding.
#[inline(always)]
fn fused_f32(a: float32x4_t, b: float32x4_t, c: float32x4_t) -> float32x4_t {
    // SAFETY: every aarch64 processor has the instruction.
    unsafe { vfmaq_f32(c, a, b) }
}

define_lanes!(
    F64x2: [f64; 2] in float64x2_t, mask LaneMask<uint64x2_t>,
    vdupq_n_f64 vld1q_f64 vst1q_f64
    vaddq_f64 vsubq_f64 vmulq_f64 vdivq_f64 vsqrtq_f64,
    fma fused_f64, with one rounding fused_f64, tanh tanh_abreast,
    part |from: &[f64]| vld1q_f64(padded::<f64, 2>(from).as_ptr()),
    |to, a| store_first::<f64, 2>(to, Self(a)),
    |a, b| LaneMask(vcltq_f64(a, b)),
    |a, b| LaneMask(vcleq_f64(a, b)),
    |mask: LaneMask<uint64x2_t>, a, b| vbslq_f64(mask.0, a, b),
    |a, b| {
        let bits = vbicq_u64(vreinterpretq_u64_f64(b), vceqzq_f64(a));
        vreinterpretq_f64_u64(bits)
    },
    |partial, cotangent, term| {
        vbslq_f64(vceqzq_f64(cotangent), term, vfmaq_f64(term, partial, cotangent))
    },
    |shifted| {
        let biased = vaddq_s64(vreinterpretq_s64_f64(shifted), vdupq_n_s64(1023));
        vreinterpretq_f64_s64(vshlq_n_s64::<52>(biased))
    },
    |a| vabsq_f64(a),
    |size, sign| vbslq_f64(vdupq_n_u64(1 << 63), sign, size),
    |a: Self, b: Self| LaneMask(vandq_u64(a.0, b.0)),
    |a: Self, b: Self| LaneMask(vorrq_u64(a.0, b.0)),
    |a: Self| LaneMask(vreinterpretq_u64_u32(vmvnq_u32(vreinterpretq_u32_u64(a.0)))),
    |a: Self| vmaxvq_u32(vreinterpretq_u32_u64(a.0)),
    |bits| LaneMask(vtstq_u64(vdupq_n_u64(u64::from(bits)), vld1q_u64([1, 2].as_ptr()))),
    |a, b| [vzip1q_f64(a, b), vzip2q_f64(a, b)]
);

define_lanes!(
    F32x4: [f32; 4] in float32x4_t, mask LaneMask<uint32x4_t>,
    vdupq_n_f32 vld1q_f32 vst1q_f32
    vaddq_f32 vsubq_f32 vmulq_f32 vdivq_f32 vsqrtq_f32,
    fma fused_f32, with one rounding fused_f32, tanh tanh_abreast,
    part |from: &[f32]| vld1q_f32(padded::<f32, 4>(from).as_ptr()),
    |to, a| store_first::<f32, 4>(to, Self(a)),
    |a, b| LaneMask(vcltq_f32(a, b)),
    |a, b| LaneMask(vcleq_f32(a, b)),
    |mask: LaneMask<uint32x4_t>, a, b| vbslq_f32(mask.0, a, b),
    |a, b| {
        let bits = vbicq_u32(vreinterpretq_u32_f32(b), vceqzq_f32(a));
        vreinterpretq_f32_u32(bits)
    },
    |partial, cotangent, term| {
        vbslq_f32(vceqzq_f32(cotangent), term, vfmaq_f32(term, partial, cotangent))
    },
    |shifted| {
        let biased = vaddq_s32(vreinterpretq_s32_f32(shifted), vdupq_n_s32(127));
        vreinterpretq_f32_s32(vshlq_n_s32::<23>(biased))
    },
    |a| vabsq_f32(a),
    |size, sign| vbslq_f32(vdupq_n_u32(1 << 31), sign, size),
    |a: Self, b: Self| LaneMask(vandq_u32(a.0, b.0)),
    |a: Self, b: Self| LaneMask(vorrq_u32(a.0, b.0)),
    |a: Self| LaneMask(vmvnq_u32(a.0)),
    |a: Self| vmaxvq_u32(a.0),
    |bits| LaneMask(vtstq_u32(vdupq_n_u32(u32::from(bits)), vld1q_u32([1, 2, 4, 8].as_ptr()))),
    |a, b| [vzip1q_f32(a, b), vzip2q_f32(a, b)]
);
