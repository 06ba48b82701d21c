//! The cause of an absurd state: which part of a step gave a node its velocity.

use super::bending::BentPair;
use super::rollout::Simulator;
use crate::controller::{Controller, observation};
use crate::lattice::State;
use crate::projection::Body;

/// A term of the step, by what it did to one node; displayed as part of a sentence.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Cause {
    /// The controller gives an edge of the node an activation that is no number.
    #[error("the controller's output for edge {edge}")]
    Controller {
        /// The edge.
        edge: usize,
    },
    /// An edge pushes or pulls the node more than anything else does.
    #[error("the spring of edge {edge} {nodes:?}")]
    Spring {
        /// The edge.
        edge: usize,
        /// The nodes that it joins.
        nodes: [usize; 2],
    },
    /// Two edges in line are bent, and push the node more than anything else does.
    #[error("the bending of the bar over nodes {nodes:?}")]
    Bending {
        /// The nodes of the bar that they make.
        nodes: [usize; 3],
    },
    /// Gravity adds more to the velocity than anything else.
    #[error("gravity")]
    Gravity,
    /// The node was as fast before, and got too far.
    #[error("the node's own velocity")]
    Motion,
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
        let seen = observation(&self.controller, time, before, &self.ground);
        let activation = controller.activation(&seen);
        let edges = self.pulling_edges(body, node);
        // The activation of an edge that does not strain has no effect, not even as NaN.
        let is_misled = |&&e: &&usize| activation[e].is_nan() && body.strain[e] != 0.0;
        if let Some(&edge) = edges.iter().find(is_misled) {
            return Cause::Controller { edge };
        }
        // The magnitude also clears the sign bit of NaN, which `total_cmp` would rank lowest.
        let speed = |[x, y]: [f64; 2]| x.hypot(y).abs() / body.mass[node];
        let spring = |&edge: &usize| {
            let nodes = self.lattice.edges[edge];
            let impulse = self.spring_impulse(body, edge, activation[edge], &before.x);
            (Cause::Spring { edge, nodes }, speed(impulse))
        };
        let mechanics = &self.robot.mechanics;
        let bars = mechanics.bending_impulses(&body.stiffness, &before.x);
        let bending = bars.into_iter().filter_map(|BentPair { nodes, impulses }| {
            let place = nodes.iter().position(|&other| other == node)?;
            Some((Cause::Bending { nodes }, speed(impulses[place])))
        });
        let gravity = mechanics.flight.gravity;
        let decayed = before.v[node].map(|v| v * mechanics.flight.decay);
        let mut terms: Vec<(Cause, f64)> = edges.iter().map(spring).chain(bending).collect();
        terms.push((Cause::Gravity, gravity[0].hypot(gravity[1])));
        terms.push((Cause::Motion, decayed[0].hypot(decayed[1])));
        // NaN ranks above every number, and of equals the last wins: motion that is no number.
        let most = terms.iter().max_by(|a, b| a.1.total_cmp(&b.1));
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

    /// The impulse of an edge with this activation on its tail, N s, between nodes at these places.
    fn spring_impulse(
        &self,
        body: &Body<f64>,
        edge: usize,
        activation: f64,
        x: &[[f64; 2]],
    ) -> [f64; 2] {
        let [[xi, yi], [xj, yj]] = self.lattice.edges[edge].map(|node| x[node]);
        self.robot.mechanics.spring_impulse([
            xj - xi,
            yj - yi,
            activation,
            body.stiffness[edge],
            self.lattice.rest_length[edge],
            body.strain[edge],
        ])
    }
}
