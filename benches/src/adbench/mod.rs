//! ADBench: its files, and how it compares and times answers.

mod cases;
mod files;
mod reference;
mod table;

pub use cases::{Case, cases};
pub use files::input;
pub use reference::{Gap, gap};
pub use table::table;
