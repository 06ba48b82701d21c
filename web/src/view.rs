//! What the page draws of a scene and of a rollout.

use cosmic::codesign::CoDesign;
use cosmic::geometry::{Ground, Range, Vector, flat};
use cosmic::lattice::State;
use serde_json::{Value, json};

/// The longest time between two pictures of a rollout, s: several a step of the gait. The page draws straight
/// ways in between.
const INTERVAL: f64 = 0.04;

/// The steps whose states are drawn: equally far apart, from the start on.
pub(crate) fn drawn_steps(codesign: &CoDesign) -> Vec<usize> {
    let physics = &codesign.scene().physics;
    (0..=physics.steps).step_by(every(codesign)).collect()
}

/// How many steps there are from one picture to the next.
fn every(codesign: &CoDesign) -> usize {
    let physics = &codesign.scene().physics;
    ((INTERVAL / physics.dt) as usize).clamp(1, physics.steps)
}

/// The lattice and its world: nodes in metres, edges as pairs of nodes, the terrain as a line of points, the
/// strain with the full colour, seconds between pictures.
pub(crate) fn world(codesign: &CoDesign) -> Value {
    let (scene, lattice) = (codesign.scene(), &codesign.task().lattice);
    let ground = codesign.task().ground();
    let limit = scene.materials.max_strain[2];
    json!({
        "rest": lattice.positions,
        "edges": lattice.edges,
        "lengths": lattice.rest_length,
        "payloads": lattice.payload.iter().map(|payload| payload.node).collect::<Vec<_>>(),
        "width": 3.4 * lattice.side(),
        "spacing": lattice.spacing,
        "cos": ground.tangent().forward(),
        "ground": terrain(codesign, &ground),
        "limit": if limit > 0.0 { limit } else { 1.0 },
        "every": every(codesign) as f64 * scene.physics.dt,
        "iterations": scene.schedule.iterations,
        "snap": scene.schedule.snap_at,
    })
}

/// The terrain as points of the world, farther to both sides than any robot gets.
fn terrain(codesign: &CoDesign, ground: &Ground) -> Vec<Vector<f64>> {
    let side = codesign.task().lattice.side();
    let profile = codesign.scene().physics.ground.resolved();
    let points = profile
        .between(Range::default().widened(100.0 * side))
        .into_iter();
    points.map(|point| ground.point_to_world(point)).collect()
}

/// Positions `x0, y0, x1, y1, …` of all nodes, state after state, in metres.
pub(crate) fn positions(states: &[State<f64>]) -> impl Iterator<Item = f32> {
    let coordinates = states.iter().flat_map(|state| flat(&state.x));
    coordinates.map(|metres| metres as f32)
}
