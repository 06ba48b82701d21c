//! `trajectory.json`: the motion of the run's final robot.

use crate::format::Format;
use crate::lattice::State;
use crate::walk::BarLoad;
use serde::{Deserialize, Serialize};

/// The format of a trajectory file.
pub const FORMAT: Format = Format::new("cosmic-trajectory", 1);

/// The name of the trajectory in the folder of a run.
pub const TRAJECTORY: &str = "trajectory.json";

/// The contents of a trajectory file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrajectoryFile {
    /// The time step, in seconds.
    pub dt: f64,
    /// For each state, the number of simulated steps before it, in ascending order. The start has the number 0.
    pub steps: Vec<usize>,
    /// The states, one for each of `steps`, in the world's frame.
    pub states: Vec<State<f64>>,
    /// The loads of each edge over all steps; `None` for a void edge. Empty for an undecided design.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bars: Vec<Option<BarLoad>>,
}
