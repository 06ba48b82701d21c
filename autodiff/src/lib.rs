//! Automatic differentiation behind one trait.

pub mod check;
pub mod custom;
pub mod drivers;
pub mod forward;
pub mod fused;
pub mod lanes;
pub mod real;
pub mod reverse;
mod rule;

pub use drivers::{
    Function, VectorFunction, gradient, gradient_of, hessian, hessian_vector, jacobian, jvp,
    value_and_gradient, vjp,
};
pub use forward::Dual;
pub use fused::Fused;
pub use real::{Mask, Real};
pub use reverse::{Tape, Var};
