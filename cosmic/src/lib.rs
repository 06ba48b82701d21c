//! Co-design of truss-lattice robots: structure, material and neural control optimised together.
//!
//! The order of the modules is the architecture: each imports only modules above it.

pub mod random;
pub mod lattice;
pub mod design;
pub mod projection;
pub mod controller;
pub mod simulator;
pub mod objective;
pub mod optimiser;
