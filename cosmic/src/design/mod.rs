//! Designs of robots, from what the optimiser moves to what is built.
//!
//! - A design vector per edge, `[f64; 3]` from 0 to 1, is what the optimiser moves.
//! - A [`Mixture`] per edge is what a [projection](crate::projection) makes of it: shares of the materials.
//! - A layout is one [`Material`] per edge.
//!
//! [`Design`] holds one of them for all edges.

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
pub use structure::{LayoutRules, MOST_RANKED, Structure};
pub use vectors::{attract, clamp};
