//! Double-double numbers: a [`Real`](crate::Real) of about 31 digits, which shows rounding errors.
//!
//! A program written over `R: Real` runs on [`DoubleDouble`] unchanged. The difference between its result in f64 and
//! its result in double-double is the rounding error of the f64 result. Inside [`Dual`](crate::Dual),
//! [`Var`](crate::Var) or a [`Rollout`](crate::Rollout) it measures the rounding errors of derivatives in the same way.
//! Double-double is about thirty times slower than f64.
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
//! `tests/double_double.rs` checks these relative errors against 50-digit values, for magnitudes between 1e-280 and
//! 1e300. Below 1e-280 the numbers are less accurate, because their second float underflows.
//!
//! - 1e-31 for `+ - * /` and `sqrt`;
//! - 1e-30 for `exp`, `ln`, `tanh`, `atan2`, and for `sin` and `cos` away from their zeros. At a zero the error is
//!   absolute, 1e-32 times the angle;
//! - 1e-29 for the special functions away from their zeros. For `erfc(x)` below 0.1 it is 1e-28 plus `x^2` times 1e-31;
//! - For `powi(n)` the error grows by `n` times 1e-31, and for `powf(y)` by `y ln x` times 1e-31.
//!
//! `sin` and `cos` beyond 2^50 radians are NaN. So is `powf` of a negative number, even for an integer exponent.
//! Infinities, NaN and the conventions of the table in [`real`](crate::real) are as in f64.
//!
//! Literals are f64: `R::lit(0.1)` is the same number in f64 and in double-double, so the two results differ only by
//! rounding errors.

mod real;

pub use crate::math::DoubleDouble;
