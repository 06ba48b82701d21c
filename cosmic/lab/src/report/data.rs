//! The JSON data that the scripts of a page read.

use serde_json::{Value, json};

use super::convergence::charts;
use super::files::{RobotFiles, RunFiles};
use super::gait::{Gait, four_digits};
use super::motion::{DrawnMotion, Flag};
use cosmic::design::Design;
use cosmic::geometry::{Range, Vector};
use cosmic::judge::verdict::SKELETON_STRAINS;
use cosmic::lattice::State;
use cosmic::record::history::{DesignRow, Frames};

/// Seconds between two frames on a page with one robot.
const FRAME: f64 = 0.04;
/// Seconds between two frames on a page with several runs.
const LANE_FRAME: f64 = 0.08;
/// On a page with one robot, positions are rounded to multiples of the lattice's spacing divided by this number.
const PARTS: f64 = 1000.0;
/// On a page with several runs, positions are rounded to multiples of the lattice's spacing divided by this number.
const LANE_PARTS: f64 = 200.0;

/// Returns the data of a page that shows only a robot in motion.
pub(super) fn of_motion(motion: &DrawnMotion) -> Value {
    of_walks(motion, motion.robot, &[walk(motion)])
}

/// Returns the data of a run's page.
pub(super) fn of_run(run: &RunFiles, motion: &DrawnMotion, gait: &Gait) -> Value {
    let mut walks = vec![walk(motion)];
    walks.extend(run.designs.iter().map(|row| row.walk.clone()));
    let design = |row: &DesignRow| {
        let mixtures = mixtures(&run.robot, &row.z);
        json!({ "iteration": row.iteration, "mixtures": mixtures, "walk": row.walk })
    };
    let mut data = of_walks(motion, &run.robot, &walks);
    data["iteration"] = run.summary.delivered_iteration.into();
    data["designs"] = run.designs.iter().map(design).collect();
    data["history"] = history(run);
    let (_, states) = motion.every(FRAME);
    data["gait"] = gait.last_periods(motion);
    data["forces"] = gait.forces(&states);
    data["energies"] = gait.energies(motion);
    data
}

/// Returns the data of a robot and its world. The first of `walks` (recorded motions) is the motion of the run's final
/// robot. The data contain the part of the ground that the walks reach.
fn of_walks(motion: &DrawnMotion, robot: &RobotFiles, walks: &[Option<Frames>]) -> Value {
    json!({
        "robot": of_robot(robot, &motion.states()[0].x),
        "world": world(motion, walks),
        "walk": walks[0],
        "goals": motion.flags().iter().map(goal).collect::<Vec<_>>(),
    })
}

/// Returns the data of a goal: its time, the three coordinates of the point of the ground below it, and its place along the
/// ground and across.
fn goal(flag: &Flag) -> [f64; 6] {
    let ([x, y, z], [along, across]) = (flag.foot.array(), flag.place);
    [flag.from, x, y, z, along, across]
}

/// Returns the data of one run, for a page on which several runs share one ground. Distances are measured along the
/// ground from the payload's start, and heights from the ground's line.
pub(super) fn of_lane(name: &str, motion: &DrawnMotion) -> Value {
    let (robot, ground) = (motion.robot, motion.ground());
    // The payload's start is the origin only along the ground. Heights stay relative to the ground's line.
    let origin = ground
        .vector_to_ground(motion.payload(&motion.states()[0]))
        .along();
    let (seconds, indices) = motion.every(LANE_FRAME);
    let along = |k: usize| -> State<f64> {
        let mut state = motion.states()[k].to_ground(&ground);
        state.x.iter_mut().for_each(|x| *x -= origin);
        state
    };
    let states: Vec<State<f64>> = indices.into_iter().map(along).collect();
    let side = robot.lattice.side();
    let across =
        Range::of(states.iter().map(|state| motion.payload(state).forward())).widened(100.0 * side);
    let corners = motion.profile.between(across.map(|x| x + origin.forward()));
    let corners: Vec<_> = corners.into_iter().map(|corner| corner - origin).collect();
    let unit = robot.lattice.spacing / LANE_PARTS;
    json!({
        "name": name,
        "robot": of_robot(robot, &states[0].x),
        "world": {
            "width": 4.0 * side, "ground": pairs(&corners), "cos": 1.0, "sin": 0.0, "limit": motion.limit,
            "skeleton": SKELETON_STRAINS, "origin": 0.0,
        },
        "walk": Frames::of(states.iter(), seconds, unit),
    })
}

