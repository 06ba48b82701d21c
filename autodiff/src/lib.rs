//! Automatic differentiation behind one trait.

pub mod check;
pub mod custom;
pub mod drivers;
mod elementary;
pub mod forward;
pub mod fused;
pub mod kernel;
pub mod lanes;
pub mod program;
pub mod real;
pub mod reverse;
pub mod rollout;
mod rule;

pub use drivers::{
    Function, VectorFunction, gradient, gradient_of, hessian, hessian_vector, jacobian, jvp,
    value_and_gradient, vjp,
};
pub use forward::Dual;
pub use fused::Fused;
pub use kernel::{Adjoint, Kernel};
pub use program::{Array, Graph, Matrix, Program};
pub use real::{Mask, Real};
pub use reverse::{Tape, Var};
pub use rollout::{CotangentBound, Model, Rollout};
