//! The program's checks of itself: its numbers against other ways to compute them, and their cost.

mod accuracy;
mod chaos;
mod clock;
mod gradients;
mod plan;
mod probe;
mod slopes;
mod speed;
pub mod stability;
mod step;
mod voids;

pub use accuracy::{Accuracy, Energy, Method, Precision, Reference, Run};
pub use chaos::Chaos;
pub use clock::{measured, peak_memory};
pub use gradients::{GradientCheck, Group, NegativeControl, check_gradients, check_gradients_of};
pub use plan::{Plan, Term};
pub use slopes::{Gradients, Slopes, Way};
pub use speed::{GradientError, MEASURED_STEPS, Speed, Subject, Times, TwoMatvecs, measure};
pub use step::stable_steps;
pub use voids::{Pull, Voids};
