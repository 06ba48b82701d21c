//! The controller: clocks, goal and the robot's own motion in, one activation per edge out.

mod fold;
mod sensing;

pub use fold::Folded;
pub use sensing::{Moment, Sensing};

use autodiff::Real;
use serde::{Deserialize, Serialize};

use crate::lattice::Lattice;
use crate::random::{self, Purpose};

/// The size of a controller and the scale of its first weights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Network {
    /// Hidden units.
    pub hidden: usize,
    /// Factor on the Glorot range of each layer's first weights.
    pub gain: [f64; 2],
}

/// A network of one hidden layer: `tanh(W2 tanh(W1 I + b1) + b2)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Controller<R> {
    /// Hidden units.
    pub hidden: usize,
    /// Length of an observation.
    pub inputs: usize,
    /// Weights of the first layer, `hidden x inputs`, row by row.
    pub w1: Vec<R>,
    /// Biases of the first layer.
    pub b1: Vec<R>,
    /// Weights of the second layer, `edges x hidden`, row by row.
    pub w2: Vec<R>,
    /// Biases of the second layer, one per edge.
    pub b2: Vec<R>,
}

impl<R: Real> Controller<R> {
    /// How many activations it gives.
    pub fn edges(&self) -> usize {
        self.b2.len()
    }

    /// The activation of every edge, in `[-1, 1]`, from an [observation](Sensing::observation).
    pub fn activation(&self, observation: &[R]) -> Vec<R> {
        let hidden = layer(&self.w1, &self.b1, observation);
        layer(&self.w2, &self.b2, &hidden)
    }
}

impl Controller<f64> {
    /// Glorot's uniform initialisation from a seed, biases zero.
    pub fn xavier(network: &Network, sensing: &Sensing, lattice: &Lattice, seed: u64) -> Self {
        let (hidden, edges) = (network.hidden, lattice.edges.len());
        let inputs = sensing.inputs(lattice.nodes());
        let mut stream = random::stream(seed, Purpose::Weights);
        let mut weights = |outputs: usize, inputs: usize, gain: f64| -> Vec<f64> {
            let limit = gain * (6.0 / (inputs + outputs) as f64).sqrt();
            let draw = |_| random::symmetric(&mut stream, limit);
            (0..outputs * inputs).map(draw).collect()
        };
        Self {
            hidden,
            inputs,
            w1: weights(hidden, inputs, network.gain[0]),
            b1: vec![0.0; hidden],
            w2: weights(edges, hidden, network.gain[1]),
            b2: vec![0.0; edges],
        }
    }

    /// The same weights as constants of another type.
    pub fn lift<R: Real>(&self) -> Controller<R> {
        let lift = |weights: &[f64]| weights.iter().map(|&w| R::lit(w)).collect();
        Controller {
            hidden: self.hidden,
            inputs: self.inputs,
            w1: lift(&self.w1),
            b1: lift(&self.b1),
            w2: lift(&self.w2),
            b2: lift(&self.b2),
        }
    }
}

/// `tanh(W input + b)`, `W` row by row.
fn layer<R: Real>(weights: &[R], biases: &[R], input: &[R]) -> Vec<R> {
    weights
        .chunks_exact(input.len())
        .zip(biases)
        .map(|(row, &bias)| (R::dot(row, input) + bias).tanh())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{Controller, Network, Sensing};
    use crate::lattice::{Grid, Ground, Lattice};

    fn controller(seed: u64) -> Controller<f64> {
        let network = Network {
            hidden: 32,
            gain: [2.0, 1.0],
        };
        let sensing = Sensing {
            clocks: 10,
            omega: 10.0,
            goal: [2.0, 0.1],
            goal_scale: 0.05,
            goal_relative: false,
            offset_scale: 0.05,
            velocity_scale: 0.05,
        };
        let grid = Grid {
            columns: 6,
            rows: 6,
            spacing: 0.1,
            origin_x: 0.1,
            drop: 0.0,
            ground: Ground {
                height: 0.1,
                incline_deg: 0.0,
            },
        };
        Controller::xavier(&network, &sensing, &Lattice::new(&grid), seed)
    }

    #[test]
    fn shapes_are_those_of_the_paper() {
        let c = controller(0);
        assert_eq!((c.inputs, c.hidden, c.edges()), (156, 32, 110));
        let lengths = [&c.w1, &c.b1, &c.w2, &c.b2].map(Vec::len);
        assert_eq!(lengths, [32 * 156, 32, 110 * 32, 110]);
    }

    #[test]
    fn weights_fill_the_glorot_range_and_biases_are_zero() {
        let c = controller(0);
        let largest = |w: &[f64]| w.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let (first, second) = (2.0 * (6.0f64 / 188.0).sqrt(), (6.0f64 / 142.0).sqrt());
        // Of thousands of draws the largest is within a per cent of the limit.
        assert!(largest(&c.w1) <= first && largest(&c.w1) > 0.99 * first);
        assert!(largest(&c.w2) <= second && largest(&c.w2) > 0.99 * second);
        assert!(c.b1.iter().chain(&c.b2).all(|&b| b == 0.0));
    }

    #[test]
    fn a_seed_names_its_weights() {
        assert_eq!(controller(3), controller(3));
        assert_ne!(controller(3).w1, controller(4).w1);
    }
}
