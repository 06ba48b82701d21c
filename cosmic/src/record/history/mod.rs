//! `history.jsonl` and `history.csv` get a line at the end of each iteration; `designs.jsonl` gets the designs of some
//! iterations and how they walk.

mod walk;
mod rows;
mod appended;
mod write;

pub use rows::{
    DESIGNS, DESIGNS_FORMAT, DesignRow, FORMAT, HistoryRow, LINES, TABLE, read, read_lines,
};
pub use walk::Walk;
pub(super) use write::History;
