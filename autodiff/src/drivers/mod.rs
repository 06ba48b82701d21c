//! Derivatives of whole functions.
//!
//! A function to differentiate is a type with one generic method, [`Function`] or
//! [`VectorFunction`], because each driver picks its own number type. Parameters that are not
//! differentiated are fields of the type. A closure cannot be generic, but serves one driver: the
//! closure form of each ends in `_of`. It takes any `fn f<R: Real>(x: &[R]) -> R` too. The function comes
//! first, then the point, then the rest.
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
//! Drivers of reverse mode keep the memory of their last recordings for the next call on the same thread. A
//! thread keeps at most one gigabyte in total for recordings, rollouts and sums. A [`Tape`](crate::Tape) that
//! you create yourself frees its memory when it is dropped.

mod dense;
mod seed;
mod gradient;
mod jacobian;
mod hessian;
mod lu;
pub mod implicit;
pub mod sparse;
#[cfg(feature = "rayon")]
pub mod parallel;

pub use dense::Dense;
pub use gradient::{
    Function, gradient, gradient_forward, gradient_forward_of, gradient_of, value_and_gradient,
    value_and_gradient_of,
};
pub use hessian::{hessian, hessian_of, hessian_vector, hessian_vector_of};
pub use jacobian::{VectorFunction, jacobian, jacobian_of, jvp, jvp_of, vjp, vjp_of};
pub(crate) use seed::along;
