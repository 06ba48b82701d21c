//! Checks the program's numbers against other ways to compute them, and measures their cost.

mod accuracy;
mod chaos;
mod clock;
mod gradcheck;
mod gradients;
mod plan;
mod probe;
mod speed;
mod stability;

pub use accuracy::accuracy;
pub use clock::{measured, peak_memory};
pub use gradcheck::{GradientCheck, Group, NegativeControl, check_gradients, check_gradients_of};
pub use gradients::gradients;
pub use plan::{Plan, Term};
pub use probe::frequencies;
pub use speed::{MEASURED_STEPS, Speed, Subject, TwoMatvecs, measure};
pub use stability::stability;
