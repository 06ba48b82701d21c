//! SIMD lanes as a [`Real`](crate::Real): many evaluations at once, in the widest registers that the
//! processor has, chosen at run time. Nothing has to be set at compile time.

mod lane;
mod unchecked;
mod level;
mod prefetch;
#[cfg(target_arch = "x86_64")]
mod x86;
#[cfg(target_arch = "x86_64")]
mod enter;
mod float;
#[cfg(test)]
mod tests;

pub(crate) use lane::{WIDEST, lanes};
#[cfg(test)]
pub(crate) use level::at_most;
pub use level::{Level, level};
pub(crate) use prefetch::prefetch;
pub(crate) use unchecked::Unchecked;

pub use crate::real::{Lane, Vectorized};
