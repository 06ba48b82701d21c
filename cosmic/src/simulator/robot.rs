//! One step of the robot, as a page of stages over arrays.

use std::ops::Range;

use autodiff::{Array, Graph, Matrix, Model, Program, Real};

use super::bending::Bending;
use super::mechanics::Mechanics;
use crate::lattice::Lattice;
use crate::projection::Body;
use crate::scene::{ControllerSettings, PhysicsSettings};

/// A term of a step that is left out where it makes no difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spare {
    /// The controller's sight of positions, where their scale is zero.
    Positions,
    /// The controller's sight of velocities, where their scale is zero.
    Velocities,
    /// Outputs of the controller for edges that do not strain.
    Outputs,
    /// Edges without any stiffness.
    Edges,
}

/// The robot as a [`Model`]: what a rollout computes in every step is settled here, before it.
/// In the order of declaration
///
/// - parameters: stiffness, rest length and strain per edge (in the graph's slots), 1 / mass per
///   node, and, where there are actuators, the folded controller: `w1` (of the
///   [`sensed_columns`](Robot::sensed_columns)), `b1`, and the rows of `w2` and `b2` for the
///   [`actuators`](Robot::actuators); where bars resist bending, the stiffness of
///   its slots;
/// - state: x, y, x velocity, y velocity of all nodes in the ground's frame;
/// - inputs: `sin(omega t)`, `cos(omega t)`.
#[derive(Clone, Debug)]
pub(super) struct Robot {
    pub(super) graph: Graph,
    /// Slots that hold an edge with an output of the controller, ascending.
    actuated: Vec<usize>,
    hidden: usize,
    /// Whether the controller sees positions and velocities.
    senses: [bool; 2],
    /// Whether edges that do not strain keep their outputs, and whether edges are kept that do not
    /// pull.
    keeps_outputs: bool,
    keeps_edges: bool,
    pub(super) mechanics: Mechanics,
}

impl Robot {
    pub(super) fn new(
        lattice: &Lattice,
        physics: &PhysicsSettings,
        controller: &ControllerSettings,
    ) -> Self {
        // A spring does not know its direction, and the graph wants tails before heads.
        let ascending = |&[i, j]: &[usize; 2]| [i.min(j), i.max(j)];
        let edges: Vec<[usize; 2]> = lattice.edges.iter().map(ascending).collect();
        let graph = Graph::new(lattice.nodes(), &edges);
        let mut actuated = graph.slot_of_edge().to_vec();
        actuated.sort_unstable();
        Self {
            graph,
            actuated,
            hidden: controller.hidden,
            senses: controller.senses(),
            keeps_outputs: false,
            keeps_edges: false,
            mechanics: Mechanics::new(lattice, physics),
        }
    }

    /// The same robot without what none of these bodies has any use for: edges without stiffness,
    /// which pull on nothing however far they are stretched, and outputs of the controller for
    /// edges that do not strain, or are not there: zero times an activation is zero whatever the
    /// activation.
    pub(super) fn for_bodies<R: Real>(&self, bodies: &[Body<R>]) -> Self {
        let mut robot = self.clone();
        let slack = |edge: usize| bodies.iter().all(|body| body.stiffness[edge].is_zero());
        let edges = self.graph.slot_of_edge().len();
        let slack: Vec<bool> = (0..edges).map(|e| !self.keeps_edges && slack(e)).collect();
        if slack.contains(&true) {
            robot.graph = self.graph.without(&slack);
        }
        let edges = robot.graph.edge_of_slot();
        let passive = |edge: usize| bodies.iter().all(|body| body.strain[edge].is_zero());
        let strains = |edge| self.keeps_outputs || !passive(edge);
        robot
            .actuated
            .retain(|&slot| edges[slot].is_some_and(strains));
        robot
    }

    /// Computes a term in any case.
    pub(super) fn keep(&mut self, spare: Spare) {
        match spare {
            Spare::Positions => self.senses[0] = true,
            Spare::Velocities => self.senses[1] = true,
            Spare::Outputs => self.keeps_outputs = true,
            Spare::Edges => self.keeps_edges = true,
        }
    }

    /// The edges with an output of the controller, in the order of the outputs: that of the
    /// slots, so that they spread out by whole lanes.
    pub(super) fn actuators(&self) -> Vec<usize> {
        let edges = self.graph.edge_of_slot();
        self.actuated
            .iter()
            .filter_map(|&slot| edges[slot])
            .collect()
    }

    /// What resists bending, where anything does.
    pub(super) fn bending(&self) -> Option<&Bending> {
        self.mechanics.bending.as_ref()
    }

    /// The stretches of the folded controller's sensed values that are more than constants.
    pub(super) fn sensed_columns(&self) -> Vec<Range<usize>> {
        let nodes = self.graph.nodes();
        let [positions, velocities] = self.senses;
        let parts = [(positions, 2 * nodes), (velocities, 2 * nodes), (true, 2)];
        let mut end = 0;
        let stretch = |(seen, len): (bool, usize)| {
            end += len;
            seen.then(|| end - len..end)
        };
        parts.into_iter().filter_map(stretch).collect()
    }

    /// The activation of every edge, in slots; nothing that strains needs none.
    fn activation<R: Real>(&self, p: &mut Program<R>, network: Network) -> Array {
        let Network {
            layers: [(w1, b1), (w2, b2)],
            sensed,
        } = network;
        let mut places = vec![false; self.graph.slots()];
        for &slot in &self.actuated {
            places[slot] = true;
        }
        let hidden = p.dense_tanh(w1, &sensed, b1);
        p.dense_tanh_spread(w2, &[hidden], b2, &places)
    }
}

/// The controller in a program.
struct Network {
    layers: [(Matrix, Array); 2],
    sensed: Vec<Array>,
}

impl Model for Robot {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let (nodes, slots) = (self.graph.nodes(), self.graph.slots());
        let [stiffness, rest_length, strain] = [(); 3].map(|()| p.parameter(slots));
        let inverse_mass = p.parameter(nodes);
        let inputs = self.sensed_columns().into_iter().map(|c| c.len()).sum();
        let outputs = self.actuated.len();
        let layers = (outputs > 0).then(|| {
            [(self.hidden, inputs), (outputs, self.hidden)]
                .map(|(rows, columns)| (p.matrix(rows, columns), p.parameter(rows)))
        });
        let bending = self.bending().map(|b| p.parameter(b.slots()));
        let [x, y, vx, vy] = [(); 4].map(|()| p.state(nodes));
        let clock = p.input(2);

        // 1. The controller looks at the state.
        let seen = [(x, 0), (y, 0), (vx, 1), (vy, 1)].into_iter();
        let seen = seen.filter(|&(_, kind)| self.senses[kind]);
        let sensed = seen.map(|(array, _)| array).chain([clock]).collect();
        let activation = match layers {
            Some(layers) => self.activation(p, Network { layers, sensed }),
            None => strain,
        };

        // 2. Every edge pulls on its nodes, and every node moves, until it meets the ground.
        let edge = [activation, stiffness, rest_length, strain];
        let state = [x, y, vx, vy];
        let world = (&mut *p, &self.graph);
        let given = (&edge, inverse_mass, bending);
        let next = self.mechanics.record(world, state, given);
        for (state, next) in state.into_iter().zip(next) {
            p.advance(state, next);
        }
    }
}
