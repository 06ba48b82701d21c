//! Designs of robots, in three forms:
//!
//! - The optimiser works on design vectors: three numbers from 0 to 1 for each edge.
//! - A [projection](crate::projection) turns each design vector into a [`Mixture`]: shares of the three materials.
//! - A layout has one [`Material`] for each edge, and can be built.
//!
//! A [`Design`] holds one of these forms for all edges.

mod mixture;
mod layout;
mod vectors;
mod tilt;
mod start;
mod structure;
mod snap;

pub use crate::lattice::Material;
pub use layout::Design;
pub use mixture::{Mixture, volumes};
pub use snap::{VolumeBounds, alternatives, flipped, flips, snap, solid_and_actuators};
pub use start::{filled, layout_materials, start};
pub(crate) use structure::is_present;
pub use structure::{LayoutRules, MOST_RANKED, Structure, joined_to_payload};
pub use tilt::tilted;
pub(crate) use vectors::average_tied;
pub use vectors::{attract, clamp};
