//! The loss of a trajectory, the measures of mixtures, and the augmented objective, which is made of both.

mod loss;
mod displacement;
mod measures;
mod augmented;
mod tasks;
mod errand;
mod any;

pub(crate) use any::of_window;
pub use any::{AnyLoss, LossOf, loss_of, of_scene, walks};
pub use augmented::{AugmentedLagrangian, violations};
pub use displacement::Displacement;
pub use errand::Errand;
pub use loss::Loss;
pub use measures::{Measures, measures};
pub use tasks::Objective;
