//! Reference cases: one rollout with all its numbers in a file, and the results it should have.
//!
//! Everything is taken from the file: lattice, positions, rest lengths, velocities, design and
//! weights. Nothing is generated and nothing assumed.

mod raw;
mod results;
mod read;
mod write;
mod evaluate;
mod of_scene;

pub use read::Case;
pub use results::{CaseResults, DesignGradient, Gradient};
