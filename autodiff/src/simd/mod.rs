//! SIMD lanes as a [`Real`](crate::Real): many evaluations at once.
//!
//! On x86-64, lanes are the widest registers of the processor, chosen at run time. Builds below optimisation level 2
//! have no AVX-512 lanes and no lanes of `f32`, which shortens compilation. A processor without AVX2 computes with
//! scalars, but replays recordings of the kernels of programs, which are only compiled in lanes. On aarch64, lanes are
//! NEON registers. On wasm32 they are `simd128` registers if the crate is compiled with `-C target-feature=+simd128`. On
//! all other targets, and in builds without optimisation, a register is a scalar, with a single lane.
//!
//! Each register width has its own type for f64 and for f32, because the instructions differ. The macro `define_lanes`
//! defines all of them.

mod lane;
mod unchecked;
mod level;
mod prefetch;
#[cfg(lanes)]
#[macro_use]
mod define;
#[cfg(any(lanes = "neon", lanes = "simd128"))]
mod narrow;
#[cfg(lanes = "neon")]
mod aarch64;
#[cfg(any(lanes = "simd128", all(test, lanes)))]
mod doubted;
#[cfg(lanes = "simd128")]
mod wasm;
#[cfg(lanes = "x86")]
mod avx2;
#[cfg(any(lanes_512, all(test, lanes = "x86")))]
mod avx512;
mod enter;
mod float;
#[cfg(all(test, lanes))]
mod tests;

#[doc(hidden)]
pub use lane::{WIDEST, lanes, lanes_with};
#[cfg(any(test, feature = "levels"))]
#[doc(hidden)]
pub use level::at_most;
pub use level::{Level, level, levels, limit};
#[doc(hidden)]
pub use prefetch::prefetch;
#[doc(hidden)]
pub use unchecked::Unchecked;

pub use crate::real::{Lane, Vectorized};
#[cfg(feature = "derive")]
pub use autodiff_derive::kernel;
