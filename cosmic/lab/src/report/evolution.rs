//! The robots on the way of an optimisation, each walking: from the walks that a run kept of its designs.

use super::animation::{Pace, shots};
use super::canvas::Shot;
use super::files::{RobotFiles, RunFiles};
use super::motion::Motion;
use cosmic::error::{Error, Result};
use cosmic::geometry::Vector;
use cosmic::lattice::State;
use cosmic::record::TrajectoryFile;
use cosmic::record::history::{DESIGNS, Walk};

/// How many robots are shown before the delivered one, and for how long each, s.
const ROBOTS: usize = 6;
const SECONDS: f64 = 2.0;

/// A robot and its walk, what its labels begin with, and for how long it is shown, s.
pub(super) struct Walker {
    robot: RobotFiles,
    trajectory: TrajectoryFile,
    says: String,
    seconds: f64,
}

/// A few robots from the first iteration to the last, evenly apart, and the delivered one at the end.
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
    let on_the_way = spread.map(|(row, walk)| Walker {
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
    Ok(on_the_way.chain([delivered]).collect())
}

/// The motions of robots.
pub(super) fn motions<'m>(walkers: &'m [Walker]) -> Vec<Motion<'m>> {
    let motion = |walker: &'m Walker| Motion::new(&walker.robot, &walker.trajectory);
    walkers.iter().map(motion).collect()
}

/// The pictures of robots in these motions, one robot after another.
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

/// A walk as a trajectory, a step from each moment to the next.
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
