//! `trajectory.json`: how the delivered design moves.

use super::format::Format;
use crate::lattice::State;
use crate::simulator::BarLoad;
use serde::{Deserialize, Serialize};

/// The format of a trajectory file.
pub const FORMAT: Format = Format::new("cosmic-trajectory", 1);

/// The name of the trajectory in the folder of a run.
pub const TRAJECTORY: &str = "trajectory.json";

/// The contents of a trajectory file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrajectoryFile {
    /// Time step, s: the time of the state after `n` steps is `n dt`.
    pub dt: f64,
    /// Numbers of steps done, ascending; 0 is the start.
    pub steps: Vec<usize>,
    /// The state in the world's frame after so many steps, one for each of `steps`.
    pub states: Vec<State<f64>>,
    /// The loads of each edge over all steps, `None` for a void edge. Empty for an undecided design
    /// and in files of earlier versions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bars: Vec<Option<BarLoad>>,
}
