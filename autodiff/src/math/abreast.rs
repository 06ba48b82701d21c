//! Several numbers side by side, for instruction-level parallelism.
//!
//! A hyperbolic tangent is a chain of twenty operations, each of which waits for the one before. If several tangents
//! are evaluated one after the other, only few of the chains fit into the window in which a processor reorders
//! instructions. With the type `Abreast`, the same source code does each operation on all numbers before the next
//! operation.

use std::ops::{Add, Div, Mul, Sub};

use super::primitive::{Primitive, tanh};

/// Computes the hyperbolic tangents of several numbers side by side.
#[inline(always)]
pub(crate) fn tanh_abreast<P: Primitive, const N: usize>(x: [P; N]) -> [P; N] {
    tanh(Abreast(x)).0
}

#[derive(Clone, Copy)]
struct Abreast<P, const N: usize>([P; N]);

/// Defines methods that apply an operation to each number.
macro_rules! on_each {
    ($($method:ident($($operand:ident),*)),*) => {
        $(
            #[inline(always)]
            fn $method(mut self $(, $operand: Self)*) -> Self {
                for n in 0..N {
                    self.0[n] = self.0[n].$method($($operand.0[n]),*);
                }
                self
            }
        )*
    };
}

impl<P: Primitive, const N: usize> Add for Abreast<P, N> {
    type Output = Self;
    on_each! { add(other) }
}

impl<P: Primitive, const N: usize> Sub for Abreast<P, N> {
    type Output = Self;
    on_each! { sub(other) }
}

impl<P: Primitive, const N: usize> Mul for Abreast<P, N> {
    type Output = Self;
    on_each! { mul(other) }
}

impl<P: Primitive, const N: usize> Div for Abreast<P, N> {
    type Output = Self;
    on_each! { div(other) }
}

impl<P: Primitive, const N: usize> Primitive for Abreast<P, N> {
    type Scalar = P::Scalar;

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self([P::constant(value); N])
    }
    on_each! {
        mul_add(a, b), exp2_integer(), where_less(bound, if_less, otherwise), magnitude(),
        with_sign_of(other)
    }
}
