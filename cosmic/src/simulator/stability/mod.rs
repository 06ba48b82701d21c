//! The largest time step with which a robot's vibrations stay bounded.
//!
//! [`Vibration`] has the frequencies of a body about a state, and cheap bounds on them;
//! [`bound_of_any_design`] bounds those of every design of a lattice; [`stable_step`] is the time
//! step that an integrator stands at a frequency.

mod lanczos;
mod limit;
mod vibration;
mod any_design;

pub use any_design::bound_of_any_design;
pub use limit::{phase_limit, stable_step, step_limit};
pub use vibration::Vibration;
