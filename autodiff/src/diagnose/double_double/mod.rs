//! Double-double: a [`Real`](crate::Real) of some 31 digits, to measure rounding errors against.
//!
//! A program written over `R: Real` runs on [`DoubleDouble`] unchanged. The difference of its results in f64 and
//! here is its rounding error, whatever the program is. Inside
//! [`Dual`](crate::Dual), [`Var`](crate::Var) or a [`Rollout`](crate::Rollout) it measures
//! derivatives likewise. Some thirty times slower than f64, it is a measuring instrument rather than a
//! number to compute with.
//!
//! ```
//! use autodiff::{Function, Real, DoubleDouble};
//!
//! struct Tenths;
//! impl Function for Tenths {
//!     fn eval<R: Real>(&self, x: &[R]) -> R {
//!         (0..1000).fold(R::zero(), |sum, _| sum + x[0])
//!     }
//! }
//!
//! let error = DoubleDouble::from(Tenths.eval(&[0.1])) - Tenths.eval(&[DoubleDouble::from(0.1)]);
//! // A thousand additions, of which each may round by half an ulp of 100: 1000 * 7e-15.
//! assert!(1e-12 < error.abs().to_f64() && error.abs().to_f64() < 7e-12);
//! ```
//!
//! # Accuracy
//!
//! Relative errors, checked against 50-digit values by `tests/double_double.rs`: 1e-31 for `+ - * /` and
//! `sqrt`, 1e-30 for `exp`, `ln`, `tanh`, `atan2`, and for `sin` and `cos` away from their zeros
//! (at a zero the error is absolute, 1e-32 times the angle). `powi(n)` adds 1e-31 per `n`,
//! `powf(y)` 1e-31 per unit of `y ln x`. All that within 1e-280 and 1e300 in size: the second
//! float of a smaller number underflows.
//!
//! `sin` and `cos` beyond 2^50 radians are NaN rather than wrong, and so is `powf` of a negative number,
//! which f64 has for integer exponents. Infinities, NaN and the conventions of the table in
//! [`real`](crate::real) are as in f64.
//!
//! Literals are f64: `R::lit(0.1)` is the same number in both runs, so that the difference is rounding
//! alone and not a better constant.

mod number;
mod real;

pub use number::DoubleDouble;
