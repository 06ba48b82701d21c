//! Finds the cause of a divergence: the part of a step that gave a node most of its velocity, or the speed bound that
//! the node exceeded.

use crate::geometry::Vector;
use crate::lattice::{Body, State};
use crate::laws::{Pose, Pull};
use crate::world::{Robot, World};

/// The cause of a divergence at one node. The text of a cause is the end of a sentence about the node.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Cause {
    /// The controller gave the activation NaN to an edge at the node.
    #[error("mostly by the controller's output for edge {edge}")]
    Controller {
        /// The number of the edge.
        edge: usize,
    },
    /// A part of a force, such as one spring, added most to the velocity. The text names the part.
    #[error("mostly by {0}")]
    Force(String),
    /// Gravity added most to the velocity.
    #[error("mostly by gravity")]
    Gravity,
    /// The node had most of its velocity already before the step, and this velocity moved it too far.
    #[error("mostly by the node's own velocity")]
    Motion,
    /// The node is faster than the scene allows.
    #[error("which is {speed:.1} m/s; `physics.speed_bound` allows {bound} m/s")]
    TooFast {
        /// The speed of the node, m/s.
        speed: f64,
        /// The largest speed that the scene allows, m/s.
        bound: f64,
    },
}

/// Finds the part of a step that gave a node most of its velocity, or a part that is NaN. The step is the first substep
/// after the state `before`, and the policy sees the state `seen`. Contact with the ground is not considered, because it
/// only reduces velocities.
pub(super) fn blame(
    world: &World,
    (robot, seen): (&Robot<f64>, &State<f64>),
    before: &State<f64>,
    step: usize,
    node: usize,
) -> Cause {
    let body = &robot.body;
    let time = step as f64 * world.physics().dt;
    let activation = world.activations(robot, &[(seen, time)]).remove(0);
    let edges = pulling_edges(world, body, node);
    // The activation of an edge with strain 0 has no effect, even if it is NaN.
    let is_misled = |&&e: &&usize| activation[e].is_nan() && body.strain[e] != 0.0;
    if let Some(&edge) = edges.iter().find(is_misled) {
        return Cause::Controller { edge };
    }
    // `abs` clears the sign bit of NaN; otherwise `total_cmp` could rank NaN lowest.
    let size = |vector: Vector<f64>| vector.norm().abs();
    let mechanics = world.mechanics();
    let pose = Pose {
        activation: &activation,
        time,
        ..Pose::idle(world.lattice(), body, before, &world.ground())
    };
    let forces = mechanics.forces.iter();
    let pulls = forces.flat_map(|force| force.pulls(&pose, node));
    let velocity = |force: Vector<f64>| size(force) * mechanics.push / body.mass[node];
    let term = |Pull { part, force }: Pull| (Cause::Force(part), velocity(force));
    let mut terms: Vec<(Cause, f64)> = pulls.map(term).collect();
    terms.push((Cause::Gravity, size(mechanics.fallen(mechanics.gravity))));
    let kept = before.v[node] * mechanics.decay();
    terms.push((Cause::Motion, size(kept)));
    // NaN counts as larger than every number. If several terms are NaN, the result is the last of them, which is
    // the motion.
    let most = terms.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
    most.map_or(Cause::Motion, |most| most.0)
}

/// The edges of a node that can pull on it, because their stiffness is not 0.
fn pulling_edges(world: &World, body: &Body<f64>, node: usize) -> Vec<usize> {
    let edges = world
        .lattice()
        .edges
        .iter()
        .zip(&body.stiffness)
        .enumerate();
    edges
        .filter(|(_, (ends, stiffness))| ends.contains(&node) && **stiffness != 0.0)
        .map(|(edge, _)| edge)
        .collect()
}
