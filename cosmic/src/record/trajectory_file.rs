//! `trajectory.json`: how the delivered design moves.

use super::files::Format;
use crate::lattice::State;
use crate::simulator::Trajectory;
use serde::{Deserialize, Serialize};

/// What a trajectory file says it is.
pub const FORMAT: Format = Format {
    name: "cosmic-trajectory",
    version: 1,
};

/// The trajectory's place in a run's folder.
pub const TRAJECTORY: &str = "trajectory.json";

/// The contents of a trajectory file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrajectoryFile {
    /// Time step, s: the state after `n` steps is that at `n dt`.
    pub dt: f64,
    /// Numbers of steps done, ascending; 0 is the start.
    pub steps: Vec<usize>,
    /// The state in the world's frame after so many steps, one for each of `steps`.
    pub states: Vec<State<f64>>,
}

impl TrajectoryFile {
    /// A trajectory as a file.
    pub fn new(trajectory: &Trajectory<f64>, dt: f64) -> Self {
        Self {
            dt,
            steps: trajectory.steps.clone(),
            states: trajectory.states.clone(),
        }
    }
}
