//! The lattice: nodes on a square grid above the ground, edges between neighbours.

mod state;
mod grid;

pub use grid::{Lattice, edges};
pub use state::State;
pub(crate) use state::mean;
