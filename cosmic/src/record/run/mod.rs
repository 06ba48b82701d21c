//! A run in its folder. Only one process at a time uses the folder.

mod claim;
mod folder;
mod at_work;

pub use crate::record::files::DESIGN;
pub use at_work::{Observer, Run};
pub use claim::claimed;
pub(super) use folder::{Lock, begin, keep_scene, take_up};
pub use folder::{SCENE, read_scene, read_summary};
