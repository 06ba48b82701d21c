//! `history.jsonl` and `history.csv`: a row an iteration, appended as it ends; `designs.jsonl`:
//! the designs of some of them, and how they walk.

mod walk;
mod rows;
mod appended;
mod write;

pub use rows::{
    DESIGNS, DESIGNS_FORMAT, DesignRow, FORMAT, HistoryRow, LINES, TABLE, read, read_lines,
};
pub use walk::Walk;
pub(super) use write::History;
