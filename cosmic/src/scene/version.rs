//! The format and the version of the scenes of runs.

/// The value of the key `format` in the scene of a run.
pub(super) const FORMAT: &str = "cosmic-scene";

/// The version of the scenes that this program writes for runs, and reads.
pub(super) const VERSION: u32 = 1;
