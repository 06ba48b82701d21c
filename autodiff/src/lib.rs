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
//! | module | what it has |
//! | --- | --- |
//! | [`guide`] | how to write functions, what compiler errors mean, **which [driver](guide#drivers) to use when** ([`gradient`], [`jacobian`], [`hessian`], [`jvp`] and others, with their costs), many time steps, the terms, and the pitfalls with their wrong numbers |
//! | [`real`] | the number trait, and the value of the derivative at every kink |
//! | [`sparse`], [`implicit`], [`custom`] | large Jacobians, solutions of equations, derivatives of your own |
//! | [`Program`], [`Rollout`], [`data`] | thousands of time steps, sums over data, many points: recorded once, run in SIMD lanes |
//! | [`parameters`] | nested structures of parameters instead of one slice |
//! | [`interop`] | code over num-traits' `Float`, nalgebra's matrices, complex numbers |
//! | [`check`], [`trace`], [`DoubleDouble`] | is a gradient right, where does a NaN come from, how large are rounding errors |
//!
//! The folder `examples` has short programs, which the README lists.
//!
//! # Features
//!
//! - `data`, on by default: sums and maps over [`data`] are compiled for floats in this crate. Without it,
//!   this crate compiles in half the time, and each crate that has such a sum compiles 7 s longer;
//! - `rollouts`, on by default: the same for the steps of a [`Rollout`];
//! - `derive`, on by default: the attribute `#[kernel]` for every [`Kernel`], and `#[derive(Parameters)]` for
//!   structures of [`parameters`];
//! - `nalgebra`: [`Element`] in nalgebra's matrices, module `matrices`;
//! - `rayon`: Jacobians and Hessians on several cores, module `parallel`;
//! - `wgsl`: programs printed for GPUs, module `wgsl`.
//!
//! # Versions
//!
//! Within a compatible version, new methods of [`Real`] and of the traits for functions come with defaults. Errors,
//! results and the settings [`check::Options`] and [`Rollout`] may get new fields or variants. Build settings from
//! their defaults: `Options { seed: 1, ..Options::default() }`.

// The modules are in the order of the architecture: each module uses only those above it.
mod literal;
mod mask;
mod operators;
mod elementary;
mod composed;
mod dual;
pub mod real;
mod constant;
mod rule;
mod math;
pub mod simd;
mod product;
mod parts;
pub mod fused;
mod forward;
mod pool;
mod restored;
mod reverse;
pub mod custom;
mod arrays;
mod record;
mod steps;
#[cfg(feature = "wgsl")]
pub mod wgsl;
mod drivers;
pub mod data;
pub mod parameters;
pub mod interop;
mod diagnose;

#[doc = include_str!("../guide.md")]
pub mod guide {}

/// For kernels that have their own [`Kernel::vjp`], such as one that [`emit`] printed.
pub mod kernels {
    #[doc(inline)]
    pub use crate::arrays::{Fixed, MOST_UNIFORMS, constants, pulled_back, seeded, vjp_by_duals};
}

#[doc(inline)]
pub use arrays::{Array, Graph, Kernel, Matrix, Pullback};
#[cfg(feature = "derive")]
pub use autodiff_derive::kernel;
pub use constant::lit;
#[doc(inline)]
pub use diagnose::{DoubleDouble, check, trace};
#[cfg(feature = "rayon")]
#[doc(inline)]
pub use drivers::parallel;
#[doc(inline)]
pub use drivers::{
    Dense, Dual2, Dual3, Function, ThirdDerivatives, derivatives, derivatives_along, gradient,
    gradient_forward, hessian, hessian_vector, implicit, jacobian, jacobian_reverse, jvp, sparse,
    sparse::{sparse_hessian, sparse_jacobian},
    third_derivatives, value_and_derivative, value_and_gradient, value_and_gradient_array,
    value_and_gradient_into, value_and_jacobian, value_and_jacobian_array, value_and_jacobian_into,
    value_gradient_hessian, value_gradient_hessian_into, vjp,
};
pub use dual::Dual;
pub use elementary::Elementary;
#[doc(inline)]
pub use interop::Element;
#[cfg(feature = "nalgebra")]
#[doc(inline)]
pub use interop::matrices;
#[doc(inline)]
pub use parameters::Parameters;
#[doc(inline)]
pub use real::{Fused, Mask, Real};
pub use record::emit;
pub use reverse::{Tape, Var};
#[doc(inline)]
pub use steps::{CotangentBound, Given, Memory, Model, Program, Rollout};

/// The code of the README, so that the documentation tests compile and run it.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
