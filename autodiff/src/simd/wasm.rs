//! The registers of WebAssembly as lanes: `simd128`, for f64 and f32, if the crate is compiled with
//! `-C target-feature=+simd128`. A module with these instructions only runs on engines that support them.
//!
//! There is no fused multiply-add, so [`Real::fma`] rounds twice, also for scalars. Elementary functions must round
//! once to give the same bits everywhere, so they compute fused multiply-adds in software, lane by lane. The hyperbolic
//! tangent takes most of the time of neural-network controllers, so it avoids the software version in most cases; see
//! `doubted.rs`.
#![allow(unsafe_code)]
// Only loads and stores, which use pointers, are unsafe here. But the macro wraps all calls in `unsafe`, which other
// instruction sets need.
#![allow(unused_unsafe)]

use std::arch::wasm32::*;
use std::ops::{BitAnd, BitOr, Not};

use num_traits::Zero;

use super::doubted::{Unfused, around, tanh_unfused};
use super::narrow::{padded, store_first};
use crate::elementary::Elementary;
use crate::math::{self, Primitive, tanh_abreast};
use crate::operators::operators;
use crate::real::{Lane, Mask, Real};

/// A mask: in each 64-bit lane, all bits are set or none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mask64(v128);

/// A mask: in each 32-bit lane, all bits are set or none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mask32(v128);

/// # Safety
/// `from` must point to as many numbers as a register holds.
#[inline(always)]
unsafe fn load<S>(from: *const S) -> v128 {
    // SAFETY: guaranteed by the caller. The instruction needs no alignment.
    unsafe { v128_load(from.cast()) }
}

/// # Safety
/// `to` must point to room for as many numbers as a register holds.
#[inline(always)]
unsafe fn store<S>(to: *mut S, a: v128) {
    // SAFETY: guaranteed by the caller. The instruction needs no alignment.
    unsafe { v128_store(to.cast(), a) }
}

/// Computes `a * b + c` with two roundings.
#[inline(always)]
fn multiply_add_f64(a: v128, b: v128, c: v128) -> v128 {
    f64x2_add(f64x2_mul(a, b), c)
}

/// Computes `a * b + c` with two roundings.
#[inline(always)]
fn multiply_add_f32(a: v128, b: v128, c: v128) -> v128 {
    f32x4_add(f32x4_mul(a, b), c)
}

/// Computes `a * b + c` with one rounding, in software.
#[inline(always)]
fn fused_f64(a: v128, b: v128, c: v128) -> v128 {
    let lane = |of| [f64x2_extract_lane::<0>(of), f64x2_extract_lane::<1>(of)];
    let [a, b, c] = [lane(a), lane(b), lane(c)];
    f64x2(a[0].mul_add(b[0], c[0]), a[1].mul_add(b[1], c[1]))
}

/// Computes `a * b + c` with one rounding, in software.
#[inline(always)]
fn fused_f32(a: v128, b: v128, c: v128) -> v128 {
    let mut lanes = [[0.0_f32; 4]; 3];
    for (lanes, of) in lanes.iter_mut().zip([a, b, c]) {
        F32x4(of).store(lanes);
    }
    let [a, b, c] = lanes;
    let fused = |k: usize| a[k].mul_add(b[k], c[k]);
    f32x4(fused(0), fused(1), fused(2), fused(3))
}

define_lanes!(
    F64x2: [f64; 2] in v128, mask Mask64,
    f64x2_splat load store
    f64x2_add f64x2_sub f64x2_mul f64x2_div f64x2_sqrt,
    fma multiply_add_f64, with one rounding fused_f64, tanh tanh,
    part |from: &[f64]| load(padded::<f64, 2>(from).as_ptr()),
    |to, a| store_first::<f64, 2>(to, Self(a)),
    |a, b| Mask64(f64x2_lt(a, b)),
    |a, b| Mask64(f64x2_le(a, b)),
    |mask: Mask64, a, b| v128_bitselect(a, b, mask.0),
    |a, b| v128_andnot(b, f64x2_eq(a, f64x2_splat(0.0))),
    |partial, cotangent, term| {
        let zero = f64x2_eq(cotangent, f64x2_splat(0.0));
        v128_bitselect(term, multiply_add_f64(partial, cotangent, term), zero)
    },
    |shifted| i64x2_shl(i64x2_add(shifted, i64x2_splat(1023)), 52),
    |a| f64x2_abs(a),
    |size, sign| v128_bitselect(sign, size, f64x2_splat(-0.0)),
    |a: Self, b: Self| Mask64(v128_and(a.0, b.0)),
    |a: Self, b: Self| Mask64(v128_or(a.0, b.0)),
    |a: Self| Mask64(v128_not(a.0)),
    |a: Self| i32::from(v128_any_true(a.0)),
    |bits| {
        let lane = i64x2(1, 2);
        Mask64(i64x2_eq(v128_and(i64x2_splat(i64::from(bits)), lane), lane))
    },
    |a, b| [i64x2_shuffle::<0, 2>(a, b), i64x2_shuffle::<1, 3>(a, b)]
);

