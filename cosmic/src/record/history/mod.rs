//! The history of a run: `history.jsonl` has a line for each iteration; `designs.jsonl` has the designs of some
//! iterations and how they walk.

mod walk;
mod rows;
mod write;

pub use rows::{DESIGNS, DESIGNS_FORMAT, DesignRow, FORMAT, HistoryRow, LINES, read, read_lines};
pub use walk::Walk;
pub use write::History;
