//! The largest time step with which a robot's vibrations stay bounded.
//!
//! [`Vibration`] computes the largest frequency at which a body vibrates about a state, and a cheap bound on this
//! frequency. [`stable_step`](crate::scene::stable_step) computes the largest stable time step of an integrator for a
//! given frequency.

mod lanczos;
mod vibration;

pub use vibration::Vibration;
