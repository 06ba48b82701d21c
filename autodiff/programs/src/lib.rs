//! Array programs whose derivatives come from [`autodiff`]: code is recorded once and runs many times in SIMD lanes, forward
//! and in reverse.
//!
//! - A [`Kernel`] is a function of a few numbers, which may have names: [`Fields`]. A [`Model`] connects kernels to a step
//!   over arrays. A [`Rollout`] runs the step thousands of times, and its gradient takes little memory.
//! - A [`Sum`](data::Sum) adds up a function over data. A [`Recorded`](data::Recorded) function returns its values and
//!   gradients at many points.
//!
//! To the functions and drivers of [`autodiff`], a rollout or a sum is one operation, in every mode.
//!
//! ```
//! use autodiff::{Real, Var, gradient};
//! use autodiff_programs::{Kernel, Model, Program, Rollout, kernel};
//!
//! /// A step of 0.01 s of an oscillator.
//! #[derive(Clone)]
//! struct Spring;
//!
//! #[kernel]
//! impl Kernel<3, 2> for Spring {
//!     fn eval<R: Real>(&self, [x, v, stiffness]: [R; 3], _: &[R]) -> [R; 2] {
//!         let v = v - R::lit(0.01) * stiffness * x;
//!         [x + R::lit(0.01) * v, v]
//!     }
//! }
//!
//! impl Model for Spring {
//!     fn record(&self, program: &mut Program) {
//!         let stiffness = program.parameter(1);
//!         let (x, v) = (program.state(1), program.state(1));
//!         let next = program.map(Spring, [x, v, stiffness], &[]);
//!         program.advance(x, next[0]);
//!         program.advance(v, next[1]);
//!     }
//! }
//!
//! let rollout = Rollout::new(Spring, 100);
//! let place = |k: &[Var<f64>]| rollout.run(&[Var::lit(1.0), Var::lit(0.0)], &[k])[0];
//! // The place after one second is about cos(sqrt(k)).
//! let slope = gradient(place, &[4.0])[0];
//! assert!((slope + 2.0_f64.sin() / 4.0).abs() < 0.01);
//! ```
//!
//! | module | what it has |
//! | --- | --- |
//! | [`guide`] | how to write a step, which of these types to use when |
//! | [`data`] | values, gradients and sums over many points |
//! | [`emit`] | the adjoint of a kernel as source code |
//! | [`operations`] | operations on whole arrays that your crate adds |
//! | [`kernels`] | for kernels that have their own [`Kernel::vjp`] |
//!
//! This crate compiles the operations of a step, and replays of recordings, for floats. Your crate compiles its kernels.

// The modules are in the order of the architecture: each module uses only those above it.
mod arrays;
mod record;
mod steps;
pub mod data;

#[doc = include_str!("../guide.md")]
pub mod guide {}

/// For kernels that have their own [`Kernel::vjp`], such as one that [`emit`] printed.
pub mod kernels {
    #[doc(inline)]
    pub use crate::arrays::{Fixed, MOST_UNIFORMS, constants, pulled_back, vjp_by_duals};
    #[doc(inline)]
    pub use autodiff::internal::seeded;
}

/// Operations on arrays that your crate adds to steps.
pub mod operations {
    #[doc(inline)]
    pub use crate::arrays::{ArrayOperation, Forward, InputBars, InputValues, Reverse, each};
}

/// What `cosmic-gpu` reads of a program to print it, and `cosmic` exports. It may change in any version.
#[doc(hidden)]
pub mod internal {
    /// The trait without the macro of this name, for a crate that has the macro already.
    pub use crate::arrays::Fields;
    pub use crate::arrays::{Gather, Layer, NodeSum, Parameter, SlotEdge};
    pub use crate::record::operation::{Binary, Logic, Op, Place, Unary};
    pub use crate::record::{Formula, Places, ReplayedKernel};
    pub use crate::steps::{AddedOperation, Parts, StepOperation, check_bounds, check_units};
}

/// The folder of this crate's source files, as the compiler writes it.
const SOURCES: &str = file!().split_at(file!().len() - "lib.rs".len()).0;

#[doc(inline)]
pub use arrays::{Array, Compiled, Fields, Graph, Kernel, Matrix, Pullback};
#[cfg(feature = "derive")]
pub use autodiff_derive::{Fields, kernel};
pub use record::emit;
#[doc(inline)]
pub use steps::{CotangentBound, Given, Memory, Model, Program, Rollout};

/// The code of the README, so that the documentation tests compile and run it.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
