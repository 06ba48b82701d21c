//! The ground: a line with its frame, and the height of the terrain above that line.

mod line;
mod profile;

pub use line::Ground;
pub use profile::{MOST_POINTS, Profile};
