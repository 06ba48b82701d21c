//! What the scripts of a page draw from.

use serde_json::{Map, Value, json};

use super::files::{RobotFiles, RunFiles};
use super::gait::{Gait, brief};
use super::motion::{Motion, bounds};
use cosmic::codesign::Record;
use cosmic::record::history::Walk;

/// Seconds from one frame of the delivered robot to the next.
const FRAME: f64 = 0.04;
/// Parts of the lattice's spacing that its positions are rounded to.
const PARTS: f64 = 1000.0;

/// A robot and its motion.
pub(super) fn of_motion(motion: &Motion) -> Value {
    let walks = [walk(motion)];
    json!({
        "robot": of_robot(motion.robot, &motion.states()[0].x),
        "world": world(motion, &walks),
        "walk": walks[0],
    })
}

/// All of a run.
pub(super) fn of_run(run: &RunFiles, motion: &Motion, gait: Option<&Gait>) -> Value {
    let mut walks = vec![walk(motion)];
    walks.extend(run.designs.iter().map(|row| row.walk.clone()));
    let design = |k: usize| {
        let row = &run.designs[k];
        json!({ "iteration": row.iteration, "mixtures": mixtures(&run.robot, &row.z), "walk": row.walk })
    };
    let mut data = json!({
        "robot": of_robot(&run.robot, &motion.states()[0].x),
        "world": world(motion, &walks),
        "walk": walks[0],
        "iteration": run.summary.delivered_iteration,
        "designs": (0..run.designs.len()).map(design).collect::<Vec<_>>(),
        "history": history(run),
    });
    if let Some(gait) = gait {
        let (_, states) = motion.every(FRAME);
        data["gait"] = gait.last_periods(motion);
        data["forces"] = gait.forces(&states);
        data["energies"] = gait.energies(motion);
    }
    data
}

/// The lattice, and the design that is delivered.
pub(super) fn of_robot(robot: &RobotFiles, start: &[[f64; 2]]) -> Value {
    let lattice = &robot.lattice;
    let payloads = lattice.payload.iter().map(|payload| payload.node);
    json!({
        "start": start.as_flattened().iter().map(|x| brief(*x)).collect::<Vec<_>>(),
        "side": lattice.side(),
        "edges": robot.design.edges,
        "rest": lattice.rest_length.iter().map(|x| brief(*x)).collect::<Vec<_>>(),
        "materials": robot.design.materials,
        "mixtures": mixtures(robot, &robot.design.z),
        "payloads": payloads.collect::<Vec<_>>(),
    })
}

/// Shares of void, skeleton and actuator of every edge, in thousandths.
fn mixtures(robot: &RobotFiles, z: &[[f64; 3]]) -> Vec<[i64; 3]> {
    let mixtures = robot.mixtures(z).into_iter();
    mixtures
        .map(|mixture| mixture.0.map(|share| (1e3 * share).round() as i64))
        .collect()
}

/// The ground as far as walks get.
fn world(motion: &Motion, walks: &[Option<Walk>]) -> Value {
    let width = 4.0 * motion.robot.lattice.side();
    let places = walks.iter().flatten().flat_map(Walk::places);
    let firsts = places.filter_map(|places| places.first().copied());
    let [low, high] = bounds(firsts.chain([motion.states()[0].x[0]]));
    let [cos, sin] = motion.ground().tangent();
    json!({
        "width": width,
        "ground": motion.ground_line([low[0] - 2.0 * width, high[0] + 2.0 * width]),
        "cos": cos,
        "sin": sin,
        "limit": motion.limit,
        "origin": motion.states()[0].x[0][0],
    })
}

/// The delivered robot: 25 frames a second, fewer for a long rollout.
fn walk(motion: &Motion) -> Option<Walk> {
    let (seconds, indices) = motion.every(FRAME);
    let states = indices.into_iter().map(|k| &motion.states()[k]);
    Walk::of(states, seconds, motion.robot.lattice.spacing / PARTS)
}

/// True if the robot flew apart in the gradient's rollout of this iteration. Files then have no displacement.
pub(super) fn horizon_diverged(record: &Record) -> bool {
    let displacement = record.displacement_horizon;
    record.pass.is_some() && !displacement.is_some_and(f64::is_finite)
}

/// The numbers of the history, a list each with a number an iteration.
fn history(run: &RunFiles) -> Value {
    type Number = fn(&Record) -> Option<f64>;
    // A curve has a gap where a rollout diverged. It continues across iterations without a rollout.
    let is_gap = |name: &str, record: &Record| match name {
        "displacement" => record.diverged,
        "horizon" => horizon_diverged(record),
        _ => false,
    };
    let columns: [(&str, Number); 11] = [
        ("displacement", |r| r.displacement),
        ("horizon", |r| r.displacement_horizon),
        ("solid", |r| Some(r.volume)),
        ("actuators", |r| Some(r.actuator_volume)),
        ("norm", |r| Some(r.measures[0])),
        ("void_skeleton", |r| Some(r.measures[1])),
        ("void_actuator", |r| Some(r.measures[2])),
        ("skeleton_actuator", |r| Some(r.measures[3])),
        ("design", |r| r.design_gradient[0]),
        ("design_stability", |r| r.design_gradient[1]),
        ("controller", |r| r.controller_gradient),
    ];
    let column = |(name, number): (&str, Number)| {
        let number = |record: &Record| match number(record) {
            _ if is_gap(name, record) => json!("diverged"),
            number => json!(number.map(brief)),
        };
        let numbers = run.history.iter().map(number);
        (name.to_owned(), json!(numbers.collect::<Vec<_>>()))
    };
    let columns: Map<String, Value> = columns.into_iter().map(column).collect();
    let phases = run.history.chunk_by(|a, b| a.phase == b.phase).map(|part| {
        let ends = [&part[0], &part[part.len() - 1]].map(|record| record.iteration);
        json!({ "name": part[0].phase.name(), "from": ends[0] - 1, "to": ends[1] })
    });
    let volume = &run.robot.scene.volume;
    let bounds = [volume.solid, volume.actuator].concat();
    json!({
        "first": run.history.first().map(|record| record.iteration),
        "columns": columns,
        "phases": phases.collect::<Vec<_>>(),
        "bounds": bounds,
        "median": run.summary.displacement_p50,
    })
}
