//! One step of the robot, as a page of stages over arrays.

use autodiff::{Graph, Model, Program, Real};

use super::mechanics::Mechanics;
use super::trap::{Unwatched, Watch, Watched};
use crate::lattice::Lattice;
use crate::scene::{ControllerSettings, PhysicsSettings};

/// The robot as a [`Model`]. In the order of declaration
///
/// - parameters: stiffness, rest length and strain per edge (in the graph's slots), 1 / mass per
///   node, and the folded controller: `w1`, `b1`, `w2`, `b2`, the latter two in
///   [`edge_order`](Robot::edge_order);
/// - state: x, y, x velocity, y velocity of all nodes in the ground's frame;
/// - inputs: `sin(omega t)`, `cos(omega t)`.
#[derive(Clone, Debug)]
pub(super) struct Robot {
    pub(super) graph: Graph,
    edges: usize,
    hidden: usize,
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
        Self {
            graph: Graph::new(lattice.nodes(), &edges),
            edges: edges.len(),
            hidden: controller.hidden,
            mechanics: Mechanics::new(physics),
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
        self.step::<R, Unwatched>(p);
    }
}

/// The same robot, every node's step with a [trap](super::trap::Trapped). A model of its own:
/// it is run in f64 alone, and never compiled for other numbers.
#[derive(Clone, Debug)]
pub(super) struct TrappedRobot(pub(super) Robot);

impl Model for TrappedRobot {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        self.0.step::<R, Watched>(p);
    }
}

impl Robot {
    fn step<R: Real, W: Watch>(&self, p: &mut Program<R>) {
        let (nodes, slots) = (self.graph.nodes(), self.graph.slots());
        let [stiffness, rest_length, strain] = [(); 3].map(|()| p.parameter(slots));
        let inverse_mass = p.parameter(nodes);
        let (w1, b1) = (
            p.matrix(self.hidden, 4 * nodes + 2),
            p.parameter(self.hidden),
        );
        let (w2, b2) = (p.matrix(self.edges, self.hidden), p.parameter(self.edges));
        let [x, y, vx, vy] = [(); 4].map(|()| p.state(nodes));
        let clock = p.input(2);

        // 1. The controller looks at the state.
        let hidden = p.dense_tanh(w1, &[x, y, vx, vy, clock], b1);
        let activation = p.dense_tanh(w2, &[hidden], b2);
        let activation = p.gather(activation, &self.places());

        // 2. Every edge pulls on its nodes, and every node moves, until it meets the ground.
        let edge = [activation, stiffness, rest_length, strain];
        let state = [x, y, vx, vy];
        let world = (&mut *p, &self.graph);
        let next = self
            .mechanics
            .record::<R, W>(world, state, (&edge, inverse_mass));
        for (state, next) in state.into_iter().zip(next) {
            p.advance(state, next);
        }
    }
}
