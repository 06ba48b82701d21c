//! SIMD lanes as a [`Real`](crate::Real): many evaluations at once. On x86-64 they are the widest
//! registers that the processor has, chosen at run time; on aarch64 NEON. Nothing has to be set at compile
//! time, except on wasm32, whose `simd128` is chosen by `-C target-feature=+simd128`. Elsewhere a lane is
//! a scalar.

mod lane;
mod unchecked;
mod level;
mod prefetch;
#[cfg(lanes)]
#[macro_use]
mod define;
#[cfg(lanes)]
mod places;
#[cfg(any(lanes = "neon", lanes = "simd128"))]
mod narrow;
#[cfg(lanes = "neon")]
mod aarch64;
#[cfg(any(lanes = "simd128", test))]
mod doubted;
#[cfg(lanes = "simd128")]
mod wasm;
#[cfg(lanes = "x86")]
mod x86;
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
