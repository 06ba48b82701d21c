//! Reference cases. The file of a case holds one rollout with all its numbers, and the expected results.
//!
//! Lattice, positions, rest lengths, velocities, design and weights all come from the file. Nothing is generated or
//! assumed.

mod raw;
mod results;
mod read;
mod write;
mod evaluate;
mod of_scene;

pub use read::Case;
pub use results::{CaseResults, DesignGradient, Gradient};
