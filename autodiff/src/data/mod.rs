//! Sums and maps over data: one function at many points.
//!
//! - [`values`] and [`jacobians`] evaluate a [`Kernel`](crate::Kernel) at many points in SIMD lanes, for
//!   example for a sparse Jacobian whose rows all have the same number of entries.
//! - [`Sum`] adds up a function of shared parameters over data, for example a likelihood. The gradient with respect
//!   to all parameters costs as much as a few sums.
//! - [`Recorded`] is a function that is recorded once and replayed at many points. It returns the gradient at each
//!   point, or a sum over points that are variables.

mod kernels;
mod recorded;
mod sum;

pub use kernels::{LocalJacobian, jacobians, values};
pub use recorded::{NeedsValues, Recorded};
pub use sum::{Sum, Summand};
