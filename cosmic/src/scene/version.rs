//! The version of the scenes of runs.

/// The kind of file: the key `format` of a run's scene.
pub(super) const FORMAT: &str = "cosmic-scene";

/// The version of the scenes that this program writes for runs. It is raised with every new key. Scenes of runs
/// that are older than versions have version 0.
pub const VERSION: u32 = 2;
