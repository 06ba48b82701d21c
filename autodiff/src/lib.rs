//! Automatic differentiation behind one trait.
//!
//! Write a function once, generic over [`Real`]. The same source runs on plain floats, in SIMD lanes, on dual numbers
//! and on a reverse tape. This gives its value, its derivative along a direction, its gradient, its Jacobian and its
//! Hessian.
//!
//! ```
//! use autodiff::{Real, gradient, hessian, lit};
//!
//! /// `lit` makes a constant on either side of an operator.
//! fn well<R: Real>(x: &[R]) -> R {
//!     (x[0].powi(2) - lit(1.0)).powi(2) + lit(0.5) * x[1] * x[1]
//! }
//!
//! assert_eq!(gradient(well, &[2.0, 3.0]), [24.0, 3.0]);
//! assert_eq!(hessian(well, &[2.0, 3.0]), [[44.0, 0.0], [0.0, 1.0]]);
//! // A closure is enough for one derivative. Floats are constants in it.
//! assert_eq!(gradient(|x| 0.5 * x[0] * x[0] + 1.0, &[3.0]), [3.0]);
//! ```
//!
//! | to get | use | cost in evaluations |
//! | --- | --- | --- |
//! | a derivative along a direction | [`jvp`] | about 2 |
//! | the gradient of one scalar with respect to many arguments | [`gradient`], [`value_and_gradient`] | a few for array operations, tens for scalar operations on the tape, for any number of arguments |
//! | the gradient with respect to a handful of arguments | [`gradient_forward`] | 2 to 3 for every four arguments; no tape |
//! | the cotangents of several values at once | [`vjp`] | like `gradient` |
//! | a Jacobian | [`jacobian`], [`value_and_jacobian`] | 2 to 3 for every four arguments |
//! | a Jacobian of few values with respect to many arguments | [`jacobian_reverse`] | one recording, one sweep per value |
//! | a Jacobian that is mostly zeros | [`sparse_jacobian`] | one direction per colour of its columns: 3 for a tridiagonal Jacobian of any size |
//! | a Hessian times a vector | [`hessian_vector`] | a few gradients |
//! | a Hessian | [`hessian`], [`value_gradient_hessian`] | a few gradients for every four arguments |
//! | a Hessian that is mostly zeros | [`sparse_hessian`] | a gradient per colour |
//! | the gradient of thousands of time steps | [`Rollout`] of a [`Model`] | a few; memory grows only with the state |
//! | the gradient of thousands of time steps, from many starts | [`Rollout::run_batch`] | about half of single runs (nine tenths with two starts), in lanes over the starts |
//! | values and gradients of one function at many points | [`data::Recorded`] | a few, in lanes over the points |
//! | the gradient of a sum over data, such as a network's loss | [`data::Sum`] | a few, in lanes over the data |
//! | Jacobians of one small function at many points | [`data::jacobians`] | one per input, in lanes over the points; a few with an [emitted](emit::adjoint) adjoint |
//! | the derivative of a solver's solution | [`implicit::root`] | two Jacobians |
//! | a derivative whose rule you write yourself | [`custom`] | |
//!
//! Every driver takes the function, then the point, then any other arguments. A driver whose name ends in `_into`
//! writes to buffers of the caller, as [`value_and_gradient_into`] does. [`check`] tells whether a gradient is
//! right. [`trace`] finds where a NaN came from. [`DoubleDouble`] runs the same source in 31 digits to show rounding
//! errors.
//!
//! - [`guide`]: writing functions, the traits, many time steps, the terms;
//! - [`real`]: the value of the derivative at every kink;
//! - the folder `examples`: short programs, listed in the README.
//!
//! # Pitfalls
//!
//! The [guide](guide#pitfalls) lists them: kinks, `if` on values, intermediate overflow, `sqrt` of zero, aliasing,
//! builds without optimisation.
//!
//! # Features
//!
//! - `data`, on by default: sums and maps over [`data`] are compiled for floats in this crate. Without it,
//!   this crate compiles in half the time, and each crate that has such a sum compiles 7 s longer;
//! - `rollouts`, on by default: the same for the steps of a [`Rollout`];
//! - `derive`: `#[derive(Parameters)]` for structures of [`parameters`];
//! - `nalgebra`: [`Element`] in nalgebra's matrices, module `nalgebra`;
//! - `rayon`: Jacobians and Hessians on several cores, module `parallel`.
//!
//! # Versions
//!
//! Within a compatible version, new methods of [`Real`] and of the traits for functions come with defaults. Errors,
//! results and the settings [`check::Options`] and [`Rollout`] may get new fields or variants. Build settings from
//! their defaults: `Options { seed: 1, ..Options::default() }`.

// The crate's own name, so that unit tests in `src` can share helper files with the tests in `tests`.
#[cfg(test)]
extern crate self as autodiff;

// The modules are in the order of the architecture: each module uses only those above it.
mod literal;
mod mask;
mod operators;
mod elementary;
mod dual;
pub mod real;
mod constant;
mod rule;
mod math;
pub mod simd;
mod product;
pub mod fused;
mod forward;
mod pool;
mod restored;
mod reverse;
pub mod custom;
pub mod arrays;
mod record;
pub mod steps;
pub mod drivers;
pub mod data;
pub mod parameters;
pub mod interop;
pub mod diagnose;

#[doc = include_str!("../guide.md")]
pub mod guide {}

pub use arrays::{Array, Graph, Kernel, Matrix, Pullback};
pub use constant::lit;
pub use diagnose::{DoubleDouble, check, trace};
#[cfg(feature = "rayon")]
pub use drivers::parallel;
pub use drivers::{
    Dense, Function, gradient, gradient_forward, hessian, hessian_vector, implicit, jacobian,
    jacobian_reverse, jvp, sparse,
    sparse::{sparse_hessian, sparse_jacobian},
    value_and_gradient, value_and_gradient_into, value_and_jacobian, value_and_jacobian_into,
    value_gradient_hessian, value_gradient_hessian_into, vjp,
};
pub use dual::Dual;
pub use elementary::Elementary;
pub use interop::Element;
#[cfg(feature = "nalgebra")]
pub use interop::nalgebra;
pub use parameters::Parameters;
pub use real::{Fused, Mask, Real};
pub use record::emit;
pub use reverse::{Tape, Var};
pub use steps::{AnyProgram, CotangentBound, Given, Memory, Model, Program, Rollout};

/// The code of the README, so that the documentation tests compile and run it.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
