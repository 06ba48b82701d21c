//! Several numbers abreast, for instruction-level parallelism.
//!
//! A hyperbolic tangent is a chain of twenty operations, each of which waits for the one before.
//! Evaluated one after the other, few such chains fit into the window in which a processor reorders
//! instructions. Over numbers abreast, the same source does every operation on all of them before the
//! next.

use std::ops::{Add, Div, Mul, Sub};

use super::primitive::Primitive;

#[derive(Clone, Copy)]
pub(crate) struct Abreast<P, const N: usize>(pub(crate) [P; N]);

impl<P: Primitive, const N: usize> Add for Abreast<P, N> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        for n in 0..N {
            self.0[n] = self.0[n] + other.0[n];
        }
        self
    }
}

impl<P: Primitive, const N: usize> Sub for Abreast<P, N> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        for n in 0..N {
            self.0[n] = self.0[n] - other.0[n];
        }
        self
    }
}

impl<P: Primitive, const N: usize> Mul for Abreast<P, N> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, other: Self) -> Self {
        for n in 0..N {
            self.0[n] = self.0[n] * other.0[n];
        }
        self
    }
}

impl<P: Primitive, const N: usize> Div for Abreast<P, N> {
    type Output = Self;
    #[inline(always)]
    fn div(mut self, other: Self) -> Self {
        for n in 0..N {
            self.0[n] = self.0[n] / other.0[n];
        }
        self
    }
}

impl<P: Primitive, const N: usize> Primitive for Abreast<P, N> {
    const EXP_TERMS: usize = P::EXP_TERMS;
    const SIN_TERMS: usize = P::SIN_TERMS;
    const LN_2: [f64; 2] = P::LN_2;
    const PI_2: [f64; 3] = P::PI_2;
    const ROUNDING: f64 = P::ROUNDING;
    const EXP_RANGE: [f64; 2] = P::EXP_RANGE;
    const TANH_ONE: f64 = P::TANH_ONE;

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self([P::constant(value); N])
    }
    #[inline(always)]
    fn mul_add(mut self, a: Self, b: Self) -> Self {
        for n in 0..N {
            self.0[n] = self.0[n].mul_add(a.0[n], b.0[n]);
        }
        self
    }
    #[inline(always)]
    fn exp2_integer(mut self) -> Self {
        for n in 0..N {
            self.0[n] = self.0[n].exp2_integer();
        }
        self
    }
    #[inline(always)]
    fn where_less(mut self, bound: Self, if_less: Self, otherwise: Self) -> Self {
        for n in 0..N {
            self.0[n] = self.0[n].where_less(bound.0[n], if_less.0[n], otherwise.0[n]);
        }
        self
    }
    #[inline(always)]
    fn magnitude(mut self) -> Self {
        for n in 0..N {
            self.0[n] = self.0[n].magnitude();
        }
        self
    }
    #[inline(always)]
    fn with_sign_of(mut self, other: Self) -> Self {
        for n in 0..N {
            self.0[n] = self.0[n].with_sign_of(other.0[n]);
        }
        self
    }
}
