//! The controller of a robot in MuJoCo, which gets the coordinates and velocities of the model.

use cosmic::case::Case;
use cosmic::geometry::Ground;
use cosmic::lattice::Body;
use cosmic::policy::{Layer, Network, Sight, of_settings};
use cosmic::scene::GoalKind;
use serde::Serialize;

/// A controller whose inputs are the raw state of all nodes, the sine and cosine of the clock, and a given goal as the
/// robot observes it.
pub(super) struct Folded<'c> {
    case: &'c Case,
    network: Network<f64>,
    /// The number of inputs.
    inputs: usize,
    /// The weight of each node in the mean position, from which a given goal is observed; `None` if the goal is fixed.
    mean: Option<Vec<f64>>,
}

/// The part of `controller.json` that only robots with given goals have.
#[derive(Serialize)]
pub(super) struct GoalFields {
    goal: Vec<f64>,
    goal_scale: f64,
    mean: Vec<f64>,
    start: Vec<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    gates: Vec<[f64; 5]>,
}

impl<'c> Folded<'c> {
    /// The controller of a case; `None` if its policy is not a network.
    pub(super) fn new(case: &'c Case, body: &Body<f64>, ground: &Ground) -> Option<Self> {
        let (settings, nodes) = (&case.scene.controller, case.lattice.nodes());
        let dimension = case.lattice.dimension;
        let sight = of_settings(settings).observe();
        let network = Network::of(&case.controller, settings, &case.lattice)?;
        let mut network =
            network.folded(settings, (dimension, nodes), sight, &body.presence, ground);
        let first = &mut network.first;
        let columns = first.weights.len() / first.biases.len();
        let unseen = match sight {
            Sight::Robot => 0,
            Sight::Clock => 2 * dimension.count() * nodes,
        };
        let rows = first.weights.chunks_exact(columns);
        first.weights = rows
            .flat_map(|row| [&vec![0.0; unseen], row].concat())
            .collect();
        let mean = (settings.goals == GoalKind::Given).then(|| match &body.presence[..] {
            [] => vec![1.0 / nodes as f64; nodes],
            presence => {
                let sum: f64 = presence.iter().sum();
                presence.iter().map(|presence| presence / sum).collect()
            }
        });
        Some(Self {
            case,
            network,
            inputs: unseen + columns,
            mean,
        })
    }

    /// True if the controller observes this node.
    pub(super) fn observes(&self, node: usize) -> bool {
        let count = self.case.lattice.nodes();
        let mut rows = self.network.first.weights.chunks_exact(self.inputs);
        let parts = 2 * self.case.lattice.dimension.count();
        let is_read = rows.any(|row| (0..parts).any(|part| row[part * count + node] != 0.0));
        is_read || self.mean.as_ref().is_some_and(|mean| mean[node] != 0.0)
    }

    /// The network whose inputs are the positions of `nodes`, node by node, then their velocities, then the other inputs.
    /// Its outputs are the activations of `actuators`.
    pub(super) fn reordered(&self, nodes: &[usize], actuators: &[usize]) -> Network<f64> {
        let count = self.case.lattice.nodes();
        let axes = self.case.lattice.dimension.count();
        let of_nodes = |part: usize| {
            let of_node = move |&node| (part..part + axes).map(move |part| part * count + node);
            nodes.iter().flat_map(of_node)
        };
        let others = 2 * axes * count..self.inputs;
        let columns: Vec<usize> = of_nodes(0).chain(of_nodes(axes)).chain(others).collect();
        let Network { first, second, .. } = &self.network;
        let rows = first.weights.chunks_exact(self.inputs);
        let hidden = first.biases.len();
        let of_edge = |&edge: &usize| &second.weights[edge * hidden..][..hidden];
        Network {
            first: Layer {
                weights: rows
                    .flat_map(|row| columns.iter().map(|&k| row[k]))
                    .collect(),
                biases: first.biases.clone(),
            },
            gates: self.network.gates.clone(),
            second: Layer {
                weights: actuators.iter().flat_map(of_edge).copied().collect(),
                biases: actuators.iter().map(|&edge| second.biases[edge]).collect(),
            },
        }
    }

    /// What a robot with given goals needs besides the network. `nodes` are the nodes of the model.
    pub(super) fn seen(&self, ground: &Ground, nodes: &[usize]) -> Option<GoalFields> {
        let mean = self.mean.as_ref()?;
        let (settings, dimension) = (&self.case.scene.controller, self.case.lattice.dimension);
        let payload = self.case.lattice.payload_point(&self.case.start, ground);
        Some(GoalFields {
            goal: dimension.list(settings.goal),
            goal_scale: settings.goal_scale,
            mean: nodes.iter().map(|&node| mean[node]).collect(),
            start: dimension.list(payload),
            gates: self.network.gates.clone(),
        })
    }
}