/// Returns the data of a robot: its lattice and its final design. The points of `start` have three numbers.
fn of_robot(robot: &RobotFiles, start: &[Vector<f64>]) -> Value {
    let lattice = &robot.lattice;
    let payloads = lattice.payload.iter().map(|payload| payload.node);
    json!({
        "axes": lattice.dimension,
        "start": start.iter().flat_map(|x| x.array()).map(four_digits).collect::<Vec<_>>(),
        "side": lattice.side(),
        "edges": robot.design.edges,
        "rest": lattice.rest_length.iter().map(|x| four_digits(*x)).collect::<Vec<_>>(),
        "materials": robot.design.materials,
        "undecided": Design::of_vectors(robot.design.z.clone()).layout().is_none(),
        "mixtures": mixtures(robot, &robot.design.z),
        "payloads": payloads.collect::<Vec<_>>(),
    })
}

/// Returns the mixture of every edge: its shares of void, skeleton and actuator in thousandths.
fn mixtures(robot: &RobotFiles, z: &[[f64; 3]]) -> Vec<[i64; 3]> {
    let mixtures = robot.mixtures(z).into_iter();
    mixtures
        .map(|mixture| mixture.0.map(|share| (1e3 * share).round() as i64))
        .collect()
}

/// Points of the ground: along and above.
fn pairs(points: &[Vector<f64>]) -> Vec<[f64; 2]> {
    points.iter().map(|point| point.in_plane()).collect()
}

/// Returns the data of the world: the part of the ground that the motions `walks` reach.
fn world(motion: &DrawnMotion, walks: &[Option<Frames>]) -> Value {
    // A robot in space is seen from its narrow corner.
    let sides = if motion.in_space() { 3.0 } else { 4.0 };
    let width = sides * motion.robot.lattice.side();
    let places = walks.iter().flatten().flat_map(Frames::places);
    let firsts = places.filter_map(|places| places.first().copied());
    let start = motion.payload(&motion.states()[0]).forward();
    let across = Range::of(firsts.map(Vector::forward).chain([start])).widened(2.0 * width);
    let [cos, sin] = motion.ground().tangent().in_plane();
    json!({
        "width": width,
        "ground": pairs(&motion.ground_line(across)),
        "cos": cos,
        "sin": sin,
        "limit": motion.limit,
        "skeleton": SKELETON_STRAINS,
        "origin": start,
    })
}

/// Returns the motion of the run's final robot, with 25 frames per second, or fewer if the rollout is long.
fn walk(motion: &DrawnMotion) -> Option<Frames> {
    let (seconds, indices) = motion.every(FRAME);
    let states = indices.into_iter().map(|k| &motion.states()[k]);
    Frames::of(states, seconds, motion.robot.lattice.spacing / PARTS)
}

/// Returns the data of the charts over the iterations, and the phases.
fn history(run: &RunFiles) -> Value {
    let phases = run.history.chunk_by(|a, b| a.phase == b.phase).map(|part| {
        let ends = [&part[0], &part[part.len() - 1]].map(|record| record.iteration);
        json!({ "name": part[0].phase.name(), "from": ends[0] - 1, "to": ends[1] })
    });
    json!({
        "first": run.history.first().map(|record| record.iteration),
        "charts": charts(run),
        "phases": phases.collect::<Vec<_>>(),
    })
}
