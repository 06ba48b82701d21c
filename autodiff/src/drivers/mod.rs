//! Derivatives of whole functions.
//!
//! A function to differentiate is a type with one generic method, [`Function`] or
//! [`VectorFunction`]: a closure cannot be generic over the number type, and each driver picks
//! its own. Parameters that are not differentiated are fields of the type. Where reverse mode is
//! all that is wanted, [`gradient_of`] and [`value_and_gradient_of`] take a closure.
//!
//! All drivers are generic over the number type of `x`, so they nest. A number of an outer derivative
//! enters an inner closure as a [`Var::constant`](crate::Var::constant): constant to the inner derivative, not to the outer
//! one.
//!
//! ```
//! use autodiff::{Var, gradient_of};
//! // d/da of d/dx (a x^2) at x = 3.
//! let slope = |a: &[Var<f64>]| {
//!     gradient_of(|x| Var::constant(a[0]) * x[0] * x[0], &[Var::constant(3.0)])[0]
//! };
//! assert_eq!(gradient_of(slope, &[5.0]), [6.0]);
//! ```
//!
//! Drivers of reverse mode keep the memory of their recording, up to a gigabyte, for the next call on
//! the same thread; a [`Tape`](crate::Tape) of one's own frees it when it is dropped.

mod seed;
mod gradient;
mod jacobian;
mod hessian;
mod lu;
pub mod implicit;
pub mod sparse;
pub mod batch;
#[cfg(feature = "rayon")]
pub mod parallel;

pub use gradient::{Function, gradient, gradient_of, value_and_gradient, value_and_gradient_of};
pub use hessian::{hessian, hessian_vector};
pub use jacobian::{VectorFunction, jacobian, jvp, vjp};
pub(crate) use seed::along;
