//! Double-double: a [`Real`](crate::Real) of about 31 digits, to measure rounding errors.
//!
//! A program written over `R: Real` runs on [`DoubleDouble`] unchanged. The difference of its results in f64 and
//! in double-double is its rounding error. Inside [`Dual`](crate::Dual), [`Var`](crate::Var) or a
//! [`Rollout`](crate::Rollout) it measures derivatives in the same way. It is about thirty times slower than
//! f64.
//!
//! ```
//! use autodiff::{DoubleDouble, Real};
//!
//! fn thousand<R: Real>(x: R) -> R {
//!     (0..1000).fold(R::zero(), |sum, _| sum + x)
//! }
//!
//! let error = DoubleDouble::from(thousand(0.1)) - thousand(DoubleDouble::from(0.1));
//! // A thousand additions, each of which may round by half an ulp of 100: 1000 * 7e-15.
//! assert!(1e-12 < error.abs().to_f64() && error.abs().to_f64() < 7e-12);
//! ```
//!
//! # Accuracy
//!
//! `tests/double_double.rs` checks these relative errors against 50-digit values, for magnitudes between 1e-280
//! and 1e300. The second float of smaller numbers underflows.
//!
//! - 1e-31 for `+ - * /` and `sqrt`;
//! - 1e-30 for `exp`, `ln`, `tanh`, `atan2`, and for `sin` and `cos` away from their zeros. At a zero the error is
//!   absolute, 1e-32 times the angle;
//! - `powi(n)` adds 1e-31 per `n`, and `powf(y)` 1e-31 per unit of `y ln x`.
//!
//! `sin` and `cos` beyond 2^50 radians are NaN. So is `powf` of a negative number, even for an integer exponent.
//! Infinities, NaN and the conventions of the table in [`real`](crate::real) are as in f64.
//!
//! Literals are f64: `R::lit(0.1)` is the same number in both runs, so the difference is only rounding.

mod number;
mod real;

pub use number::DoubleDouble;
