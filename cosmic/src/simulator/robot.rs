//! One step of the robot, as a page of stages over arrays.

use autodiff::{Graph, Model, Program, Real};

use super::bending::Bending;
use super::kernels::{Flight, Sliding, Spring, Sticking, Stiffening};
use crate::lattice::{Ground, Lattice};
use crate::scene::{Contact, ControllerSettings, PhysicsSettings};

/// The robot as a [`Model`]. In the order of declaration
///
/// - parameters: stiffness, rest length and strain per edge (in the graph's slots), 1 / mass per
///   node, and the folded controller: `w1`, `b1`, `w2`, `b2`, the latter two in
///   [`edge_order`](Robot::edge_order); where bars resist bending, the stiffness of its slots;
/// - state: x, y, x velocity, y velocity of all nodes in the ground's frame;
/// - inputs: `sin(omega t)`, `cos(omega t)`.
#[derive(Clone, Debug)]
pub(super) struct Robot {
    pub(super) graph: Graph,
    edges: usize,
    hidden: usize,
    flight: Flight,
    /// `None` where nodes stick to the ground.
    pub(super) friction: Option<f64>,
    /// The cubic coefficient of the springs; `None` for Hooke's law.
    stiffening: Option<f64>,
    /// `None` where bars bend freely.
    pub(super) bending: Option<Bending>,
}

impl Robot {
    pub(super) fn new(
        lattice: &Lattice,
        physics: &PhysicsSettings,
        controller: &ControllerSettings,
    ) -> Self {
        let dt = physics.dt;
        // A spring does not know its direction, and the graph wants tails before heads.
        let ascending = |&[i, j]: &[usize; 2]| [i.min(j), i.max(j)];
        let edges: Vec<[usize; 2]> = lattice.edges.iter().map(ascending).collect();
        let gravity = Ground::from(physics).vector_to_ground([0.0, -physics.gravity * dt]);
        Self {
            graph: Graph::new(lattice.nodes(), &edges),
            edges: edges.len(),
            hidden: controller.hidden,
            flight: Flight {
                dt,
                decay: (-physics.damping * dt).exp(),
                gravity,
            },
            friction: match physics.contact {
                Contact::Infinite => None,
                Contact::Coulomb => Some(physics.friction),
            },
            stiffening: (physics.stiffening > 0.0).then_some(physics.stiffening),
            bending: Bending::new(lattice, physics.bending_radius),
        }
    }
}

impl Robot {
    /// The edges in the order of their slots: that of the controller's outputs, so that they move
    /// to their slots in runs.
    pub(super) fn edge_order(&self) -> Vec<usize> {
        self.graph.edge_of_slot().into_iter().flatten().collect()
    }

    /// For every slot with an edge, that edge's place in the order above.
    fn places(&self) -> Vec<Option<usize>> {
        let mut places = 0..;
        let edges = self.graph.edge_of_slot().into_iter();
        edges.map(|edge| edge.and_then(|_| places.next())).collect()
    }
}

impl Model for Robot {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let (nodes, slots) = (self.graph.nodes(), self.graph.slots());
        let [stiffness, rest_length, strain] = [(); 3].map(|()| p.parameter(slots));
        let inverse_mass = p.parameter(nodes);
        let (w1, b1) = (
            p.matrix(self.hidden, 4 * nodes + 2),
            p.parameter(self.hidden),
        );
        let (w2, b2) = (p.matrix(self.edges, self.hidden), p.parameter(self.edges));
        let bending = self.bending.as_ref().map(|b| (b, p.parameter(b.slots())));
        let [x, y, vx, vy] = [(); 4].map(|()| p.state(nodes));
        let clock = p.input(2);

        // 1. The controller looks at the state.
        let hidden = p.dense_tanh(w1, &[x, y, vx, vy, clock], b1);
        let activation = p.dense_tanh(w2, &[hidden], b2);
        let activation = p.gather(activation, &self.places());

        // 2. Every edge pulls on its nodes.
        let dt = self.flight.dt;
        let edge = [activation, stiffness, rest_length, strain];
        let edge = ([x, y], &edge[..]);
        let [jx, jy] = match self.stiffening {
            None => p.map_edges(&self.graph, Spring { dt }, edge),
            Some(cubic) => p.map_edges(&self.graph, Stiffening { dt, cubic }, edge),
        };
        // 72 numbers, against the roots and quotients of 110 edges.
        p.keep(jx);
        p.keep(jy);
        let [jx, jy] = match bending {
            None => [jx, jy],
            Some((bending, stiffness)) => bending.record(p, (stiffness, dt), [x, y], [jx, jy]),
        };

        // 3. Every node moves, until it meets the ground.
        let node = [x, y, vx, vy, jx, jy, inverse_mass];
        let next = match self.friction {
            None => p.map(Sticking(self.flight), node),
            Some(friction) => p.map(
                Sliding {
                    flight: self.flight,
                    friction,
                },
                node,
            ),
        };
        for (state, next) in [x, y, vx, vy].into_iter().zip(next) {
            p.advance(state, next);
        }
    }
}
