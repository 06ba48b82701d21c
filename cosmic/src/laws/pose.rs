//! What a force acts on: the arrays of a step, or a robot at one moment.

use autodiff_programs::{Array, Graph};

use super::bar::Bar;
use super::motion::Motion;
use crate::geometry::{Dimension, Ground, Vector};
use crate::lattice::{Body, EdgeVector, Lattice, State};

/// The arrays that a step computes forces from. Vectors are in the ground's frame.
pub struct Step<'a> {
    /// The edges. Each edge has a slot: its place in the arrays that have a number for every edge.
    pub graph: &'a Graph,
    /// Positions (m) and velocities (m/s) of the nodes.
    pub nodes: Motion,
    /// 1 / mass of every node, 1/kg.
    pub inverse_mass: Array,
    /// The controller's output for every slot.
    pub activation: Array,
    /// Stiffness of the edge in every slot, N/m.
    pub stiffness: Array,
    /// Rest length of the edge in every slot, m.
    pub rest_length: Array,
    /// Strain at full activation of the edge in every slot.
    pub strain: Array,
    /// The time, s, for every node; `None` unless a force [needs it](super::Force::needs_time).
    pub time: Option<Array>,
    /// The duration of the push, s. A force gives the nodes its impulse over this time.
    pub dt: f64,
    /// The [softening](Lattice::softening) of lengths, m^2.
    pub softening: f64,
    /// The largest strain of the actuator material.
    pub largest_strain: f64,
    /// The unit vector opposite to gravity.
    pub vertical: Vector<f64>,
}

impl Step<'_> {
    /// Whether the robot moves in the plane or in space.
    pub fn dimension(&self) -> Dimension {
        self.nodes.dimension()
    }

    /// The arrays of the edges that forces read besides the motion of their ends, in the order of [`Pose::of_edge`].
    pub(super) fn per_edge(&self) -> [Array; 4] {
        [
            self.activation,
            self.stiffness,
            self.rest_length,
            self.strain,
        ]
    }
}

/// A robot at one moment, for computations that are not part of a step. Vectors are in the ground's frame.
#[derive(Clone, Debug)]
pub struct Pose<'a> {
    /// Nodes and edges.
    pub lattice: &'a Lattice,
    /// Stiffness, strains and masses.
    pub body: &'a Body<f64>,
    /// Positions and velocities.
    pub state: State<f64>,
    /// The controller's output for every edge; empty if the actuators are idle.
    pub activation: &'a [f64],
    /// The time, s.
    pub time: f64,
    /// The unit vector opposite to gravity.
    pub vertical: Vector<f64>,
}

impl Pose<'_> {
    /// The numbers of an edge that forces read besides the motion of its ends: activation, stiffness, rest length and strain.
    pub(super) fn of_edge(&self, edge: usize) -> [f64; 4] {
        let Self { lattice, body, .. } = self;
        [
            self.activation.get(edge).copied().unwrap_or(0.0),
            body.stiffness[edge],
            (body.rest_length.get(edge)).map_or(lattice.rest_length[edge], |&length| length),
            body.strain[edge],
        ]
    }

    /// The bar of an edge.
    pub(crate) fn bar(&self, edge: usize) -> Bar<f64> {
        let between = EdgeVector::of(&self.state, self.lattice.edges[edge]);
        let length = between.length(self.lattice.softening());
        let moving = [length, between.rate(length)];
        Bar::new(moving, self.of_edge(edge), self.body.largest_strain)
    }
}

impl<'a> Pose<'a> {
    /// The pose of a robot with idle actuators at time 0. `state` is in the world's frame.
    pub fn idle(
        lattice: &'a Lattice,
        body: &'a Body<f64>,
        state: &State<f64>,
        ground: &Ground,
    ) -> Self {
        Self {
            lattice,
            body,
            state: state.to_ground(ground),
            activation: &[],
            time: 0.0,
            vertical: ground.vertical(),
        }
    }
}

/// The force that a part of a law, such as one spring, exerts on one node.
#[derive(Clone, Debug)]
pub struct Pull {
    /// The name of the part as a noun phrase, such as "the spring of edge 3 [1, 2]". Messages contain it.
    pub part: String,
    /// The force, N, in the ground's frame.
    pub force: Vector<f64>,
}

/// The arrays that a force gets in a step because it has declared them in [`Force::constants`] and [`Force::inputs`].
///
/// [`Force::constants`]: super::Force::constants
/// [`Force::inputs`]: super::Force::inputs
#[derive(Clone, Debug, Default)]
pub struct ForceParameters<A> {
    /// The arrays of [`Force::constants`](super::Force::constants).
    pub constants: Vec<A>,
    /// The numbers of [`Force::inputs`](super::Force::inputs), each as an array of one number. Kernels take them as
    /// [uniform inputs](autodiff_programs::Kernel::UNIFORMS).
    pub inputs: Vec<A>,
}
