//! Verdicts as HTML, and the measurements that summaries of earlier versions lack.

use super::files::RobotFiles;
use crate::table::escape;
use cosmic::Registry;
use cosmic::error::Result;
use cosmic::lattice::Lattice;
use cosmic::record::run::{DESIGN, read_scene_to_show};
use cosmic::record::{Summary, TrajectoryFile};
use cosmic::simulator::Trajectory;
use cosmic::verdict::{Item, Verdict};
use std::path::Path;

/// Returns a verdict as a paragraph of HTML. Every item has the colour of its level.
pub(super) fn to_html(verdict: &Verdict) -> String {
    format!(
        "<p class=\"verdict {}\">{}</p>\n",
        verdict.level().name(),
        line(verdict)
    )
}

/// Returns a verdict as a line of HTML.
pub(super) fn line(verdict: &Verdict) -> String {
    let item = |Item { text, level, .. }: &Item| {
        format!("<span class=\"{}\">{}</span>", level.name(), escape(text))
    };
    verdict.line(item)
}

/// Adds to the summary of a run of an earlier version what the run's other files tell about loads. Leaves it as it is if
/// this program does not have all laws of the scene, or if the run did not record its loads.
pub(super) fn complete(
    summary: &mut Summary,
    robot: &RobotFiles,
    trajectory: &TrajectoryFile,
    folder: &Path,
) {
    let Some(loads) = &summary.loads else { return };
    let is_complete = loads.most_tangles.is_some();
    let Some(layout) = robot.design.design().layout().map(<[_]>::to_vec) else {
        return;
    };
    if is_complete || trajectory.bars.is_empty() {
        return;
    }
    let Ok(case) = robot.case(&folder.join(DESIGN), "loads") else {
        return;
    };
    let (task, bars) = (case.task(), &trajectory.bars);
    let states = Trajectory::new(trajectory.steps.clone(), trajectory.states.clone());
    let found = task
        .simulator
        .loads_of(&layout, bars, &states, &case.materials);
    summary.loads = Some(found);
}

/// Returns the verdict on the robot of a finished run.
///
/// # Errors
/// The errors of reading the run's scene.
pub fn verdict_of(folder: &Path, summary: &Summary, registry: &Registry) -> Result<Verdict> {
    let scene = read_scene_to_show(folder, registry)?.scene;
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    Ok(summary.measured(&scene, &lattice).verdict())
}