define_lanes!(
    F32x4: [f32; 4] in v128, mask Mask32,
    f32x4_splat load store
    f32x4_add f32x4_sub f32x4_mul f32x4_div f32x4_sqrt,
    fma multiply_add_f32, with one rounding fused_f32, tanh tanh,
    part |from: &[f32]| load(padded::<f32, 4>(from).as_ptr()),
    |to, a| store_first::<f32, 4>(to, Self(a)),
    |a, b| Mask32(f32x4_lt(a, b)),
    |a, b| Mask32(f32x4_le(a, b)),
    |mask: Mask32, a, b| v128_bitselect(a, b, mask.0),
    |a, b| v128_andnot(b, f32x4_eq(a, f32x4_splat(0.0))),
    |partial, cotangent, term| {
        let zero = f32x4_eq(cotangent, f32x4_splat(0.0));
        v128_bitselect(term, multiply_add_f32(partial, cotangent, term), zero)
    },
    |shifted| i32x4_shl(i32x4_add(shifted, i32x4_splat(127)), 23),
    |a| f32x4_abs(a),
    |size, sign| v128_bitselect(sign, size, f32x4_splat(-0.0)),
    |a: Self, b: Self| Mask32(v128_and(a.0, b.0)),
    |a: Self, b: Self| Mask32(v128_or(a.0, b.0)),
    |a: Self| Mask32(v128_not(a.0)),
    |a: Self| i32::from(v128_any_true(a.0)),
    |bits| {
        let lane = i32x4(1, 2, 4, 8);
        Mask32(i32x4_eq(v128_and(i32x4_splat(i32::from(bits)), lane), lane))
    },
    |a, b| [i32x4_shuffle::<0, 4, 1, 5>(a, b), i32x4_shuffle::<2, 6, 3, 7>(a, b)]
);

impl Unfused for F64x2 {
    #[inline(always)]
    fn fused(self, b: Self, c: Self) -> (Self, Mask64) {
        let upper = Self(v128_and(self.0, i64x2_splat(-1 << 27)));
        let [above, below] = around(self, upper, b, c);
        (above, Mask64(f64x2_ne(above.0, below.0)))
    }
}

impl Unfused for F32x4 {
    /// Computes the result in double precision, where the product is exact but the sum may be rounded. Then the doubles
    /// just above and just below the sum are converted to singles. If the two singles differ, the rounding of the sum
    /// may have changed the result.
    #[inline(always)]
    fn fused(self, b: Self, c: Self) -> (Self, Mask32) {
        let [low, high] = doubles(self.0);
        let [[b_low, b_high], [c_low, c_high]] = [doubles(b.0), doubles(c.0)];
        let low = f64x2_add(f64x2_mul(low, b_low), c_low);
        let high = f64x2_add(f64x2_mul(high, b_high), c_high);
        let above = singles(low, high, 1.0 + f64::EPSILON);
        let below = singles(low, high, 1.0 - f64::EPSILON);
        (Self(above), Mask32(f32x4_ne(above, below)))
    }
}

/// Converts four singles to doubles: the first two lanes, then the last two.
#[inline(always)]
fn doubles(singles: v128) -> [v128; 2] {
    let high = i64x2_shuffle::<1, 1>(singles, singles);
    [
        f64x2_promote_low_f32x4(singles),
        f64x2_promote_low_f32x4(high),
    ]
}

/// Multiplies four doubles by `share` and converts the products to singles.
#[inline(always)]
fn singles(low: v128, high: v128, share: f64) -> v128 {
    let share = f64x2_splat(share);
    let low = f32x4_demote_f64x2_zero(f64x2_mul(low, share));
    let high = f32x4_demote_f64x2_zero(f64x2_mul(high, share));
    i64x2_shuffle::<0, 2>(low, high)
}

/// Computes the hyperbolic tangents of several registers. This function is not inlined: within the loops of a matrix
/// product, the engine would run out of registers.
#[inline(never)]
fn tanh<L: Unfused, const N: usize>(x: [L; N]) -> [L; N] {
    match tanh_unfused(x) {
        Some(found) => found,
        None => in_software(x),
    }
}

#[cold]
#[inline(never)]
fn in_software<L: Unfused, const N: usize>(x: [L; N]) -> [L; N] {
    tanh_abreast(x)
}
