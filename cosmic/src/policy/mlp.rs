//! The paper's policy: a network with one hidden layer.

use autodiff::{Array, Real};

use super::block::{Block, Controller};
use super::fold::{Fold, Mean};
use super::policy::{Policy, Sizes};
use super::sensing::Sight;
use super::step::PolicyStep;
use crate::geometry::Ground;
use crate::scene::ControllerSettings;

/// The names of the network's blocks in order: weights and biases of the hidden layer, weights and biases of the output
/// layer.
pub const NETWORK: [&str; 4] = ["w1", "b1", "w2", "b2"];
const W1: &str = NETWORK[0];
const B1: &str = NETWORK[1];
const W2: &str = NETWORK[2];
const B2: &str = NETWORK[3];

/// A network with one hidden layer that observes the robot: `tanh(W2 tanh(W1 o + b1) + b2)` of the observation `o`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mlp;

impl Policy for Mlp {
    fn parameters(&self, robot: &Sizes) -> Vec<Block> {
        blocks(robot, robot.observation(Sight::Robot))
    }

    fn record(&self, step: &mut PolicyStep) -> Array {
        record(step)
    }
}

/// The blocks of a network whose observation has `inputs` numbers.
pub(super) fn blocks(robot: &Sizes, inputs: usize) -> Vec<Block> {
    let (hidden, [first, second]) = (robot.settings.hidden, robot.settings.gain);
    vec![
        Block::weights(W1, hidden, inputs, first),
        Block::biases(B1, hidden),
        Block::weights(W2, robot.edges, hidden, second),
        Block::biases(B2, robot.edges),
    ]
}

/// Records both layers of a network. Returns the activations.
pub(super) fn record(step: &mut PolicyStep) -> Array {
    let hidden = step.observed_layer(W1, B1);
    step.output_layer(W2, B2, hidden)
}

/// The parameters of a layer `tanh(W x + b)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer<R> {
    /// The weights `W`, row by row. Each row belongs to an output.
    pub weights: Vec<R>,
    /// The biases `b`, one per output.
    pub biases: Vec<R>,
}

/// The two layers of a network with one hidden layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Network<R> {
    /// The layer from the inputs to the hidden units.
    pub first: Layer<R>,
    /// The layer from the hidden units to the activations.
    pub second: Layer<R>,
}

impl<R: Real> Network<R> {
    /// The network whose parameters a controller holds; `None` if the controller belongs to another policy.
    pub fn of(controller: &Controller<R>) -> Option<Self> {
        let is_network = controller.blocks().map(|(name, ..)| name).eq(NETWORK);
        let layer = |[weights, biases]: [&str; 2]| Layer {
            weights: controller.block(weights).to_vec(),
            biases: controller.block(biases).to_vec(),
        };
        is_network.then(|| Self {
            first: layer([W1, B1]),
            second: layer([W2, B2]),
        })
    }

    /// This network with a [folded](Fold) first layer, which takes the state in the ground's frame. If `presence` is
    /// empty, all nodes are present.
    ///
    /// # Panics
    /// If the network does not fit the observation of these settings.
    pub fn folded(
        &self,
        settings: &ControllerSettings,
        nodes: usize,
        presence: &[R],
        ground: &Ground,
    ) -> Self {
        let mean = match presence {
            [] => Mean::OfAll,
            presence => Mean::Folded(presence),
        };
        let fold = Fold::new(settings, ground, nodes, Sight::Robot, mean);
        let Layer { weights, biases } = &self.first;
        Self {
            first: Layer {
                biases: fold.biases(weights, biases),
                weights: fold.weights(weights),
            },
            second: self.second.clone(),
        }
    }

    /// The activations that the network computes from `inputs`.
    pub fn activation(&self, inputs: &[R]) -> Vec<R> {
        self.second.outputs(&self.first.outputs(inputs))
    }
}

impl<R: Real> Layer<R> {
    /// The outputs `tanh(W x + b)` of this layer for the inputs `x`.
    fn outputs(&self, x: &[R]) -> Vec<R> {
        let sums = autodiff::fused::dense(&self.weights, x, &self.biases);
        sums.into_iter().map(R::tanh).collect()
    }
}

