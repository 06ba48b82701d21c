//! Optimisers. They take and return slices of `f64` and know no robot.
//!
//! Each optimiser has settings, an `init` that returns its state, and an `update` that advances the state. States are
//! plain data: a state that is saved with enough digits and read back continues bit for bit.
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
