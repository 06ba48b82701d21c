//! Runs side by side on one ground: what the scripts of a comparison draw from.

use std::path::Path;

use serde_json::{Value, json};

use super::data::of_robot;
use super::files::{RobotFiles, read_trajectory};
use super::motion::Motion;
use cosmic::Registry;
use cosmic::error::Result;
use cosmic::geometry::{Range, Vector};
use cosmic::lattice::State;
use cosmic::record::history::Walk;
use cosmic::record::run::DESIGN;
use cosmic::record::trajectory_file::TRAJECTORY;

/// Seconds from one frame to the next, and parts of the lattice's spacing that positions are rounded to.
const FRAME: f64 = 0.08;
const PARTS: f64 = 200.0;

/// A run under its name: its robot and its walk in the frame of its ground, with the payload's start as origin.
/// `None` for a run whose trajectory is gone.
///
/// # Errors
/// The errors of reading its files.
pub(super) fn lane(name: &str, folder: &Path, registry: &Registry) -> Result<Option<Value>> {
    if !folder.join(TRAJECTORY).exists() {
        return Ok(None);
    }
    let robot = RobotFiles::read(&folder.join(DESIGN), registry)?;
    let trajectory = read_trajectory(folder, &robot)?;
    let motion = Motion::new(&robot, &trajectory);
    let ground = motion.ground();
    // Along the ground alone: heights stay those above its line.
    let origin = ground.point_to_ground(motion.states()[0].x[0]).along();
    let (seconds, indices) = motion.every(FRAME);
    let along = |k: usize| -> State<f64> {
        let mut state = motion.states()[k].to_ground(&ground);
        state.x.iter_mut().for_each(|x| *x -= origin);
        state
    };
    let states: Vec<State<f64>> = indices.into_iter().map(along).collect();
    let side = robot.lattice.side();
    let across = Range::of(states.iter().map(|state| state.x[0].forward())).widened(100.0 * side);
    let corners = motion
        .profile
        .between(across.map(|x| x + origin.forward()))
        .into_iter();
    let corners: Vec<Vector<f64>> = corners.map(|corner| corner - origin).collect();
    let unit = robot.lattice.spacing / PARTS;
    Ok(Some(json!({
        "name": name,
        "robot": of_robot(&robot, &states[0].x),
        "world": {
            "width": 4.0 * side, "ground": corners, "cos": 1.0, "sin": 0.0, "limit": motion.limit, "origin": 0.0,
        },
        "walk": Walk::of(states.iter(), seconds, unit),
    })))
}
