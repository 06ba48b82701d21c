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
//! | [`guide`] | how to write functions, what compiler errors mean, **which [driver](guide#drivers) to use when** ([`gradient`], [`jacobian`], [`hessian`], [`jvp`] and others, with their costs), the terms, and the pitfalls with their wrong numbers |
//! | [`real`] | the number trait, and the value of the derivative at every kink |
//! | [`sparse`], [`implicit`], [`custom`] | large Jacobians, solutions of equations, derivatives of your own |
//! | [`parameters`] | nested structures of parameters instead of one slice |
//! | [`interop`] | code over num-traits' `Float`, nalgebra's matrices, complex numbers |
//! | [`check`], [`trace`], [`DoubleDouble`] | is a gradient right, where does a NaN come from, how large are rounding errors |
//!
//! The crate `cosmic-autodiff-programs` has thousands of time steps, sums over data and functions at many points: recorded
//! once, run in SIMD lanes. The folder `examples` has short programs, which the README lists.
//!
//! To read the source, begin with `real.rs`, the trait, and `rule.rs`, the derivative of each function. Then `forward.rs`
//! has forward mode in one file, `reverse/var.rs` and `reverse/tape.rs` begin reverse mode, and `drivers/gradient.rs` joins
//! them. The list of modules in `lib.rs` goes from the bottom to the top.
//!
//! # Features
//!
//! - `derive`, on by default: `#[derive(Parameters)]` for structures of [`parameters`], and the attribute `#[kernel]` for
//!   code in [lanes](simd);
//! - `nalgebra`: [`Element`] in nalgebra's matrices, module `matrices`;
//! - `rayon`: Jacobians and Hessians on several cores, module `parallel`.
//!
//! # Versions
//!
//! Within a compatible version, new methods of [`Real`] and of the traits for functions come with defaults. Errors,
//! results and the settings [`check::Options`] may get new fields or variants. Build settings from their defaults:
//! `Options { seed: 1, ..Options::default() }`.

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
mod parts;
pub mod fused;
mod forward;
mod pool;
mod restored;
mod reverse;
pub mod custom;
mod drivers;
pub mod parameters;
pub mod interop;
mod diagnose;

#[doc = include_str!("../guide.md")]
pub mod guide {}

/// What `cosmic-autodiff-programs` uses of this crate. It may change in any version.
#[doc(hidden)]
pub mod internal {
    pub use crate::diagnose::trace::{Line, begin_line, begin_step, replaying, running};
    pub use crate::forward::seeded;
    pub use crate::literal::{Accepts, Literal};
    pub use crate::math::by_squaring;
    pub use crate::parts::SumByParts;
    pub use crate::product::{Cotangents, Factors, Product, Strided, Transpose, fits_registers};
    pub use crate::real::of_floats;
    pub use crate::restored::Restored;
    #[cfg(feature = "levels")]
    pub use crate::simd::at_most;
    pub use crate::simd::{Unchecked, WIDEST, lanes, lanes_with, prefetch};
    pub use crate::{functions, literal_operators, operators};

    /// Whether lanes are the registers of WebAssembly.
    pub const IS_SIMD128: bool = cfg!(lanes = "simd128");

    /// The derivative of each function.
    pub mod rule {
        pub use crate::rule::{
            abs, atan2, cos, div, exp, hypot, layer_tanh, ln, mul, powf, powi, recip, rsqrt, sin,
            sqrt, tan, tanh,
        };
    }

    /// Buffers that a thread keeps.
    pub mod pool {
        pub use crate::pool::{MOST_BYTES, Pooled, keep, take};
    }
}

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
pub use reverse::{Tape, Var};

/// The code of the README, so that the documentation tests compile and run it.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
