//! The registers of x86-64 as lanes: AVX-512 and AVX2 with FMA, for f64 and f32.
//!
//! The types are private to the crate and named only inside [`enter`](super::enter)'s closures,
//! that is after the processor has been asked for the instructions they use.
// `cargo bench -p benches --bench tapes`: kernels in lanes against the scalar step.
#![allow(unsafe_code)]

use std::arch::x86_64::*;
use std::ops::{
    Add, AddAssign, BitAnd, BitOr, Div, DivAssign, Mul, MulAssign, Neg, Not, Sub, SubAssign,
};

use num_traits::{One, Zero};

use super::Lane;
use crate::elementary::{self, Primitive};
use crate::real::{Mask, Real};

/// A mask of one bit a lane (AVX-512).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bits<M>(M);

/// A mask of one whole lane a truth value (AVX2).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wide<M>(M);

/// A bit for each of the first `n` lanes.
#[inline(always)]
fn first_bits(n: usize) -> u16 {
    !(u16::MAX << n)
}

/// All bits of the first `n` lanes.
#[inline(always)]
fn first_i64(n: usize) -> __m256i {
    const ONES: [i64; 8] = [-1, -1, -1, -1, 0, 0, 0, 0];
    let window: &[i64; 4] = ONES[4 - n..8 - n].try_into().expect("the length was taken");
    // SAFETY: the reference covers the register.
    unsafe { _mm256_loadu_si256(window.as_ptr().cast()) }
}

/// All bits of the first `n` lanes.
#[inline(always)]
fn first_i32(n: usize) -> __m256i {
    const ONES: [i32; 16] = [-1, -1, -1, -1, -1, -1, -1, -1, 0, 0, 0, 0, 0, 0, 0, 0];
    let window: &[i32; 8] = ONES[8 - n..16 - n]
        .try_into()
        .expect("the length was taken");
    // SAFETY: the reference covers the register.
    unsafe { _mm256_loadu_si256(window.as_ptr().cast()) }
}

