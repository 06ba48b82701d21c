//! Sums and maps over data: one function at many points.
//!
//! - [`values`] and [`jacobians`] evaluate a [`Kernel`](crate::Kernel) at many points in SIMD lanes,
//!   for a sparse Jacobian whose rows have a fixed number of entries.
//! - [`Sum`] adds up a function of shared parameters over data, a likelihood for example; its gradient
//!   by all parameters costs a few times as much as the sum.
//! - [`Recorded`] is a function recorded once and replayed at many points, with its gradient.
//! - [`total`] adds up a kernel over arrays of variables.

mod kernels;
mod recorded;
mod sum;
mod total;

pub use kernels::{LocalJacobian, jacobians, values};
pub use recorded::{NeedsValues, Recorded};
pub use sum::{Sum, Summand};
pub use total::total;
