//! Instruments: checks of gradients, origins of NaN, rounding errors.

pub mod check;
pub mod double_double;
pub mod trace;

pub use double_double::DoubleDouble;
