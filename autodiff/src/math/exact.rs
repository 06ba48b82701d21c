//! Sums and products of two floats without rounding error. Each function returns two numbers: the rounded result, and
//! the rounding error.

use super::primitive::Primitive;

/// Computes `a + b` and its rounding error (Knuth, *The Art of Computer Programming* 2, section 4.2.2).
#[inline]
pub(crate) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let from_b = sum - a;
    (sum, (a - (sum - from_b)) + (b - from_b))
}

/// Computes `a * b` and its rounding error (Dekker 1971, but with a fused multiply-add instead of splitting the
/// factors).
#[inline(always)]
pub(crate) fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, Primitive::mul_add(a, b, -product))
}
