//! The program checks itself: what it computes against other ways to the same number, and what
//! it costs.

mod chaos;
mod gradients;
mod probe;
mod speed;
mod step;

pub use chaos::{Chaos, Predictable};
pub use gradients::{GradientCheck, Group, NegativeControl, check_gradients};
pub use speed::{MEASURED_STEPS, Speed, Subject, TwoMatvecs, measure, peak_memory};
pub use step::stable_steps;
