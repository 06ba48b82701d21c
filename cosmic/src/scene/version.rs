//! The format and the version of the scenes of runs.

/// The value of the key `format` in the scene of a run.
pub(super) const FORMAT: &str = "cosmic-scene";

/// The version of the scenes that this program writes for runs. It is raised with every key that is new, renamed or
/// removed. A scene that states no version has version 0.
pub const VERSION: u32 = 8;
