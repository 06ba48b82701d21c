//! One function at many points.
//!
//! - [`values`] and [`jacobians`] take a [`Kernel`](crate::Kernel) to many points in SIMD lanes:
//!   a sparse Jacobian whose rows have a fixed number of entries.
//! - [`Sum`] adds up a function of shared parameters over data, a likelihood for example, and
//!   has its gradient by all parameters for a few times the cost of the sum.

mod kernels;
mod replay;
mod sum;
mod trace;

pub use kernels::{LocalJacobian, jacobians, values};
pub use sum::{Sum, Summand};
