//! What is checked in a scene: settings that contradict one another, that have no effect, or that are probably a mistake.

mod unread;
mod warnings;
mod check;

pub(super) use check::{Conflict, conflicts, size};
pub use warnings::Finding;
