//! Checks the program's numbers against other ways to compute them, and measures their cost.

pub mod accuracy;
mod bare;
pub mod chaos;
mod clock;
pub mod distance;
pub mod gradcheck;
pub mod gradients;
mod plan;
pub mod probe;
mod speed;
pub mod stability;
pub mod stiff;
mod subject;

pub use accuracy::accuracy;
pub use bare::Bare;
pub use clock::{measured, peak_memory};
pub use distance::distance;
pub use gradcheck::{GradientCheck, Group, NegativeControl, check_gradients, check_gradients_of};
pub use gradients::gradients;
pub use plan::{Plan, Term};
pub use probe::{frequencies, step_off_bars};
pub use speed::{MEASURED_STEPS, Speed, Subject, TwoMatvecs, measure};
pub use stability::stability;
pub use stiff::stiff;
