//! Numbers of this crate in the generic code of other crates.
//!
//! [`Element`] wraps any [`Real`](crate::Real). It implements num-traits' `Float`, `Num`, `NumAssign`, `Signed` and
//! `FromPrimitive`, and with the feature `nalgebra` also nalgebra's `RealField`. It is one wrapper for all number
//! types, so that code over `R: Real` can call code over `Float`, and every driver can run it.
//!
//! ```
//! use autodiff::{Element, hessian};
//! use num_traits::Float;
//!
//! /// Code that knows nothing of derivatives.
//! fn logistic<T: Float>(x: T) -> T {
//!     T::one() / (T::one() + (-x).exp())
//! }
//!
//! assert_eq!(hessian(|x| logistic(Element(x[0])).0, &[0.0]), [[0.0]]); // its point of inflection
//! ```
//!
//! # What to know
//!
//! - Decisions (`<`, `is_nan`, pivots) look at primals, and panic if lanes disagree. The derivative is that of the
//!   branch taken.
//! - An element does not convert to a primitive number, because that would lose the derivative silently:
//!   `ToPrimitive` returns `None` and `integer_decode` panics. To get only the value, take the primal of the field
//!   `.0`. Constants convert to elements by `T::from`.
//! - Rounding functions are constant between their steps: `floor(x)` has the derivative 0, and `x % m` that of
//!   `x - q m` for the whole quotient `q`.
//! - `mul_add` rounds twice for scalars, as [`Real::fma`](crate::Real::fma) does.
//! - `max`, `min` and `clamp` follow the table in [`real`](crate::real). Unlike the methods of floats they pass on
//!   a NaN of `self`, as in `Element(f64::NAN).max(Element(1.0))`. They ignore a NaN in a bound.

mod element;
mod functions;
mod number;
mod constants;
mod float;
#[cfg(feature = "nalgebra")]
pub mod nalgebra;

pub use element::Element;
