//! A policy with a gait for each direction, which the observed goal blends.

use autodiff::{Array, Kernel, Real};

use super::block::Block;
use super::sensing::Sight;
use super::step::{Policy, PolicyStep, Sizes};
use crate::kernel;
use crate::lattice::Sides;

/// A network whose hidden units are in three groups: one for a goal ahead, one for a goal behind, and one for a goal
/// that is reached. The observed goal `g` along the ground, from -1 to 1, multiplies them by `(g^2 + g) / 2`,
/// `(g^2 - g) / 2` and `1 - g^2`.
///
/// A robot in the plane that is its own mirror image (`lattice.mirror`) has no weights for a goal behind: what it does then
/// is the mirror image of what it does if the goal is ahead. So it walks back exactly as well as ahead.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gaits;

/// A group of hidden units: the names of its weights and biases, and what its units are multiplied by.
pub(super) type Group = (&'static str, &'static str, Gate);

/// The groups of hidden units.
const GAITS: [Group; 3] = [
    ("w1_ahead", "b1_ahead", Gate([0.0, 0.5, 0.5])),
    ("w1_behind", "b1_behind", Gate([0.0, -0.5, 0.5])),
    ("w1_there", "b1_there", Gate([1.0, 0.0, -1.0])),
];

/// The groups of a robot whose front and back are images of each other. Each is followed by its image, with the
/// [turned](Gate::of_image) gate.
const MIRRORED: [Group; 2] = [
    ("w1_ahead", "b1_ahead", Gate([0.0, 0.5, 0.5])),
    ("w1_there", "b1_there", Gate([0.5, 0.0, -0.5])),
];

/// The groups of hidden units of a robot whose sides are mirror images of each other, or are not.
pub(super) fn groups(mirrored: Option<Sides>) -> &'static [Group] {
    match mirrored {
        Some(Sides::FrontAndBack) => &MIRRORED,
        Some(Sides::LeftAndRight) | None => &GAITS,
    }
}

/// Multiplies a hidden unit by a polynomial of the observed goal, which has these coefficients, the constant first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gate(pub(super) [f64; 3]);

impl Gate {
    /// The gate for the goal of the mirror image, which is behind if the goal is ahead and the sides are front and back.
    pub(super) const fn of_image(self, sides: Sides) -> Self {
        let Self([a, b, c]) = self;
        match sides {
            Sides::FrontAndBack => Self([a, -b, c]),
            Sides::LeftAndRight => self,
        }
    }
}

#[kernel]
impl Kernel<2, 1> for Gate {
    fn eval<R: Real>(&self, [unit, goal]: [R; 2], _: &[R]) -> [R; 1] {
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
        let groups = groups(robot.mirrored);
        let of_group = |&(weights, biases, _): &Group| {
            [
                Block::weights(weights, hidden, inputs, first),
                Block::biases(biases, hidden),
            ]
        };
        let mut blocks: Vec<Block> = groups.iter().flat_map(of_group).collect();
        let units = groups.len() * hidden;
        blocks.push(Block::weights("w2", robot.edges, units, second));
        blocks.push(Block::biases("b2", robot.edges));
        blocks
    }

    fn record(&self, step: &mut PolicyStep) -> Array {
        let mirrored = step.mirrored();
        let mut units = Vec::new();
        for &(weights, biases, gate) in groups(mirrored) {
            let own = step.observed_layer(weights, biases);
            units.push(gated(step, own, gate));
            if let Some(sides) = mirrored {
                let image = step.image_layer(weights, biases);
                units.push(gated(step, image, gate.of_image(sides)));
            }
        }
        if mirrored.is_some() {
            step.output_layer_with_images("w2", "b2", &units)
        } else {
            step.output_layer_of("w2", "b2", &units)
        }
    }
}

/// Records the gate of a group of hidden units.
fn gated(step: &mut PolicyStep, units: Array, gate: Gate) -> Array {
    let goal = step.observed_goal().expect("goals are given");
    let goal = step.program().gather(goal, &vec![Some(0); units.len()]);
    let [gated] = step.program().map(gate, [units, goal], &[]);
    gated
}
