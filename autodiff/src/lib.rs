//! Automatic differentiation behind one trait.

mod elementary;
pub mod fused;
pub mod lanes;
pub mod real;

pub use fused::Fused;
pub use real::{Mask, Real};
