//! The drivers: functions that compute derivatives of whole functions.
//!
//! A driver takes the function, then the point, then any other arguments. The function is a closure `|x| …` or the name
//! of a generic function such as `fn well<R: Real>(x: &[R]) -> R`. If the function is a method, wrap it in a closure:
//! `|x| well.eval(x)`. Let the closure capture data with respect to which you do not differentiate.
//!
//! All drivers are generic over the number type of `x`, so they nest. To use a number of the outer derivative in an
//! inner closure, make it a [`Var::constant`](crate::Var::constant). It is constant only to the inner derivative.
//!
//! ```
//! use autodiff::{Var, gradient};
//! // d/da of d/dx (a x^2) at x = 3.
//! let slope = |a: &[Var<f64>]| {
//!     gradient(|x| Var::constant(a[0]) * x[0] * x[0], &[Var::constant(3.0)])[0]
//! };
//! assert_eq!(gradient(slope, &[5.0]), [6.0]);
//! ```
//!
//! Drivers of reverse mode keep the memory of their last recordings for the next call on the same thread. A
//! thread keeps at most one gigabyte in total for recordings, rollouts and sums. A [`Tape`](crate::Tape) that
//! you create yourself frees its memory when it is dropped.

mod dense;
mod seed;
mod gradient;
mod jacobian;
mod hessian;
mod values;
mod lu;
pub mod implicit;
pub mod sparse;
#[cfg(feature = "rayon")]
pub mod parallel;

pub use dense::Dense;
pub use gradient::{Function, gradient, gradient_forward, value_and_gradient};
pub use hessian::{hessian, hessian_vector};
pub use jacobian::{jacobian, jacobian_reverse, jvp, vjp};
pub(crate) use seed::along;
pub use values::{
    value_and_gradient_into, value_and_jacobian, value_and_jacobian_into, value_gradient_hessian,
    value_gradient_hessian_into,
};
