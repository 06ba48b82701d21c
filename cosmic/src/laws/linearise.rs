//! The derivatives of forces at a pose.

use std::sync::Arc;

use autodiff::{Real, jacobian_reverse};
use autodiff_programs::{Graph, Model, Program, Rollout};

use super::force::Force;
use super::motion::Motion;
use super::pose::{ForceParameters, Pose, Step};
use super::stiffness::Stiffness;
use crate::geometry::{Axes, Dimension, Matrix, Vector};

/// The sum of the [stiffness](Force::stiffness) of forces at a pose.
pub(crate) fn stiffness(forces: &[Arc<dyn Force>], pose: &Pose) -> Stiffness {
    let mut sum = Stiffness::none(pose);
    for force in forces {
        sum += (force.stiffness(pose)).unwrap_or_else(|| of_recorded(force, pose));
    }
    sum
}

/// The stiffness of a force, from the derivatives of what it records. What a node gets is the sum of the sizes of the
/// derivatives of its force with respect to all nodes: no vibration is faster than with this stiffness at every node.
fn of_recorded(force: &Arc<dyn Force>, pose: &Pose) -> Stiffness {
    let (dimension, nodes) = (pose.lattice.dimension, pose.lattice.nodes());
    let axes = dimension.count();
    let model = Alone::new(force, pose);
    let rollout = Rollout {
        entries: Some((0..axes * nodes).collect()),
        ..Rollout::new(model, 1)
    };
    let by_all = jacobian_reverse(
        |state| {
            let numbers = rollout.model.numbers.iter();
            let numbers: Vec<_> = numbers.map(|numbers| Real::lits(numbers)).collect();
            let parameters: Vec<_> = numbers.iter().map(Vec::as_slice).collect();
            rollout.run(state, &parameters)
        },
        &pose.state.to_columns(),
    );
    let mut stiffness = Stiffness::none(pose);
    for node in 0..nodes {
        // The part of the matrix that belongs to this node and another one, for positions (0) or velocities (1).
        let size = |part: usize, other: usize| {
            let entry = |row: usize, column: usize| {
                by_all[row * nodes + node][(part * axes + column) * nodes + other]
            };
            let of_row = |row| (0..axes).map(move |column| entry(row, column));
            let entries = (0..axes).flat_map(of_row);
            entries.map(|entry| entry * entry).sum::<f64>().sqrt()
        };
        let [by_place, by_velocity] =
            [0, 1].map(|part| (0..nodes).map(|other| size(part, other)).sum::<f64>());
        stiffness.node(node, Matrix::onto(dimension) * by_place);
        stiffness.dampen_node(node, by_velocity);
    }
    stiffness
}

/// A model whose step replaces the positions of the nodes by a force on them.
#[derive(Clone, Debug)]
struct Alone {
    force: Arc<dyn Force>,
    graph: Graph,
    /// The numbers of all parameters: 1 / mass and the time of every node, the four numbers of every slot, then the
    /// constants and the inputs of the force.
    numbers: Vec<Vec<f64>>,
    dimension: Dimension,
    softening: f64,
    largest_strain: f64,
    vertical: Vector<f64>,
}

impl Alone {
    fn new(force: &Arc<dyn Force>, pose: &Pose) -> Self {
        let Pose { lattice, body, .. } = pose;
        let graph = lattice.graph();
        let inverse_mass = body.mass.iter().map(|mass| mass.recip()).collect();
        let mut numbers = vec![inverse_mass, vec![pose.time; lattice.nodes()]];
        numbers.extend([0, 1, 2, 3].map(|k| {
            let edges = 0..lattice.edges.len();
            let of_edges: Vec<f64> = edges.map(|edge| pose.of_edge(edge)[k]).collect();
            graph.to_slots(&of_edges)
        }));
        numbers.extend(force.constants());
        numbers.extend(force.inputs().iter().map(|input| vec![input.value]));
        Self {
            force: Arc::clone(force),
            graph,
            numbers,
            dimension: lattice.dimension,
            softening: lattice.softening(),
            largest_strain: body.largest_strain,
            vertical: pose.vertical,
        }
    }
}

impl Model for Alone {
    fn record(&self, p: &mut Program) {
        let numbers = self.numbers.iter();
        let parameters: Vec<_> = numbers.map(|numbers| p.parameter(numbers.len())).collect();
        let [x, v] =
            [(); 2].map(|()| Axes::from_fn(self.dimension, |_| p.state(self.graph.nodes())));
        let (of_step, of_force) = parameters.split_at(6);
        let (constants, inputs) = of_force.split_at(self.force.constants().len());
        let step = Step {
            graph: &self.graph,
            nodes: Motion { x, v },
            inverse_mass: of_step[0],
            time: (self.force.needs_time()).then_some(of_step[1]),
            activation: of_step[2],
            stiffness: of_step[3],
            rest_length: of_step[4],
            strain: of_step[5],
            dt: 1.0,
            softening: self.softening,
            largest_strain: self.largest_strain,
            vertical: self.vertical,
        };
        let given = ForceParameters {
            constants: constants.to_vec(),
            inputs: inputs.to_vec(),
        };
        let force = self.force.record(p, &step, &given);
        for (&x, &force) in x.as_slice().iter().zip(force.as_slice()) {
            p.advance(x, force);
        }
        v.as_slice().iter().for_each(|&v| p.advance(v, v));
    }
}
