//! The version of the scenes of runs.

/// The kind of file: the key `format` of a run's scene.
pub(super) const FORMAT: &str = "cosmic-scene";

/// The version of the scenes that this program writes for runs: raised with every key that is added. Scenes of runs
/// from before there were versions have version 0.
pub const VERSION: u32 = 1;
