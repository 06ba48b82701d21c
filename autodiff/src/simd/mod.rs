//! SIMD lanes as a [`Real`](crate::Real): many evaluations at once.
//!
//! On x86-64 lanes are the widest registers of the processor, chosen at run time. On aarch64 they are NEON
//! registers. On wasm32 they are `simd128` registers if the crate is compiled with
//! `-C target-feature=+simd128`. Elsewhere a lane is a scalar.
//!
//! Each width of each float is a type, because the instructions differ. One macro, `define_lanes`, makes them
//! numbers.

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