impl<R: Real> Controller<R> {
    /// Makes a network ignore its inputs: the activation of each edge becomes `tanh` of its entry in `biases`.
    ///
    /// # Panics
    /// If the controller is not a network, or if there is not one bias per edge.
    pub fn hold_outputs(&mut self, biases: &[R]) {
        self.block_mut(W2).fill(R::zero());
        self.block_mut(B2).copy_from_slice(biases);
    }
}

#[cfg(test)]
mod tests {
    use super::Network;
    use crate::geometry::{Ground, Vector};
    use crate::lattice::{Lattice, State};
    use crate::policy::{Controller, clock, observation};
    use crate::random::{Purpose, stream, symmetric};
    use crate::scene::{ControllerSettings, Scene};

    /// The inputs of the folded network: the state in the ground's frame and the clock.
    fn sensed(state: &State<f64>, clock: &[f64]) -> Vec<f64> {
        [&state.to_columns()[..], clock].concat()
    }

    fn random_state(nodes: usize) -> State<f64> {
        let mut stream = stream(1, Purpose::Judgement);
        let mut point = |_| Vector::from_fn(|_| symmetric(&mut stream, 1.0));
        State {
            x: (0..nodes).map(&mut point).collect(),
            v: (0..nodes).map(&mut point).collect(),
        }
    }

    /// Checks that two networks compute the same activations: the folded network from the state, and the original
    /// network from the observation.
    fn check(settings: &ControllerSettings, presence: &[f64], ground: &Ground) {
        let lattice = Lattice::sample(3, 2, 0.0);
        let state = random_state(lattice.nodes());
        let controller = Controller::xavier(settings, &lattice, 0);
        let mut network = Network::of(&controller).unwrap();
        network.first.biases.fill(0.2);
        network.second.biases.fill(-0.1);
        let time = 4096.0 * 0.002;
        let plain = network.activation(&observation(settings, time, &state, presence, ground));
        let sensed = sensed(&state.to_ground(ground), &clock(settings, time));
        let folded = network.folded(settings, lattice.nodes(), presence, ground);
        let got = folded.activation(&sensed);
        assert_eq!(got.len(), plain.len());
        for (a, b) in got.iter().zip(&plain) {
            // Each sum has about thirty terms of order one, each with a rounding error of 1e-16. The phase of a clock
            // is near 82 rad, with a rounding error of 1e-14.
            assert!((a - b).abs() < 1e-13);
        }
    }

    #[test]
    fn folding_changes_nothing_but_the_rounding() {
        for incline_deg in [0.0, 15.0, -40.0] {
            for (goal_relative, clocks) in [(false, 10), (true, 10), (true, 3), (false, 0)] {
                let settings = ControllerSettings {
                    hidden: 7,
                    clocks,
                    goal_scale: 0.7,
                    goal_relative,
                    offset_scale: 1.3,
                    velocity_scale: 0.4,
                    ..ControllerSettings::default()
                };
                let ground = Ground {
                    height: 0.3,
                    incline_deg,
                };
                check(&settings, &[], &ground);
                check(&settings, &[1.0, 0.3, 0.0, 0.9, 1e-3, 1.0], &ground);
            }
        }
    }

    #[test]
    fn the_network_has_the_paper_s_shapes_and_glorot_weights() {
        let mut scene = Scene::paper();
        scene.controller.gain = [2.0, 1.0];
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let controller = Controller::xavier(&scene.controller, &lattice, 0);
        let Network { first, second } = Network::of(&controller).unwrap();
        let lengths = [
            &first.weights,
            &first.biases,
            &second.weights,
            &second.biases,
        ]
        .map(Vec::len);
        assert_eq!(lengths, [32 * 156, 32, 110 * 32, 110]);
        let largest = |w: &[f64]| w.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        // With thousands of draws, the largest draw is within a per cent of the limit.
        for (layer, limit) in [
            (&first, 2.0 * (6.0f64 / 188.0).sqrt()),
            (&second, (6.0f64 / 142.0).sqrt()),
        ] {
            let weights = largest(&layer.weights);
            assert!(weights <= limit && weights > 0.99 * limit);
            assert!(layer.biases.iter().all(|&b| b == 0.0));
        }
    }
}
