//! The drivers: functions that compute derivatives of whole functions. The guide says which one to use when.

mod dense;
mod seed;
mod fixed;
mod gradient;
mod jacobian;
mod hessian;
mod higher;
mod values;
pub(crate) mod lu;
pub mod implicit;
mod undecided;
pub mod sparse;
#[cfg(feature = "rayon")]
pub mod parallel;

pub use dense::Dense;
pub use fixed::{value_and_gradient_array, value_and_jacobian_array};
pub use gradient::{Function, gradient, gradient_forward, value_and_gradient};
pub use hessian::{hessian, hessian_vector};
pub use higher::{
    Dual2, Dual3, ThirdDerivatives, derivatives, derivatives_along, third_derivatives,
    value_and_derivative,
};
pub use jacobian::{jacobian, jacobian_reverse, jvp, vjp};
pub(crate) use seed::along;
#[cfg(feature = "nalgebra")]
pub(crate) use seed::{CHUNK, WIDE};
pub use values::{
    value_and_gradient_into, value_and_jacobian, value_and_jacobian_into, value_gradient_hessian,
    value_gradient_hessian_into,
};
