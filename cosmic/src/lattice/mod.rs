//! The parts of a simulated robot: nodes and edges, the body that a design gives them, and the state, which changes in
//! a rollout.

mod material;
mod state;
mod own;
mod check;
mod truss;
mod body;
mod mirror;
mod rigidity;
mod doubts;

pub use body::{Body, Marker, SCALABLE};
pub(crate) use doubts::Doubt;
pub use material::Material;
pub use own::{EdgeRules, Mirror, Payload, Sides, Truss};
pub(crate) use rigidity::floppy_modes;
pub use state::State;
pub use truss::{EdgeVector, Lattice};
