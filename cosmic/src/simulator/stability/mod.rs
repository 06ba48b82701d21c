//! The largest time step with which a robot's vibrations stay bounded.
//!
//! [`Vibration`] computes the largest frequency at which a body vibrates about a state, and cheap bounds on this
//! frequency. [`bound_of_any_design`] computes a bound that holds for every design of a lattice. [`stable_step`]
//! computes the largest stable time step of an integrator for a given frequency.

mod lanczos;
mod limit;
mod vibration;
mod any_design;

pub use any_design::bound_of_any_design;
pub use limit::{phase_limit, stable_step, step_limit};
pub use vibration::Vibration;
