//! The paper's policy: a network with one hidden layer.

use autodiff::Real;
use autodiff_programs::Array;

use super::block::{B1, B2, Block, Controller, W1, W2};
use super::fold::{Fold, Mean};
use super::gaits::{Gate, groups};
use super::image;
use super::sensing::Sight;
use super::step::{Policy, PolicyStep, Sizes};
use super::tempo::TEMPO;
use crate::geometry::{Dimension, Ground};
use crate::lattice::{Lattice, Sides};
use crate::scene::ControllerSettings;

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

/// Records both layers of a network. Returns the activations. If left and right are images of each other, the activations of
/// the image of a robot are the images of the activations, so that a robot that begins straight ahead stays on course.
pub(super) fn record(step: &mut PolicyStep) -> Array {
    let hidden = step.observed_layer(W1, B1);
    if step.mirrored() == Some(Sides::LeftAndRight) {
        let image = step.image_layer(W1, B1);
        return step.output_layer_with_images(W2, B2, &[hidden, image]);
    }
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

/// The two layers of a network with one hidden layer: of the policy [`Mlp`], [`Clock`](super::Clock) or
/// [`Gaits`](super::Gaits).
#[derive(Clone, Debug, PartialEq)]
pub struct Network<R> {
    /// The layer from the inputs to the hidden units. The groups of units of [`Gaits`](super::Gaits) come one after the
    /// other.
    pub first: Layer<R>,
    /// For each hidden unit of [`Gaits`](super::Gaits), the coefficients `[a, b, c, d, e]` of the factor by which the unit is
    /// multiplied: `a + b g + c g^2 + d h + e h^2`. Here `g` is the observed goal along the ground, and `h` the one across it,
    /// which is 0 in the plane. Empty for other policies.
    pub gates: Vec<[f64; 5]>,
    /// The layer from the hidden units to the activations.
    pub second: Layer<R>,
}

impl<R: Real> Network<R> {
    /// The network of a controller for a robot on this lattice; `None` if the controller belongs to another policy. The tempo
    /// of a learned clock is not a part of the network.
    pub fn of(
        controller: &Controller<R>,
        settings: &ControllerSettings,
        lattice: &Lattice,
    ) -> Option<Self> {
        let names = controller.blocks().map(|(name, ..)| name);
        let names: Vec<&str> = names.filter(|name| *name != TEMPO).collect();
        let (of_units, second) = names.split_at(names.len().checked_sub(2)?);
        let mirror = lattice.mirror.as_ref();
        let sides = mirror.map(|mirror| mirror.sides);
        let groups = groups(lattice.dimension, sides);
        let of_gaits = groups
            .iter()
            .flat_map(|&(weights, biases, _)| [weights, biases]);
        let is_gaits = of_gaits.eq(of_units.iter().copied());
        if !(is_gaits || of_units == [W1, B1]) || second != [W2, B2] {
            return None;
        }
        let [weights, biases] = [W2, B2].map(|name| controller.block(name));
        let mut network = Self {
            first: Layer {
                weights: Vec::new(),
                biases: Vec::new(),
            },
            gates: Vec::new(),
            second: Layer {
                weights: weights.to_vec(),
                biases: biases.to_vec(),
            },
        };
        let groups: Vec<_> = match is_gaits {
            true => groups
                .iter()
                .map(|&(weights, biases, gate)| (weights, biases, Some(gate)))
                .collect(),
            false => vec![(W1, B1, None)],
        };
        // The image of a network without gates acts if it walks the same way.
        let mirror = mirror.filter(|_| is_gaits || sides == Some(Sides::LeftAndRight));
        for &(weights, biases, gate) in &groups {
            let (weights, biases) = (controller.block(weights), controller.block(biases));
            network.add(weights.to_vec(), biases, gate);
            if let Some(mirror) = mirror {
                let sizes = (weights.len() / biases.len(), settings.clocks);
                let of_image = image::observed(weights, sizes, lattice.dimension, mirror);
                let gate = gate.map(|gate| gate.of_image(mirror.sides));
                network.add(of_image, biases, gate);
            }
        }
        if let Some(mirror) = mirror {
            let edges: Vec<usize> = (0..lattice.edges.len()).collect();
            let part = network.first.biases.len() / (2 * groups.len());
            network.second = Layer {
                weights: image::moved(weights, &edges, part, mirror),
                biases: image::biases(biases, &edges, mirror),
            };
        }
        Some(network)
    }

    /// Adds hidden units with these weights and biases.
    fn add(&mut self, weights: Vec<R>, biases: &[R], gate: Option<Gate>) {
        self.first.weights.extend(weights);
        self.first.biases.extend_from_slice(biases);
        self.gates
            .extend(gate.iter().flat_map(|gate| vec![gate.0; biases.len()]));
    }

    /// This network with a [folded](Fold) first layer, which takes the state in the ground's frame. `sight` is what its
    /// policy observes. If `presence` is empty, all nodes are present.
    ///
    /// # Panics
    /// If the network does not fit the observation of these settings.
    pub fn folded(
        &self,
        settings: &ControllerSettings,
        nodes: (Dimension, usize),
        sight: Sight,
        presence: &[R],
        ground: &Ground,
    ) -> Self {
        let mean = match presence {
            [] => Mean::OfAll,
            presence => Mean::Folded(presence),
        };
        let fold = Fold::new(settings, ground, nodes, sight, mean);
        let Layer { weights, biases } = &self.first;
        Self {
            first: Layer {
                biases: fold.biases(weights, biases),
                weights: fold.weights(weights),
            },
            gates: self.gates.clone(),
            second: self.second.clone(),
        }
    }

    /// The activations that the network computes from `inputs`. `goal` is the observed goal along the ground and
    /// across it, which only the gates read.
    pub fn activation(&self, inputs: &[R], goal: [R; 2]) -> Vec<R> {
        let mut hidden = self.first.outputs(inputs);
        for (unit, &gate) in hidden.iter_mut().zip(&self.gates) {
            *unit = Gate(gate).of(*unit, goal);
        }
        self.second.outputs(&hidden)
    }
}

impl<R: Real> Layer<R> {
    /// The outputs `tanh(W x + b)` of this layer for the inputs `x`.
    fn outputs(&self, x: &[R]) -> Vec<R> {
        let sums = autodiff::fused::dense(&self.weights, x, &self.biases);
        sums.into_iter().map(R::tanh).collect()
    }
}
