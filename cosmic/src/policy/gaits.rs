//! A policy with a gait for each direction, which the observed goal blends.

use autodiff::Real;
use autodiff_programs::{Array, Compiled, Kernel};

use super::block::{B2, Block, W2};
use super::sensing::Sight;
use super::step::{Policy, PolicyStep, Sizes};
use crate::geometry::Dimension;
use crate::kernel;
use crate::lattice::Sides;

/// A network whose hidden units are in groups: one for each direction of the goal, and one for a goal that is reached. The
/// observed goal is `g` along the ground and `h` across it; in the plane there is no `h`. The squares of both add up to less
/// than 1. The observed goal multiplies
///
/// - the units for a goal ahead by `(g^2 + g) / 2`, and those for a goal behind by `(g^2 - g) / 2`;
/// - in space, the units for a goal to the left by `(h^2 + h) / 2`, and those for a goal to the right by `(h^2 - h) / 2`;
/// - the units for a goal that is reached by `1 - g^2 - h^2`.
///
/// A robot that is its own mirror image (`lattice.mirror`) has no weights for a goal behind, or in space for a goal to the
/// right: what it does then is the mirror image of what it does if the goal is ahead, or to the left. So it walks one way
/// exactly as well as the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gaits;

/// A group of hidden units: the names of its weights and biases, and what its units are multiplied by.
pub(super) type Group = (&'static str, &'static str, Gate);

const AHEAD: Group = ("w1_ahead", "b1_ahead", Gate([0.0, 0.5, 0.5, 0.0, 0.0]));
const BEHIND: Group = ("w1_behind", "b1_behind", Gate([0.0, -0.5, 0.5, 0.0, 0.0]));
const LEFT: Group = ("w1_left", "b1_left", Gate([0.0, 0.0, 0.0, 0.5, 0.5]));
const RIGHT: Group = ("w1_right", "b1_right", Gate([0.0, 0.0, 0.0, -0.5, 0.5]));
const THERE: Group = ("w1_there", "b1_there", Gate([1.0, 0.0, -1.0, 0.0, -1.0]));
/// [`THERE`], halved because its image, which is added, has the same gate. In space that is also true of [`AHEAD`] and
/// [`BEHIND`], which are not halved: goals ahead and behind count twice as much as goals aside.
const HALF_THERE: Group = ("w1_there", "b1_there", Gate([0.5, 0.0, -0.5, 0.0, -0.5]));

/// The groups of hidden units. If sides of the robot are images of each other, each group is followed by its image, with the
/// [turned](Gate::of_image) gate.
pub(super) fn groups(dimension: Dimension, mirrored: Option<Sides>) -> &'static [Group] {
    match (dimension, mirrored) {
        (Dimension::Plane, None) => &[AHEAD, BEHIND, THERE],
        (Dimension::Plane, Some(_)) => &[AHEAD, HALF_THERE],
        (Dimension::Space, None) => &[AHEAD, BEHIND, LEFT, RIGHT, THERE],
        (Dimension::Space, Some(_)) => &[AHEAD, BEHIND, LEFT, HALF_THERE],
    }
}

/// Multiplies a hidden unit by the polynomial `a + b g + c g^2 + d h + e h^2` with the coefficients `[a, b, c, d, e]`, where
/// `g` is the observed goal along the ground, and `h` the one across it, which is 0 in the plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gate(pub(super) [f64; 5]);

impl Gate {
    /// The gate for the goal of the mirror image, which is behind if the goal is ahead and the sides are front and back.
    pub(super) const fn of_image(self, sides: Sides) -> Self {
        let Self([a, b, c, d, e]) = self;
        match sides {
            Sides::FrontAndBack => Self([a, -b, c, d, e]),
            Sides::LeftAndRight => Self([a, b, c, -d, e]),
        }
    }

    /// The product of a hidden unit and the polynomial of this goal.
    pub(super) fn of<R: Real>(self, unit: R, [g, h]: [R; 2]) -> R {
        let [product] = InSpace(self).eval([unit, g, h], &[]);
        product
    }
}

#[kernel]
impl Kernel<2, 1> for Gate {
    const COMPILED: Compiled = Compiled::Narrow;

    fn eval<R: Real>(&self, [unit, goal]: [R; 2], _: &[R]) -> [R; 1] {
        // Not `map`, which is not inlined into the loop around a kernel.
        let [a, b, c, _, _] = self.0;
        let (a, b, c) = (R::lit(a), R::lit(b), R::lit(c));
        [unit * (a + goal * (b + goal * c))]
    }
}

/// A gate in space, which reads both components of the goal.
#[derive(Clone, Copy, Debug)]
struct InSpace(Gate);

#[kernel]
impl Kernel<3, 1> for InSpace {
    const COMPILED: Compiled = Compiled::Seldom;

    fn eval<R: Real>(&self, [unit, along, across]: [R; 3], _: &[R]) -> [R; 1] {
        let [a, b, c, d, e] = self.0.0;
        let (a, b, c, d, e) = (R::lit(a), R::lit(b), R::lit(c), R::lit(d), R::lit(e));
        [unit * (a + along * (b + along * c) + across * (d + across * e))]
    }
}

impl Policy for Gaits {
    fn parameters(&self, robot: &Sizes) -> Vec<Block> {
        let (hidden, [first, second]) = (robot.settings.hidden, robot.settings.gain);
        let inputs = robot.observation(Sight::Robot);
        let groups = groups(robot.dimension, robot.mirrored);
        let of_group = |&(weights, biases, _): &Group| {
            [
                Block::weights(weights, hidden, inputs, first),
                Block::biases(biases, hidden),
            ]
        };
        let mut blocks: Vec<Block> = groups.iter().flat_map(of_group).collect();
        let units = groups.len() * hidden;
        blocks.push(Block::weights(W2, robot.edges, units, second));
        blocks.push(Block::biases(B2, robot.edges));
        blocks
    }

    fn record(&self, step: &mut PolicyStep) -> Array {
        let mirrored = step.mirrored();
        let mut units = Vec::new();
        for &(weights, biases, gate) in groups(step.dimension(), mirrored) {
            let own = step.observed_layer(weights, biases);
            units.push(gated(step, own, gate));
            if let Some(sides) = mirrored {
                let image = step.image_layer(weights, biases);
                units.push(gated(step, image, gate.of_image(sides)));
            }
        }
        if mirrored.is_some() {
            step.output_layer_with_images(W2, B2, &units)
        } else {
            step.output_layer_of(W2, B2, &units)
        }
    }
}

/// Records the gate of a group of hidden units.
fn gated(step: &mut PolicyStep, units: Array, gate: Gate) -> Array {
    let goal = step.observed_goal().expect("goals are given");
    let in_space = step.dimension() == Dimension::Space;
    let program = step.program();
    let mut component = |k| program.gather(goal, &vec![Some(k); units.len()]);
    let [gated] = if in_space {
        let (along, across) = (component(0), component(1));
        program.map(InSpace(gate), [units, along, across], &[])
    } else {
        let along = component(0);
        program.map(gate, [units, along], &[])
    };
    gated
}
