//! ADBench's files, and its way to judge and time answers.

mod cases;
mod files;
mod reference;
mod table;

pub use cases::{Case, cases};
pub use files::input;
pub use reference::{Gap, gap};
pub use table::table;
