//! Designs of robots, from what the optimiser moves to what is built.
//!
//! - The optimiser moves a design vector per edge: three numbers from 0 to 1.
//! - A [projection](crate::projection) turns each vector into a [`Mixture`]: shares of the materials.
//! - A layout has one [`Material`] per edge.
//!
//! A [`Design`] is one of these for all edges.

mod material;
mod mixture;
mod layout;
mod vectors;
mod tilt;
mod start;
mod structure;
mod snap;

pub use layout::Design;
pub use material::Material;
pub use mixture::{Mixture, volumes};
pub use snap::{VolumeBounds, alternatives, flipped, flips, snap};
pub use start::{filled, layout_materials, start};
pub use structure::{LayoutRules, MOST_RANKED, Structure, joined_to_payload};
pub use vectors::{attract, clamp};
