//! The functions of double-double numbers that need others of this crate.

mod real;

pub use crate::math::DoubleDouble;
