//! Is it right? Compares the program's numbers with those of other methods.
//!
//! Each part of the check is a function that returns a [`Section`](crate::report::sheet::Section): the [`plan()`] of a
//! step, its [`gradient()`], the [`distance()`] that the robot covers, and on demand [`accuracy()`] and [`stability()`].

pub mod accuracy;
mod clock;
pub mod distance;
pub mod gradient;
pub mod loads;
pub mod plan;
mod probe;
pub mod stability;

pub use clock::seconds;
pub use distance::distance;
pub use gradient::{
    GradientCheck, Group, NegativeControl, check_gradients, check_gradients_of, gradient,
};
pub use loads::accuracy;
pub use plan::{Term, plan, terms};
pub use stability::stability;
