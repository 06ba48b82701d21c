//! `history.jsonl` and `history.csv`: a row an iteration, appended as it ends; `designs.jsonl`:
//! the design vectors of some of them.

mod rows;
mod table;
mod appended;
mod read;
mod write;

pub use read::{read, read_lines};
pub use rows::{DESIGNS, DESIGNS_FORMAT, DesignRow, FORMAT, HistoryRow, LINES, TABLE};
pub(super) use write::History;
