//! Sums and maps over data: one function at many points.
//!
//! - [`values`] and [`jacobians`] evaluate a [`Kernel`](crate::Kernel) at many points in SIMD lanes, for
//!   example for a sparse Jacobian whose rows all have the same number of entries.
//! - [`Sum`] adds up a function of shared parameters over data, for example a likelihood. The gradient by
//!   all parameters costs a few sums.
//! - [`Recorded`] is a function that is recorded once and replayed at many points, with its gradient at each
//!   point or summed over points that are variables.

mod kernels;
mod recorded;
mod sum;

pub use kernels::{LocalJacobian, jacobians, values};
pub use recorded::{NeedsValues, Recorded};
pub use sum::{Sum, Summand};
