//! A policy with a gait for each direction, which the observed goal blends.

use autodiff::arrays::Kernel;
use autodiff::{Array, Real};

use super::block::Block;
use super::policy::{Policy, Sizes};
use super::sensing::Sight;
use super::step::PolicyStep;

/// A network whose hidden units are in three groups: one for a goal ahead, one for a goal behind, and one for a goal
/// that is reached. The observed goal `g` along the ground, from -1 to 1, multiplies them by `(g^2 + g) / 2`,
/// `(g^2 - g) / 2` and `1 - g^2`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gaits;

/// The groups of hidden units: the names of their weights and biases, and what they are multiplied by.
pub(super) const GAITS: [(&str, &str, Gate); 3] = [
    ("w1_ahead", "b1_ahead", Gate([0.0, 0.5, 0.5])),
    ("w1_behind", "b1_behind", Gate([0.0, -0.5, 0.5])),
    ("w1_there", "b1_there", Gate([1.0, 0.0, -1.0])),
];

/// Multiplies a hidden unit by a polynomial of the observed goal, which has these coefficients, the constant first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gate(pub(super) [f64; 3]);

impl Kernel<2, 1> for Gate {
    #[inline(always)]
    fn eval<R: Real>(&self, [unit, goal]: [R; 2]) -> [R; 1] {
        // Not `map`, which is not inlined into the loop around a kernel.
        let [a, b, c] = self.0;
        let (a, b, c) = (R::lit(a), R::lit(b), R::lit(c));
        [unit * (a + goal * (b + goal * c))]
    }
}

impl Policy for Gaits {
    fn parameters(&self, robot: &Sizes) -> Vec<Block> {
        let (hidden, [first, second]) = (robot.settings.hidden, robot.settings.gain);
        let inputs = robot.observation(Sight::Robot);
        let of_gait = |(weights, biases, _)| {
            [
                Block::weights(weights, hidden, inputs, first),
                Block::biases(biases, hidden),
            ]
        };
        let mut blocks = GAITS.map(of_gait).concat();
        blocks.push(Block::weights("w2", robot.edges, 3 * hidden, second));
        blocks.push(Block::biases("b2", robot.edges));
        blocks
    }

    fn record(&self, step: &mut PolicyStep) -> Array {
        let units = GAITS.map(|(weights, biases, gate)| {
            let units = step.observed_layer(weights, biases);
            let goal = step.observed_goal().expect("goals are given");
            let goal = step.program().gather(goal, &vec![Some(0); units.len()]);
            let [gated] = step.program().map(gate, [units, goal]);
            gated
        });
        step.output_layer_of("w2", "b2", &units)
    }
}
