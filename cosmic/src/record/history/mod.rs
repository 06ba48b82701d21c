//! The history of a run: `history.jsonl` has a line for each iteration; `designs.jsonl` has the designs of some
//! iterations and how they walk.

mod frames;
mod rows;
mod write;

pub use frames::Frames;
pub use rows::{DESIGNS, DESIGNS_FORMAT, DesignRow, LINES, read, read_lines};
pub use write::History;
