//! Numbers of this crate in the generic code of other crates.
//!
//! [`Element`] wraps any [`Real`](crate::Real). It implements num-traits' `Float`, `Num`, `NumAssign`, `Signed` and
//! `FromPrimitive`, and with the feature `nalgebra` also nalgebra's `RealField`. One wrapper serves all number types.
//! So code over `R: Real` can call code over `Float`, and every driver can run it.
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
//! - Comparisons on which code branches (`<`, `is_nan`, the choice of pivots) look at primals. They panic if lanes
//!   disagree. The derivative is that of the branch that was taken.
//! - An element does not convert to a primitive number, because that would lose the derivative silently:
//!   `ToPrimitive` returns `None` and `integer_decode` panics. To get only the value, take the primal of the field
//!   `.0`. Constants convert to elements by `T::from`.
//! - Rounding functions have the derivative 0, because they are constant between their steps. `x % m` has the
//!   derivative of `x - q m`, where the integer quotient `q` is constant.
//! - `mul_add` rounds twice for scalars, as [`Real::fma`](crate::Real::fma) does.
//! - `max`, `min` and `clamp` follow the table in [`real`](crate::real). Unlike the methods of floats they pass on a
//!   NaN of `self`, as in `Element(f64::NAN).max(Element(1.0))`. They ignore a bound that is NaN.

mod element;
mod functions;
mod number;
mod constants;
mod float;
#[cfg(feature = "nalgebra")]
pub mod nalgebra;

pub use element::Element;
