//! Optimisers. They work on slices of `f64` and do not know anything about robots.
//!
//! Each optimiser has settings, a method `init` that returns its initial state, and a method `update` that advances the
//! state. States are plain data. If a state is saved with all digits and read back, the optimisation continues with the
//! same bits.
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