/// Defines a register as a lane type. The second list names what differs between instruction
/// sets in more than a prefix; see the functions below.
macro_rules! define_lanes {
    (
        $name:ident: [$scalar:ident; $n:literal] in $register:ident, mask $mask:ty,
        $splat:ident $load:ident $store:ident
        $add:ident $sub:ident $mul:ident $div:ident $fma:ident $sqrt:ident,
        part $load_part:expr, $store_part:expr,
        $lt:expr, $le:expr, $blend:expr,
        $where_nonzero:expr, $fma_where_nonzero:expr, $exp2:expr, $abs:expr,
        $and:expr, $or:expr, $not:expr, $bits:expr, $from_bits:expr,
        $expand:expr, $compress:expr
    ) => {
        #[doc = concat!(stringify!($n), " lanes of `", stringify!($scalar), "`.")]
        #[derive(Clone, Copy, Debug)]
        pub(crate) struct $name($register);

        impl BitAnd for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, other: Self) -> Self {
                $and(self, other)
            }
        }
        impl BitOr for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, other: Self) -> Self {
                $or(self, other)
            }
        }
        impl Not for $mask {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                $not(self)
            }
        }
        impl Mask for $mask {
            #[inline(always)]
            fn splat(value: bool) -> Self {
                let zero = <$name as Zero>::zero();
                if value { zero.le(zero) } else { zero.lt(zero) }
            }
            #[inline(always)]
            fn any(self) -> bool {
                $bits(self) != 0
            }
        }

        // SAFETY, here and below: a value of this type exists only where its instructions do.
        impl Add for $name {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                Self(unsafe { $add(self.0, other.0) })
            }
        }
        impl Sub for $name {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                Self(unsafe { $sub(self.0, other.0) })
            }
        }
        impl Mul for $name {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                Self(unsafe { $mul(self.0, other.0) })
            }
        }
        impl Div for $name {
            type Output = Self;
            #[inline(always)]
            fn div(self, other: Self) -> Self {
                Self(unsafe { $div(self.0, other.0) })
            }
        }
        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self::lit(-0.0) - self
            }
        }
        impl AddAssign for $name {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }
        impl SubAssign for $name {
            #[inline(always)]
            fn sub_assign(&mut self, other: Self) {
                *self = *self - other;
            }
        }
        impl MulAssign for $name {
            #[inline(always)]
            fn mul_assign(&mut self, other: Self) {
                *self = *self * other;
            }
        }
        impl DivAssign for $name {
            #[inline(always)]
            fn div_assign(&mut self, other: Self) {
                *self = *self / other;
            }
        }
        impl Zero for $name {
            #[inline(always)]
            fn zero() -> Self {
                Self::lit(0.0)
            }
            #[inline(always)]
            fn is_zero(&self) -> bool {
                let zero = Self::lit(0.0);
                (self.le(zero) & zero.le(*self)).all()
            }
        }
        impl One for $name {
            #[inline(always)]
            fn one() -> Self {
                Self::lit(1.0)
            }
        }

        impl Lane<$scalar> for $name {
            const N: usize = $n;
            #[inline(always)]
            fn splat(value: $scalar) -> Self {
                Self(unsafe { $splat(value) })
            }
            #[inline(always)]
            fn load(from: &[$scalar]) -> Self {
                let from: &[$scalar; $n] = from[..$n].try_into().expect("the length was taken");
                // SAFETY: the reference covers all lanes.
                Self(unsafe { $load(from.as_ptr()) })
            }
            #[inline(always)]
            fn store(self, to: &mut [$scalar]) {
                let to: &mut [$scalar; $n] =
                    (&mut to[..$n]).try_into().expect("the length was taken");
                // SAFETY: the reference covers all lanes.
                unsafe { $store(to.as_mut_ptr(), self.0) }
            }
            #[inline(always)]
            fn load_part(from: &[$scalar]) -> Self {
                debug_assert!(from.len() < $n);
                // SAFETY: no lane beyond the slice is touched.
                Self(unsafe { $load_part(from.as_ptr(), from.len()) })
            }
            #[inline(always)]
            fn store_part(self, to: &mut [$scalar]) {
                debug_assert!(to.len() < $n);
                // SAFETY: no lane beyond the slice is touched.
                unsafe { $store_part(to.as_mut_ptr(), to.len(), self.0) }
            }
            #[inline(always)]
            fn mask(bits: u16) -> $mask {
                $from_bits(bits)
            }
            #[inline(always)]
            fn expand(self, bits: u16) -> Self {
                $expand(self, bits)
            }
            #[inline(always)]
            fn compress(self, bits: u16) -> Self {
                $compress(self, bits)
            }
        }

        impl $name {
            /// Calls a scalar function lane by lane: for what no hot loop uses.
            #[inline(always)]
            fn each(self, other: Self, f: impl Fn($scalar, $scalar) -> $scalar) -> Self {
                let (mut a, mut b) = ([0.0; $n], [0.0; $n]);
                self.store(&mut a);
                other.store(&mut b);
                for (a, b) in a.iter_mut().zip(b) {
                    *a = f(*a, b);
                }
                Self::load(&a)
            }

            /// [`Lane::expand`] or [`Lane::compress`] one by one.
            #[allow(dead_code)] // where the instruction set has these
            #[inline(always)]
            fn moved(self, bits: u16, expand: bool) -> Self {
                let (mut from, mut to) = ([0.0; $n], [0.0; $n]);
                self.store(&mut from);
                let mut next = 0;
                for k in (0..$n).filter(|k| bits >> k & 1 == 1) {
                    if expand {
                        to[k] = from[next];
                    } else {
                        to[next] = from[k];
                    }
                    next += 1;
                }
                Self::load(&to)
            }
        }

        impl Primitive for $name {
            const EXP_TERMS: usize = <$scalar as Primitive>::EXP_TERMS;
            const SIN_TERMS: usize = <$scalar as Primitive>::SIN_TERMS;
            const LN_2: [f64; 2] = <$scalar as Primitive>::LN_2;
            const PI_2: [f64; 3] = <$scalar as Primitive>::PI_2;
            const EXP_RANGE: [f64; 2] = <$scalar as Primitive>::EXP_RANGE;
            const TANH_ONE: f64 = <$scalar as Primitive>::TANH_ONE;
            const ROUNDING: f64 = <$scalar as Primitive>::ROUNDING;

            #[inline(always)]
            fn constant(value: f64) -> Self {
                Self::splat(value as $scalar)
            }
            #[inline(always)]
            fn mul_add(self, a: Self, b: Self) -> Self {
                Self(unsafe { $fma(self.0, a.0, b.0) })
            }
            #[inline(always)]
            fn exp2_integer(self) -> Self {
                let shifted = self + Self::constant(Self::ROUNDING);
                Self(unsafe { $exp2(shifted.0) })
            }
            #[inline(always)]
            fn where_less(self, bound: Self, if_less: Self, otherwise: Self) -> Self {
                Self::select(self.lt(bound), if_less, otherwise)
            }
            #[inline(always)]
            fn magnitude(self) -> Self {
                Self(unsafe { $abs(self.0) })
            }
        }

        impl Real for $name {
            type Mask = $mask;

            #[inline(always)]
            fn lit(value: f64) -> Self {
                Self::splat(value as $scalar)
            }
            #[inline(always)]
            fn lt(self, other: Self) -> $mask {
                unsafe { $lt(self.0, other.0) }
            }
            #[inline(always)]
            fn le(self, other: Self) -> $mask {
                unsafe { $le(self.0, other.0) }
            }
            #[inline(always)]
            fn select(mask: $mask, if_true: Self, if_false: Self) -> Self {
                Self(unsafe { $blend(mask, if_true.0, if_false.0) })
            }
            #[inline(always)]
            fn fma(self, factor: Self, term: Self) -> Self {
                self.mul_add(factor, term)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(unsafe { $sqrt(self.0) })
            }
            #[inline(always)]
            fn exp(self) -> Self {
                elementary::exp(self)
            }
            #[inline(always)]
            fn ln(self) -> Self {
                self.each(self, |x, _| Real::ln(x))
            }
            #[inline(always)]
            fn sin(self) -> Self {
                if self.abs().le(Self::lit(elementary::SIN_RANGE)).all() {
                    elementary::sin_cos(self).0
                } else {
                    self.each(self, |x, _| Real::sin(x))
                }
            }
            #[inline(always)]
            fn cos(self) -> Self {
                if self.abs().le(Self::lit(elementary::SIN_RANGE)).all() {
                    elementary::sin_cos(self).1
                } else {
                    self.each(self, |x, _| Real::cos(x))
                }
            }
            #[inline(always)]
            fn tanh(self) -> Self {
                elementary::tanh(self)
            }
            #[inline(always)]
            fn atan2(self, x: Self) -> Self {
                self.each(x, |y, x| Real::atan2(y, x))
            }
            #[inline(always)]
            fn powi(self, exponent: i32) -> Self {
                self.each(self, |x, _| Real::powi(x, exponent))
            }
            #[inline(always)]
            fn powf(self, exponent: Self) -> Self {
                self.each(exponent, |x, y| Real::powf(x, y))
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.magnitude()
            }
            #[inline(always)]
            fn detach(self) -> Self {
                self
            }
            #[inline(always)]
            fn straight_through(self, _soft: Self) -> Self {
                self
            }
            #[inline(always)]
            fn chain(partial: Self, cotangent: Self) -> Self {
                let product = partial * cotangent;
                Self(unsafe { $where_nonzero(cotangent.0, product.0) })
            }
            #[inline(always)]
            fn chain_add(partial: Self, cotangent: Self, term: Self) -> Self {
                Self(unsafe { $fma_where_nonzero(partial.0, cotangent.0, term.0) })
            }
        }
    };
}

