//! From a trajectory to a loss, from a mixture to its measures, and from both to the objective.

mod loss;
mod displacement;
mod measures;
mod augmented;
mod tasks;
mod any;

pub use any::{AnyLoss, LossOf, of_scene};
pub use augmented::{AugmentedLagrangian, violations};
pub use displacement::Displacement;
pub use loss::Loss;
pub use measures::{Measures, measures};
pub use tasks::Objective;
