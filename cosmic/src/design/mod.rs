//! Materials and design vectors: what the optimiser moves, before any projection.
//!
//! A design is one vector `z` in `[0, 1]^3` per edge: void, skeleton, actuator.

mod material;
mod tilt;
mod start;
mod structure;
mod snap;

pub use material::{Material, attract, clamp, dominant, one_hot, vectors_of_mixture};
pub use snap::{VolumeBounds, alternatives, flipped, flips, snap};
pub use start::{filled, layout_materials, start_vectors};
pub use structure::{LayoutRules, MOST_RANKED, Structure, joined_to_payload};
