//! Shows how the robot changes during an optimisation, by the walks that the run has recorded: from the first iteration
//! to the last.

use super::animation::{Pace, Shot, shots};
use super::files::{RobotFiles, RunFiles};
use super::motion::Motion;
use cosmic::error::{Error, Result};
use cosmic::geometry::Vector;
use cosmic::lattice::State;
use cosmic::record::TrajectoryFile;
use cosmic::record::history::{DESIGNS, Walk};

/// The number of robots that are shown before the run's final robot.
const ROBOTS: usize = 6;
/// How many seconds each robot is shown.
const SECONDS: f64 = 2.0;

/// A robot with its recorded motion. A text and a duration say how the animation shows it.
pub(super) struct Walker {
    robot: RobotFiles,
    trajectory: TrajectoryFile,
    /// The beginning of the labels of its frames.
    says: String,
    /// How many seconds of the motion are shown.
    seconds: f64,
}

/// Returns a few robots at equal intervals of iterations, beginning with the first iteration, and then the run's final
/// robot.
///
/// # Errors
/// [`Error::Usage`] if the run kept no walks.
pub(super) fn walkers(run: &RunFiles) -> Result<Vec<Walker>> {
    let rows = run.designs.iter();
    let rows: Vec<_> = rows
        .filter_map(|row| row.walk.as_ref().map(|walk| (row, walk)))
        .collect();
    if rows.is_empty() {
        let file = run.folder.join(DESIGNS);
        return Err(Error::Usage(format!(
            "{}: the run has no recorded walks",
            file.display()
        )));
    }
    let count = rows.len().min(ROBOTS);
    let spread = (0..count).map(|k| rows[k * rows.len() / count]);
    let before = spread.map(|(row, walk)| Walker {
        robot: run.robot.drawn_as(&row.z),
        trajectory: trajectory(walk),
        says: format!("iteration {}   ", row.iteration),
        seconds: SECONDS,
    });
    let delivered = Walker {
        robot: run.robot.drawn_as(&run.robot.design.z),
        trajectory: run.trajectory.clone(),
        says: format!(
            "delivered, iteration {}   ",
            run.summary.delivered_iteration
        ),
        seconds: 2.0 * SECONDS,
    };
    Ok(before.chain([delivered]).collect())
}

/// Prepares the recorded motions for drawing.
pub(super) fn motions<'m>(walkers: &'m [Walker]) -> Vec<Motion<'m>> {
    let motion = |walker: &'m Walker| Motion::new(&walker.robot, &walker.trajectory);
    walkers.iter().map(motion).collect()
}

/// Returns the frames of all robots, one robot after another.
pub(super) fn in_turn<'m>(
    walkers: &[Walker],
    motions: &'m [Motion<'m>],
    pace: Pace,
) -> Vec<Shot<'m>> {
    let turns = walkers.iter().zip(motions);
    let shots = |(walker, motion): (&Walker, &'m Motion<'m>)| {
        shots(motion, pace, walker.seconds, &walker.says)
    };
    turns.flat_map(shots).collect()
}

/// Converts a recorded motion to a trajectory. A step of the trajectory is a recorded moment.
fn trajectory(walk: &Walk) -> TrajectoryFile {
    let state = |x: Vec<Vector<f64>>| State {
        v: vec![Vector::zero(); x.len()],
        x,
    };
    let states: Vec<_> = walk.places().into_iter().map(state).collect();
    TrajectoryFile {
        dt: walk.every,
        steps: (0..states.len()).collect(),
        states,
        bars: Vec::new(),
    }
}
