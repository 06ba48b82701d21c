//! Which term of a step made a node absurd.

use std::fmt;

use autodiff::Kernel;

use super::Simulator;
use crate::controller::{Controller, Moment, observation};
use crate::lattice::State;
use crate::projection::Body;

/// A term of the step, by what it did to one node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Term {
    /// The controller gives an edge of the node an activation that is no number.
    Controller {
        /// The edge.
        edge: usize,
    },
    /// An edge pushes or pulls the node more than anything else does.
    Spring {
        /// The edge.
        edge: usize,
        /// The nodes that it joins.
        nodes: [usize; 2],
    },
    /// Gravity adds more to the velocity than anything else.
    Gravity,
    /// The node was as fast before, and got too far.
    Motion,
}

/// As part of a sentence.
impl fmt::Display for Term {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Term::Controller { edge } => write!(out, "the controller's output for edge {edge}"),
            Term::Spring { edge, nodes } => write!(out, "the spring of edge {edge} {nodes:?}"),
            Term::Gravity => out.write_str("gravity"),
            Term::Motion => out.write_str("the node's own velocity"),
        }
    }
}

impl Simulator {
    /// The term that gave a node most of its velocity in the (first mechanical) step from a state
    /// on, and first of all one that is no number. (The ground only ever takes velocity away.)
    pub(super) fn blame(
        &self,
        (body, controller): (&Body<f64>, &Controller<f64>),
        (node, step): (usize, usize),
        before: &State<f64>,
    ) -> Term {
        let moment = Moment {
            time: step as f64 * self.dt,
            state: before,
            ground: &self.ground,
        };
        let activation = controller.activation(&observation(&self.controller, &moment));
        // Without stiffness there is no pull, be the nodes where they may.
        let of_node = |&(edge, ends): &(usize, &[usize; 2])| {
            ends.contains(&node) && body.stiffness[edge] != 0.0
        };
        let edges: Vec<(usize, &[usize; 2])> = self
            .lattice
            .edges
            .iter()
            .enumerate()
            .filter(of_node)
            .collect();
        if let Some(&(edge, _)) = edges
            .iter()
            // What does not strain hears nothing of its activation.
            .find(|(e, _)| activation[*e].is_nan() && body.strain[*e] != 0.0)
        {
            return Term::Controller { edge };
        }
        let spring = |&(edge, &nodes): &(usize, &[usize; 2])| {
            let pushed = self.impulse(body, (edge, activation[edge]), before);
            (Term::Spring { edge, nodes }, pushed / body.mass[node])
        };
        let flight = &self.robot.mechanics.flight;
        let gravity = flight.gravity;
        let decayed = before.v[node].map(|v| v * flight.decay);
        let mut terms: Vec<(Term, f64)> = edges.iter().map(spring).collect();
        terms.push((Term::Gravity, gravity[0].hypot(gravity[1])));
        terms.push((Term::Motion, decayed[0].hypot(decayed[1])));
        // NaN ranks above every number, and of equals the last wins: motion that is no number.
        let most = terms.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        most.map_or(Term::Motion, |most| most.0)
    }

    /// Size of the impulse that an edge gives its nodes, N s.
    fn impulse(&self, body: &Body<f64>, (edge, u): (usize, f64), state: &State<f64>) -> f64 {
        let [i, j] = self.lattice.edges[edge];
        let [dx, dy] = [0, 1].map(|k| state.x[j][k] - state.x[i][k]);
        let (k, strain) = (body.stiffness[edge], body.strain[edge]);
        let [x, y] = self.robot.mechanics.spring.eval([
            dx,
            dy,
            u,
            k,
            self.lattice.rest_length[edge],
            strain,
        ]);
        // Of either sign: a NaN with its sign bit set would rank below every number.
        x.hypot(y).abs()
    }
}
