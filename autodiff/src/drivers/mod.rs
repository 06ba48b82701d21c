//! The drivers: functions that compute derivatives of whole functions.
//!
//! A driver takes the function, then the point, then any other arguments. The function is a closure `|x| …` or the name
//! of a generic function such as `fn well<R: Real>(x: &[R]) -> R`. If the function is a method, wrap it in a closure:
//! `|x| well.eval(x)`. Let the closure capture data with respect to which you do not differentiate.
//!
//! # Which driver to use when
//!
//! | to get | use | cost in evaluations | measured |
//! | --- | --- | --- | --- |
//! | a derivative along a direction | [`jvp`] | about 2 | |
//! | the gradient of one scalar with respect to many arguments | [`gradient`], [`value_and_gradient`] | a few for array operations, tens for scalar operations on the tape, for any number of arguments | 18 times by hand: Rosenbrock in 100 dimensions |
//! | the gradient with respect to a dozen arguments | [`gradient_forward`] | 2 to 3 for every eight arguments; no tape | |
//! | the gradient or the Jacobian with respect to a fixed, small number of arguments | [`value_and_gradient_array`], [`value_and_jacobian_array`] | like `gradient_forward`, in one pass and without allocations | 2.4 times the value: 10 arguments; 2.0 times: an ODE fit of 4 |
//! | the cotangents of several values at once | [`vjp`] | like `gradient` | |
//! | a Jacobian | [`jacobian`], [`value_and_jacobian`] | 2 to 3 for every eight arguments; up to 9 if the compiler vectorises the value | |
//! | a Jacobian of few values with respect to many arguments | [`jacobian_reverse`] | one recording, one sweep per value | |
//! | a Jacobian that is mostly zeros | [`sparse_jacobian`](crate::sparse_jacobian) | one direction per colour of its columns: 3 for a tridiagonal Jacobian of any size | 20 times by hand: tridiagonal, 1000 values |
//! | a Hessian times a vector | [`hessian_vector`] | a few gradients | |
//! | a Hessian | [`hessian`], [`value_gradient_hessian`] | a few gradients for every four arguments | 14 times by hand: logistic regression as a `Sum`, 10 weights |
//! | derivatives of any order with respect to one number | [`derivatives`] | doubles with each order | |
//! | all third derivatives | [`third_derivatives`] | a few gradients for each pair of arguments | |
//! | a Hessian that is mostly zeros | [`sparse_hessian`](crate::sparse_hessian) | a gradient per colour | |
//! | the gradient of thousands of time steps | [`Rollout`](crate::Rollout) of a [`Model`](crate::Model) | a few; memory grows only with the state | 2.3 to 2.7 times the value: a robot, 4096 steps |
//! | the gradient of thousands of time steps, from many starts | [`Rollout::run_batch`](crate::Rollout::run_batch) | about half of single runs (nine tenths with two starts), in lanes over the starts | 1.6 times the values: 64 starts |
//! | values and gradients of one function at many points | [`data::Recorded`](crate::data::Recorded) | a few, in lanes over the points | |
//! | the gradient of a sum over data, such as a network's loss | [`data::Sum`](crate::data::Sum) | a few, in lanes over the data | 0.8 to 1.0 times by hand: losses of three networks |
//! | Jacobians of one small function at many points | [`data::jacobians`](crate::data::jacobians) | one per input, in lanes over the points; a few with an [emitted](crate::emit::adjoint) adjoint | |
//! | the derivative of a solver's solution | [`implicit::root`] | two Jacobians | |
//! | a derivative whose rule you write yourself | [`custom`](crate::custom) | | |
//!
//! *Measured* are ratios of times: to one evaluation of the value, or to a derivative that is written by hand. In the
//! repository, `RAYON_NUM_THREADS=1 cargo bench -p benches --bench peers --features rivals` measures them, and
//! `cargo bench -p benches --bench instructions` counts the instructions of the robot. `benches/RESULTS.md`
//! has the tables, with machine and commit.
//!
//! A driver whose name ends in `_into` writes to buffers of the caller, as
//! [`value_and_gradient_into`] does. Newton's method takes
//! [`value_gradient_hessian`], Levenberg-Marquardt and Gauss-Newton take
//! [`value_and_jacobian`].
//!
//! # Nesting
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
mod fixed;
mod gradient;
mod jacobian;
mod hessian;
mod higher;
mod values;
mod lu;
pub mod implicit;
pub mod sparse;
#[cfg(feature = "rayon")]
pub mod parallel;

pub use dense::Dense;
pub use fixed::{value_and_gradient_array, value_and_jacobian_array};
pub use gradient::{Function, gradient, gradient_forward, value_and_gradient};
pub use hessian::{hessian, hessian_vector};
pub use higher::{Dual2, Dual3, Nested, ThirdDerivatives, derivatives, third_derivatives};
pub use jacobian::{jacobian, jacobian_reverse, jvp, vjp};
pub(crate) use seed::along;
#[cfg(feature = "nalgebra")]
pub(crate) use seed::{CHUNK, WIDE};
pub use values::{
    value_and_gradient_into, value_and_jacobian, value_and_jacobian_into, value_gradient_hessian,
    value_gradient_hessian_into,
};
