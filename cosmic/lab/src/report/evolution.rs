//! The robots on the way of an optimisation, each walking: from the walks that a run kept of its designs.

use super::animation::shots;
use super::canvas::Shot;
use super::files::{RobotFiles, RunFiles};
use super::motion::Motion;
use cosmic::error::{Error, Result};
use cosmic::lattice::State;
use cosmic::record::history::{DESIGNS, Walk};
use cosmic::record::{Summary, TrajectoryFile};

/// How many robots are shown before the delivered one, and for how long each, s.
const ROBOTS: usize = 6;
const SECONDS: f64 = 2.0;

/// A robot on the way, with the words that its label begins with.
pub(super) struct Walker {
    robot: RobotFiles,
    trajectory: TrajectoryFile,
    says: String,
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
            says: format!("iteration {}   ", row.iteration),
        })
        .collect())
}

/// The motions of robots, and that of the delivered one at the end.
pub(super) fn motions<'m>(
    walkers: &'m [Walker],
    delivered: &'m RunFiles,
) -> Vec<(Motion<'m>, String, f64)> {
    let motion = |walker: &'m Walker| {
        let motion = Motion::new(&walker.robot, &walker.trajectory);
        (motion, walker.says.clone(), SECONDS)
    };
    let Summary {
        delivered_iteration,
        ..
    } = delivered.summary;
    let says = format!("delivered, iteration {delivered_iteration}   ");
    let last = Motion::new(&delivered.robot, &delivered.trajectory);
    walkers
        .iter()
        .map(motion)
        .chain([(last, says, 2.0 * SECONDS)])
        .collect()
}

/// One after another.
pub(super) fn in_turn<'m>(motions: &'m [(Motion<'m>, String, f64)], every: f64) -> Vec<Shot<'m>> {
    let shots = |(motion, says, seconds): &'m (Motion<'m>, String, f64)| {
        shots(motion, every, *seconds, says)
    };
    motions.iter().flat_map(shots).collect()
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
