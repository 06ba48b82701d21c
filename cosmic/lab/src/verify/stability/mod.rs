//! Robots at the extremes: the promise of the stable time step, and their motion.
//!
//! A row is stable if its time step is below the limit of its largest frequency. Then nothing may grow.
//! Otherwise the check of the time step must have said so, and something must grow. No number may cease
//! to be finite without a message.

mod extremes;
mod sheet;
mod trial;

pub use sheet::{stability, stable_steps};
pub use trial::{Found, Outcome, Trial, World};

#[cfg(test)]
mod tests;
