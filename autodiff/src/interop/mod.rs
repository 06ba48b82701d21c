//! Numbers of this crate in other people's generic code.
//!
//! [`Element`] wraps any [`Real`](crate::Real) and implements num-traits' `Float`, `Num`, `NumAssign`, `Signed`
//! and `FromPrimitive`, and with the feature `nalgebra` that crate's `RealField`. A wrapper rather
//! than an implementation for each type: so code that is generic over `R: Real` can call what asks
//! for a `Float`, and every driver can run it.
//!
//! ```
//! use autodiff::{Element, Function, Real, hessian};
//! use num_traits::Float;
//!
//! /// Written by someone who has never heard of derivatives.
//! fn logistic<T: Float>(x: T) -> T {
//!     T::one() / (T::one() + (-x).exp())
//! }
//!
//! struct Logistic;
//! impl Function for Logistic {
//!     fn eval<R: Real>(&self, x: &[R]) -> R {
//!         logistic(Element(x[0])).0
//!     }
//! }
//! assert_eq!(hessian(|x| Logistic.eval(x), &[0.0]), [[0.0]]); // its point of inflection
//! ```
//!
//! # What to know
//!
//! - Decisions (`<`, `is_nan`, pivots) look at primals, and panic where lanes disagree. The derivative
//!   is that of the branch taken.
//! - An element does not convert to a primitive number: `ToPrimitive` returns `None` and
//!   `integer_decode` panics, where a cast would lose the derivative silently. Take `.0` and its
//!   primal. Constants convert to elements by `T::from`.
//! - Rounding functions are constants between their steps: `floor(x)` has derivative 0, `x % m`
//!   that of `x - q m` for the whole quotient `q`.
//! - `mul_add` rounds twice for scalars, as [`Real::fma`](crate::Real::fma) does.
//! - `max`, `min` and `clamp` have the conventions of the table in [`real`](crate::real). Unlike those
//!   of floats they pass on a NaN of `self`, `Element(f64::NAN).max(Element(1.0))`; they ignore one in
//!   a bound.

mod element;
mod functions;
mod number;
mod constants;
mod float;
#[cfg(feature = "nalgebra")]
pub mod nalgebra;

pub use element::Element;
