//! The version of the scenes of runs.

/// The key `format` in the scene of a run.
pub(super) const FORMAT: &str = "cosmic-scene";

/// The version of the scenes that this program writes for runs. It is raised with every new key. Scenes without a
/// version have version 0.
pub const VERSION: u32 = 2;
