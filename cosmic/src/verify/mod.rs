//! The program checks itself: what it computes against other ways to the same number.

mod gradients;

pub use gradients::{GradientCheck, Group, NegativeControl, check_gradients};
