//! Instruments: is a gradient right, where did a NaN come from, what does rounding do.

pub mod check;
pub mod double_double;
pub mod trace;

pub use double_double::DoubleDouble;
