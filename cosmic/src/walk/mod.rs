//! What is read from a walk: the loads and the motion of bars, the energy that a robot needs, and the step in which a walk
//! diverged.
//!
//! The functions of this module take a [`World`](crate::world::World). They simulate only with its verb and do not record steps.

mod magnitude;
mod loads;
mod energy;
mod idle_energy;
mod blame;
mod divergence;

pub use blame::Cause;
pub(crate) use divergence::watched;
pub use divergence::{Divergence, GuardedRollout, divergence, guarded};
pub use energy::{Energy, LoadsAndEnergy};
pub use idle_energy::IdleEnergy;
pub use loads::{BarLoad, EdgeMoments, Loads, bar_loads, moments};
pub use magnitude::{Largest, Magnitude};