define_lanes!(
    F64x8: [f64; 8] in __m512d, mask Bits<__mmask8>,
    _mm512_set1_pd _mm512_loadu_pd _mm512_storeu_pd
    _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd _mm512_fmadd_pd _mm512_sqrt_pd,
    part |from, n| _mm512_maskz_loadu_pd(first_bits(n) as __mmask8, from),
    |to, n, a| _mm512_mask_storeu_pd(to, first_bits(n) as __mmask8, a),
    |a, b| Bits(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b)),
    |a, b| Bits(_mm512_cmp_pd_mask::<_CMP_LE_OQ>(a, b)),
    |mask: Bits<u8>, a, b| _mm512_mask_blend_pd(mask.0, b, a),
    |a, b| {
        // A test of the bits below the sign: unlike a comparison, constants fold in it.
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
    |a: Self, b: Self| Bits(a.0 & b.0),
    |a: Self, b: Self| Bits(a.0 | b.0),
    |a: Self| Bits(!a.0),
    |a: Self| a.0,
    |bits| Bits(bits as __mmask8),
    |a: Self, bits| Self(unsafe { _mm512_maskz_expand_pd(bits as __mmask8, a.0) }),
    |a: Self, bits| Self(unsafe { _mm512_maskz_compress_pd(bits as __mmask8, a.0) })
);

