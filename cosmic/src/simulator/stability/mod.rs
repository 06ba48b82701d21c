//! The largest time step with which a robot's vibrations stay bounded.
//!
//! [`Vibration`] computes the largest frequency of a body about a state, and cheap bounds on it.
//! [`bound_of_any_design`] is a bound for every design of a lattice. [`stable_step`] is the largest stable time step of
//! an integrator for a given frequency.

mod lanczos;
mod limit;
mod vibration;
mod any_design;

pub use any_design::bound_of_any_design;
pub use limit::{phase_limit, stable_step, step_limit};
pub use vibration::Vibration;
