//! One step of the robot, as a page of stages over arrays.

use std::ops::Range;

use autodiff::{Array, Graph, Matrix, Model, Program, Real};

use super::mechanics::Mechanics;
use super::parameters::{Drive, Network, Parameters};
use crate::lattice::{Body, Lattice};
use crate::laws::Particle;
use crate::scene::{ControllerSettings, PhysicsSettings, Senses};

/// The robot as a [`Model`]: what a rollout computes in every step is settled here, before it.
///
/// - Parameters: see [`Parameters`].
/// - State: x, y, x velocity, y velocity of all nodes in the ground's frame.
/// - Inputs: `sin(omega t)`, `cos(omega t)`, and `t` where a force reads it.
#[derive(Clone, Debug)]
pub(super) struct Robot {
    pub(super) graph: Graph,
    /// Slots that hold an edge with an output of the controller, ascending.
    actuated: Vec<usize>,
    hidden: usize,
    /// What the controller sees beside its clock.
    senses: Senses,
    /// Whether constant activations replace a controller.
    held: bool,
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
            held: false,
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
        let slack: Vec<bool> = (0..self.graph.slot_of_edge().len()).map(slack).collect();
        if slack.contains(&true) {
            robot.graph = self.graph.without(&slack);
        }
        let edges = robot.graph.edge_of_slot();
        let strains = |edge: usize| bodies.iter().any(|body| !body.strain[edge].is_zero());
        robot
            .actuated
            .retain(|&slot| edges[slot].is_some_and(strains));
        robot
    }

    /// This robot with a controller that sees the clock alone.
    pub(super) fn without_feedback(&self) -> Self {
        Self {
            senses: Senses::default(),
            ..self.clone()
        }
    }

    /// This robot with constant activations in place of a controller.
    pub(super) fn held(&self) -> Self {
        Self {
            held: true,
            ..self.clone()
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

    /// The stretches of the folded controller's sensed values that are more than constants.
    pub(super) fn sensed_columns(&self) -> Vec<Range<usize>> {
        let nodes = self.graph.nodes();
        let Senses { x, v } = self.senses;
        let parts = [(x, 2 * nodes), (v, 2 * nodes), (true, 2)];
        let mut end = 0;
        let stretch = |(seen, len): (bool, usize)| {
            end += len;
            seen.then(|| end - len..end)
        };
        parts.into_iter().filter_map(stretch).collect()
    }

    /// The activation of every edge, in slots.
    fn activation<R: Real>(
        &self,
        p: &mut Program<R>,
        network: &Network<Array, Matrix>,
        sensed: &[Array],
    ) -> Array {
        let mut places = vec![false; self.graph.slots()];
        for &slot in &self.actuated {
            places[slot] = true;
        }
        let hidden = p.dense_tanh(network.w1, sensed, network.b1);
        p.dense_tanh_spread(network.w2, &[hidden], network.b2, &places)
    }

    /// Declares the parameters, in the order of [`Parameters::in_order`].
    fn declare<R: Real>(&self, p: &mut Program<R>) -> Parameters<Array, Matrix> {
        let (slots, nodes) = (self.graph.slots(), self.graph.nodes());
        let (hidden, outputs) = (self.hidden, self.actuated.len());
        let inputs = self.sensed_columns().into_iter().map(|c| c.len()).sum();
        // Fields are evaluated in the order in which they are written.
        Parameters {
            stiffness: p.parameter(slots),
            rest_length: p.parameter(slots),
            strain: p.parameter(slots),
            inverse_mass: p.parameter(nodes),
            drive: if self.held {
                Drive::Held(p.parameter(slots))
            } else if outputs > 0 {
                Drive::Network(Network {
                    w1: p.matrix(hidden, inputs),
                    b1: p.parameter(hidden),
                    w2: p.matrix(outputs, hidden),
                    b2: p.parameter(outputs),
                })
            } else {
                Drive::Idle
            },
            constants: (self.mechanics.constants())
                .map(|arrays| arrays.iter().map(|a| p.parameter(a.len())).collect())
                .collect(),
        }
    }
}

impl Model for Robot {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let given = self.declare(p);
        let state = Particle::new([(); 4].map(|()| p.state(self.graph.nodes())));
        let clock = p.input(2);
        let time = self.mechanics.needs_time().then(|| p.input(1));

        // 1. The controller looks at the state; without actuators it is not asked, and any array
        //    of the right length stands for its activation.
        let seen = [(state.x, self.senses.x), (state.v, self.senses.v)];
        let seen = seen.into_iter().filter(|(_, is_seen)| *is_seen);
        let sensed: Vec<Array> = seen.flat_map(|(array, _)| array).chain([clock]).collect();
        let activation = match &given.drive {
            Drive::Network(network) => self.activation(p, network, &sensed),
            Drive::Held(activation) => *activation,
            Drive::Idle => given.strain,
        };

        // 2. Every edge pulls on its nodes, and every node moves, until it meets the ground.
        let at_nodes = vec![Some(0); self.graph.nodes()];
        let time = time.map(|time| p.gather(time, &at_nodes));
        let mechanics = &self.mechanics;
        let next = mechanics.record(p, &self.graph, state, &given, activation, time);
        for (state, next) in state.array().into_iter().zip(next.array()) {
            p.advance(state, next);
        }
    }

    // Compiled here, once, for all who run robots.
    fn record_f64(&self, p: &mut Program<f64>) {
        self.record(p);
    }
    fn record_f32(&self, p: &mut Program<f32>) {
        self.record(p);
    }
}
