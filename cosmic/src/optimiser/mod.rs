//! Optimisers: slices of `f64` in, slices of `f64` out. They know no robot.
//!
//! Each has settings, an `init` that gives its state, and an `update` that moves the state on. A
//! state is plain data: written with enough digits and read back, it goes on bit for bit.
//!
//! | optimiser | for |
//! | --- | --- |
//! | [`mma`] | bounded variables under a few inequality constraints: the design vectors |
//! | [`adam`] | many free variables and a noisy gradient: the controller |

pub mod adam;
mod error;
pub mod mma;

pub use adam::{Adam, AdamState, bound_norm};
pub use error::OptimiserError;
pub use mma::{Linearisation, Mma, MmaDiagnostics, MmaState, Update};
