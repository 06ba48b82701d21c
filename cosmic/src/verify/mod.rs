//! The program checks itself: what it computes against other ways to the same number, and what
//! it costs.

mod gradients;
mod speed;
pub mod stability;

pub use gradients::{GradientCheck, Group, NegativeControl, check_gradients};
pub use speed::{MEASURED_STEPS, Speed, Subject, TwoMatvecs, measure, peak_memory};
