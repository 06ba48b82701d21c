//! Sums and maps over data: one function at many points.
//!
//! - [`values`] and [`jacobians`] evaluate a [`Kernel`](crate::Kernel) at many points in SIMD lanes,
//!   for a sparse Jacobian whose rows have a fixed number of entries.
//! - [`Sum`] adds up a function of shared parameters over data, a likelihood for example; its gradient
//!   by all parameters costs a few times as much as the sum.
//! - [`Recorded`] is a function recorded once and replayed at many points: with its gradient at each, or
//!   summed over points that are variables.

mod kernels;
mod recorded;
mod sum;

pub use kernels::{LocalJacobian, jacobians, values};
pub use recorded::{NeedsValues, Recorded};
pub use sum::{Sum, Summand};
