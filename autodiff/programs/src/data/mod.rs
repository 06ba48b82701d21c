//! Evaluates one function at many points: separately at each point, or summed over data.
//!
//! - [`values`] and [`jacobians`] evaluate a [`Kernel`](crate::Kernel) at many points in SIMD lanes, for
//!   example for a sparse Jacobian whose rows all have the same number of entries.
//! - [`Sum`] adds up a function of shared parameters over data, for example a likelihood. The gradient with respect
//!   to all parameters costs as much as a few sums.
//! - [`Recorded`] is a function that is recorded once and replayed at many points. It returns the value and the
//!   gradient at each point. It can also add up the values at points that are variables themselves.

mod kernels;
mod recorded;
mod sum;

pub use kernels::{LocalJacobian, jacobians, values};
pub use recorded::{NeedsValues, Recorded};
pub use sum::{Sum, Summand};
