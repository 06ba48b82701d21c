//! A run in its folder, which one process uses at a time.

mod folder;
mod at_work;

pub use crate::record::design_file::DESIGN;
pub use at_work::{Observer, Run};
pub(super) use folder::{Lock, begin, keep_scene, take_up};
pub use folder::{SCENE, read_scene, read_scene_to_show};