define_lanes!(
    F32x16: [f32; 16] in __m512, mask Bits<__mmask16>,
    _mm512_set1_ps _mm512_loadu_ps _mm512_storeu_ps
    _mm512_add_ps _mm512_sub_ps _mm512_mul_ps _mm512_div_ps _mm512_fmadd_ps _mm512_sqrt_ps,
    part |from, n| _mm512_maskz_loadu_ps(first_bits(n) as __mmask16, from),
    |to, n, a| _mm512_mask_storeu_ps(to, first_bits(n) as __mmask16, a),
    |a, b| Bits(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b)),
    |a, b| Bits(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b)),
    |mask: Bits<u16>, a, b| _mm512_mask_blend_ps(mask.0, b, a),
    |a, b| {
        // A test of the bits below the sign: unlike a comparison, constants fold in it.
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
    |a: Self, b: Self| Bits(a.0 & b.0),
    |a: Self, b: Self| Bits(a.0 | b.0),
    |a: Self| Bits(!a.0),
    |a: Self| a.0,
    Bits,
    |a: Self, bits| Self(unsafe { _mm512_maskz_expand_ps(bits, a.0) }),
    |a: Self, bits| Self(unsafe { _mm512_maskz_compress_ps(bits, a.0) })
);

define_lanes!(
    F64x4: [f64; 4] in __m256d, mask Wide<__m256d>,
    _mm256_set1_pd _mm256_loadu_pd _mm256_storeu_pd
    _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd _mm256_fmadd_pd _mm256_sqrt_pd,
    part |from, n| _mm256_maskload_pd(from, first_i64(n)),
    |to, n, a| _mm256_maskstore_pd(to, first_i64(n), a),
    |a, b| Wide(_mm256_cmp_pd::<_CMP_LT_OQ>(a, b)),
    |a, b| Wide(_mm256_cmp_pd::<_CMP_LE_OQ>(a, b)),
    |mask: Wide<__m256d>, a, b| _mm256_blendv_pd(b, a, mask.0),
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
    |a: Self, b: Self| Wide(unsafe { _mm256_and_pd(a.0, b.0) }),
    |a: Self, b: Self| Wide(unsafe { _mm256_or_pd(a.0, b.0) }),
    |a: Self| Wide(unsafe { _mm256_xor_pd(a.0, _mm256_castsi256_pd(_mm256_set1_epi64x(-1))) }),
    |a: Self| unsafe { _mm256_movemask_pd(a.0) },
    |bits| unsafe {
        let lane = _mm256_set_epi64x(8, 4, 2, 1);
        let set = _mm256_and_si256(_mm256_set1_epi64x(i64::from(bits)), lane);
        Wide(_mm256_castsi256_pd(_mm256_cmpeq_epi64(set, lane)))
    },
    |a: Self, bits| a.moved(bits, true),
    |a: Self, bits| a.moved(bits, false)
);

define_lanes!(
    F32x8: [f32; 8] in __m256, mask Wide<__m256>,
    _mm256_set1_ps _mm256_loadu_ps _mm256_storeu_ps
    _mm256_add_ps _mm256_sub_ps _mm256_mul_ps _mm256_div_ps _mm256_fmadd_ps _mm256_sqrt_ps,
    part |from, n| _mm256_maskload_ps(from, first_i32(n)),
    |to, n, a| _mm256_maskstore_ps(to, first_i32(n), a),
    |a, b| Wide(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b)),
    |a, b| Wide(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)),
    |mask: Wide<__m256>, a, b| _mm256_blendv_ps(b, a, mask.0),
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
    |a: Self, b: Self| Wide(unsafe { _mm256_and_ps(a.0, b.0) }),
    |a: Self, b: Self| Wide(unsafe { _mm256_or_ps(a.0, b.0) }),
    |a: Self| Wide(unsafe { _mm256_xor_ps(a.0, _mm256_castsi256_ps(_mm256_set1_epi32(-1))) }),
    |a: Self| unsafe { _mm256_movemask_ps(a.0) },
    |bits| unsafe {
        let lane = _mm256_set_epi32(128, 64, 32, 16, 8, 4, 2, 1);
        let set = _mm256_and_si256(_mm256_set1_epi32(i32::from(bits)), lane);
        Wide(_mm256_castsi256_ps(_mm256_cmpeq_epi32(set, lane)))
    },
    |a: Self, bits| a.moved(bits, true),
    |a: Self, bits| a.moved(bits, false)
);
