//! Diagnostics: gradient checks, the origin of a NaN, and rounding errors.

pub mod check;
pub mod double_double;
pub mod trace;

pub use double_double::DoubleDouble;
