//! The cause of a divergence: the part of a step that gave a node its velocity, or the bound that the
//! node exceeds.

use super::rollout::Simulator;
use crate::lattice::{Body, State};
use crate::laws::{Pose, Pull};
use crate::policy::Controller;

/// A term of the step, by what it did to one node; displayed as part of a sentence.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Cause {
    /// The controller gives an edge of the node an activation that is no number.
    #[error("mostly by the controller's output for edge {edge}")]
    Controller {
        /// The edge.
        edge: usize,
    },
    /// A part of a law pushes or pulls the node more than anything else does.
    #[error("mostly by {0}")]
    Force(String),
    /// Gravity adds more to the velocity than anything else.
    #[error("mostly by gravity")]
    Gravity,
    /// The node was as fast before, and got too far.
    #[error("mostly by the node's own velocity")]
    Motion,
    /// The node is faster than the scene allows, m/s.
    #[error("which is {speed:.1} m/s; `physics.speed_bound` allows {bound} m/s")]
    TooFast {
        /// Its speed.
        speed: f64,
        /// The largest speed allowed.
        bound: f64,
    },
}

impl Simulator {
    /// The term that gave a node most of its velocity in the (first mechanical) step from a state
    /// on, and first of all one that is no number. (The ground only ever takes velocity away.)
    pub(super) fn blame(
        &self,
        body: &Body<f64>,
        controller: &Controller<f64>,
        before: &State<f64>,
        step: usize,
        node: usize,
    ) -> Cause {
        let time = step as f64 * self.dt;
        let activation = self
            .activations(body, controller, &[(before, time)])
            .remove(0);
        let edges = self.pulling_edges(body, node);
        // The activation of an edge that does not strain has no effect, not even as NaN.
        let is_misled = |&&e: &&usize| activation[e].is_nan() && body.strain[e] != 0.0;
        if let Some(&edge) = edges.iter().find(is_misled) {
            return Cause::Controller { edge };
        }
        // The magnitude also clears the sign bit of NaN, which `total_cmp` would rank lowest.
        let size = |[x, y]: [f64; 2]| x.hypot(y).abs();
        let mechanics = &self.robot.mechanics;
        let pose = Pose {
            lattice: &self.lattice,
            body,
            state: before,
            activation: &activation,
            time,
        };
        let forces = mechanics.forces.iter();
        let pulls = forces.flat_map(|force| force.pulls(&pose, node));
        let velocity = |force: [f64; 2]| size(force) * mechanics.push / body.mass[node];
        let term = |Pull { part, force }: Pull| (Cause::Force(part), velocity(force));
        let mut terms: Vec<(Cause, f64)> = pulls.map(term).collect();
        let flight = &mechanics.flight;
        terms.push((Cause::Gravity, size(flight.gravity)));
        let kept = before.v[node].map(|v| v * flight.decay);
        terms.push((Cause::Motion, size(kept)));
        // NaN ranks above every number, and of equals the last wins: motion that is no number.
        let most = terms.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
        most.map_or(Cause::Motion, |most| most.0)
    }

    /// The edges of a node that can pull on it: those with any stiffness.
    fn pulling_edges(&self, body: &Body<f64>, node: usize) -> Vec<usize> {
        let edges = self.lattice.edges.iter().zip(&body.stiffness).enumerate();
        edges
            .filter(|(_, (ends, stiffness))| ends.contains(&node) && **stiffness != 0.0)
            .map(|(edge, _)| edge)
            .collect()
    }
}
