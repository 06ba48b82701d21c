//! Diagnostics: checks gradients, finds where a NaN comes from, and shows rounding errors.

pub mod check;
mod double_double;
pub mod trace;

pub use double_double::DoubleDouble;
