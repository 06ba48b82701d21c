//! The robots on the way of an optimisation, each walking: from the walks that a run kept of its designs.

use super::animation::{Pace, shots};
use super::canvas::Shot;
use super::files::{RobotFiles, RunFiles};
use super::motion::Motion;
use cosmic::error::{Error, Result};
use cosmic::lattice::State;
use cosmic::record::TrajectoryFile;
use cosmic::record::history::{DESIGNS, Walk};

/// How many robots are shown before the delivered one, and for how long each, s.
const ROBOTS: usize = 6;
const SECONDS: f64 = 2.0;

/// A robot on the way.
pub(super) struct Walker {
    robot: RobotFiles,
    trajectory: TrajectoryFile,
    iteration: usize,
}

/// A few robots from the first iteration to the last, evenly apart.
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
            "{}: no walks were kept, as in runs of earlier versions: the evolution needs a new run",
            file.display()
        )));
    }
    let count = rows.len().min(ROBOTS);
    let spread = (0..count).map(|k| rows[k * rows.len() / count]);
    Ok(spread
        .map(|(row, walk)| Walker {
            robot: run.robot.on_the_way(&row.z),
            trajectory: trajectory(walk),
            iteration: row.iteration,
        })
        .collect())
}

/// A robot's turn in an animation: its motion, the words that its labels begin with, and how long it is shown, s.
pub(super) struct Turn<'m> {
    motion: Motion<'m>,
    says: String,
    seconds: f64,
}

/// The turns of robots, and of the delivered one at the end.
pub(super) fn turns<'m>(walkers: &'m [Walker], delivered: &'m RunFiles) -> Vec<Turn<'m>> {
    let turn = |walker: &'m Walker| Turn {
        motion: Motion::new(&walker.robot, &walker.trajectory),
        says: format!("iteration {}   ", walker.iteration),
        seconds: SECONDS,
    };
    let last = Turn {
        motion: Motion::new(&delivered.robot, &delivered.trajectory),
        says: format!(
            "delivered, iteration {}   ",
            delivered.summary.delivered_iteration
        ),
        seconds: 2.0 * SECONDS,
    };
    walkers.iter().map(turn).chain([last]).collect()
}

/// The pictures of all turns, one after another.
pub(super) fn in_turn<'m>(turns: &'m [Turn<'m>], pace: Pace) -> Vec<Shot<'m>> {
    let shots = |turn: &'m Turn<'m>| shots(&turn.motion, pace, turn.seconds, &turn.says);
    turns.iter().flat_map(shots).collect()
}

/// A walk as a trajectory, a step from each moment to the next.
fn trajectory(walk: &Walk) -> TrajectoryFile {
    let state = |x: Vec<[f64; 2]>| State {
        v: vec![[0.0; 2]; x.len()],
        x,
    };
    let states: Vec<_> = walk.places().into_iter().map(state).collect();
    TrajectoryFile {
        dt: walk.every,
        steps: (0..states.len()).collect(),
        states,
    }
}
