//! The JSON data from which the page draws a scene and a rollout.

use cosmic::geometry::{Dimension, Ground, Range};
use cosmic::lattice::{Lattice, State};
use cosmic::search::CoDesign;
use cosmic::world::{Trajectory, World};
use serde_json::{Value, json};

/// The longest time between two frames of a rollout, in seconds. It is short enough for several frames in a step of the
/// gait. The page interpolates between frames.
const INTERVAL: f64 = 0.04;
/// Positions are rounded to multiples of a unit, which is the lattice's spacing divided by this.
const PARTS: f64 = 1000.0;

/// Returns the steps that are drawn: at equal intervals, beginning with the start.
pub(crate) fn drawn_steps(codesign: &CoDesign) -> Vec<usize> {
    let steps = codesign.scene().physics.steps;
    (0..=steps).step_by(every(codesign)).collect()
}

/// Returns the number of time steps between two frames.
pub(crate) fn every(codesign: &CoDesign) -> usize {
    let physics = &codesign.scene().physics;
    ((INTERVAL / physics.dt) as usize).clamp(1, physics.steps)
}

/// Returns the lattice with lengths in metres (the points of `start` have three coordinates), its world, and the number of iterations.
pub(crate) fn world(world: &World, iterations: usize) -> Value {
    let (lattice, ground) = (world.lattice(), world.ground());
    let [cos, sin] = ground.tangent().in_plane();
    let limit = world.materials().actuator_strain();
    let payloads: Vec<usize> = lattice.payload.iter().map(|payload| payload.node).collect();
    let origin = lattice.positions[payloads.first().copied().unwrap_or(0)];
    json!({
        "robot": {
            "axes": lattice.dimension,
            "start": Dimension::Space.flat(&lattice.positions),
            "edges": lattice.edges,
            "rest": lattice.rest_length,
            "payloads": payloads,
        },
        "world": {
            "width": 3.4 * lattice.side(),
            "ground": terrain(world, &ground),
            "cos": cos,
            "sin": sin,
            "limit": if limit > 0.0 { limit } else { 1.0 },
            "origin": origin.forward(),
        },
        "iterations": iterations,
    })
}

/// Returns the corners of the terrain in the world, in metres. On both sides the terrain extends farther than any robot
/// gets.
fn terrain(world: &World, ground: &Ground) -> Vec<[f64; 2]> {
    let side = world.lattice().side();
    let profile = world.physics().ground.resolved();
    let points = profile.between(Range::default().widened(100.0 * side));
    let points = points.into_iter();
    points
        .map(|point| ground.vector_to_world(point).in_plane())
        .collect()
}

/// Returns the positions of a rollout in the [`drawn_steps`], in the form that a walk has in `designs.jsonl`. All are
/// multiples of `unit` (in metres): first the positions at the start, then for each further frame the changes since the
/// frame before it.
pub(crate) fn walk(codesign: &CoDesign, seen: &Trajectory<f64>) -> Value {
    let Lattice {
        spacing, dimension, ..
    } = codesign.world().lattice();
    let unit = spacing / PARTS;
    let mut before = vec![0; dimension.count() * seen.states[0].x.len()];
    let mut moved = |state: &State<f64>| -> Vec<i64> {
        let counts = dimension
            .flat(&state.x)
            .into_iter()
            .map(|x| (x / unit).round() as i64);
        let pairs = counts.zip(&mut before);
        let change = |(count, before): (i64, &mut i64)| count - std::mem::replace(before, count);
        pairs.map(change).collect()
    };
    let drawn = seen.states.iter().take(drawn_steps(codesign).len());
    json!({
        "every": every(codesign) as f64 * codesign.scene().physics.dt,
        "unit": unit,
        "axes": dimension,
        "counts": drawn.map(&mut moved).collect::<Vec<_>>(),
    })
}
