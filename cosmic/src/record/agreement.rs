//! Checks whether a design, a summary and a trajectory belong to the same run.
//!
//! The files do not name their run, but their numbers must agree: the summary must have the volumes of the design and
//! the displacement of the trajectory, and a simulation of the design must give the first steps of the trajectory.

use super::design_file::{DESIGN, DesignFile};
use super::summary::{SUMMARY, Summary};
use super::trajectory_file::{TRAJECTORY, TrajectoryFile};
use crate::design::volumes;
use crate::error::{Error, Result};
use crate::scene::Scene;
use crate::simulator::Span;
use std::path::Path;

/// The largest difference between two results that rounding can explain.
const ROUNDING: f64 = 1e-9;

/// A distance, as a share of the lattice's spacing. If, at the second state of a trajectory file, any node of two
/// rollouts differs by more than this distance, the rollouts belong to different robots. Platforms and versions of the
/// program round differently, but in so few steps the difference stays below this distance. Robots of different seeds
/// are farther apart.
const APART: f64 = 1e-6;

/// Checks that the files of a finished run belong together.
///
/// # Errors
/// The errors of [`DesignFile::robot`]; [`Error::Usage`] with the first number that differs.
pub fn check_one_run(
    folder: &Path,
    scene: &Scene,
    design: &DesignFile,
    summary: &Summary,
    trajectory: &TrajectoryFile,
) -> Result<()> {
    check_numbers(folder, scene, design, summary, trajectory)?;
    check_motion(folder, scene, design, trajectory)
}

/// The error for a file that contradicts the other files of a run.
fn differs(folder: &Path, name: &str, what: &str) -> Error {
    let file = folder.join(name).display().to_string();
    Error::Usage(format!(
        "{file}: {what}, so the files in this folder are not all from one run; use files from the same run"
    ))
}

/// Does those checks of [`check_one_run`] that need no simulation: it compares the volumes and the displacement.
///
/// # Errors
/// Like [`check_one_run`].
pub fn check_numbers(
    folder: &Path,
    scene: &Scene,
    design: &DesignFile,
    summary: &Summary,
    trajectory: &TrajectoryFile,
) -> Result<()> {
    let case = design.case(scene, &folder.join(DESIGN).display().to_string())?;
    let [volume, actuator_volume] = volumes(&case.own_design().mixtures());
    for (key, found, expected) in [
        ("V", summary.volume, volume),
        ("V_act", summary.actuator_volume, actuator_volume),
    ] {
        if (found - expected).abs() > ROUNDING {
            let what = format!("expected `{key}` of {expected}, as in {DESIGN}, found {found}");
            return Err(differs(folder, SUMMARY, &what));
        }
    }
    let (Some(first), Some(last)) = (trajectory.states.first(), trajectory.states.last()) else {
        return Ok(());
    };
    let marker = case.body().marker;
    let moved = marker.place(&first.x, last) - first.x[marker.payload];
    let size = 1.0 + moved.map(f64::abs).largest();
    if (summary.displacement - moved).map(f64::abs).largest() > ROUNDING * size {
        let what = format!(
            "expected a `displacement` of {moved:?} m, as in {TRAJECTORY}, found {:?} m",
            summary.displacement
        );
        return Err(differs(folder, SUMMARY, &what));
    }
    Ok(())
}

/// Checks that the trajectory begins like a simulation of the design.
fn check_motion(
    folder: &Path,
    scene: &Scene,
    design: &DesignFile,
    trajectory: &TrajectoryFile,
) -> Result<()> {
    let ([0, step, ..], [_, second, ..]) = (&trajectory.steps[..], &trajectory.states[..]) else {
        return Ok(());
    };
    let first = &trajectory.states[0];
    let case = design.case(scene, &folder.join(DESIGN).display().to_string())?;
    let span = Span::from_start(vec![*step]);
    let rollout = (case.task().simulator).rollout(&case.body(), &case.controller, first, &span);
    let pairs = rollout.at(*step).x.iter().zip(&second.x);
    let distance = pairs.map(|(a, b)| a.distance(*b));
    if distance.fold(0.0, f64::max) > APART * case.lattice.spacing {
        let what = format!(
            "after {step} steps, the robot's position differs from a simulation of {DESIGN}"
        );
        return Err(differs(folder, TRAJECTORY, &what));
    }
    Ok(())
}
