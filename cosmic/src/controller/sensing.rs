//! What a controller observes.

use std::f64::consts::TAU;

use autodiff::Real;
use serde::{Deserialize, Serialize};

use crate::lattice::{Ground, State};

/// The settings of an observation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sensing {
    /// How many clock signals.
    pub clocks: usize,
    /// Angular frequency of the clocks, rad/s.
    pub omega: f64,
    /// Goal in the ground's frame, m.
    pub goal: [f64; 2],
    /// Factor on the goal.
    pub goal_scale: f64,
    /// Whether the mean position of the nodes is taken off the goal (D3).
    pub goal_relative: bool,
    /// Factor on the node offsets.
    pub offset_scale: f64,
    /// Factor on the node velocities.
    pub velocity_scale: f64,
}

/// What there is to observe.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a, R> {
    /// Seconds since the start. It is a product `n dt`, never a sum: phases reach 164 rad.
    pub time: f64,
    /// The state in the world's frame.
    pub state: &'a State<R>,
    /// The ground, whose frame the goal is given in.
    pub ground: &'a Ground,
}

impl Sensing {
    /// The length of an observation of so many nodes.
    pub fn inputs(&self, nodes: usize) -> usize {
        self.clocks + 2 + 4 * nodes
    }

    /// `sin(omega t)` and `cos(omega t)`, of which every clock is a mixture; in double precision
    /// whatever the rollout runs in. `time` is a product `n dt`, see [`Moment::time`].
    pub fn clock(&self, time: f64) -> [f64; 2] {
        let (sin, cos) = (self.omega * time).sin_cos();
        [sin, cos]
    }

    /// How far each clock is ahead of the first, in radians.
    pub fn phases(&self) -> impl Iterator<Item = f64> {
        let count = self.clocks as f64;
        (0..self.clocks).map(move |j| TAU * j as f64 / count)
    }

    /// The observation: clocks; goal; offsets of the nodes from their unweighted mean as
    /// `x0, y0, x1, y1, ...`; velocities of the nodes likewise. Offsets and velocities are the
    /// world's, the goal is the ground's (D3).
    pub fn observation<R: Real>(&self, moment: &Moment<R>) -> Vec<R> {
        let State { x, v } = moment.state;
        let turn = self.omega * moment.time;
        let mean = mean(x);
        let offset = R::lit(self.offset_scale);
        let velocity = R::lit(self.velocity_scale);
        let mut observation = Vec::with_capacity(self.inputs(x.len()));
        observation.extend(self.phases().map(|phase| R::lit((turn + phase).sin())));
        observation.extend(self.goal_input(mean, moment.ground));
        let offsets = x.iter().map(|&[px, py]| [px - mean[0], py - mean[1]]);
        observation.extend(offsets.flatten().map(|d| offset * d));
        observation.extend(v.as_flattened().iter().map(|&v| velocity * v));
        observation
    }

    /// The goal as it enters: the numbers given, or what is left of them from the mean position,
    /// taken along the ground and across it as the displacement is.
    fn goal_input<R: Real>(&self, mean: [R; 2], ground: &Ground) -> [R; 2] {
        let scale = R::lit(self.goal_scale);
        let goal = self.goal.map(R::lit);
        if !self.goal_relative {
            return goal.map(|g| scale * g);
        }
        let [along, across] = ground.vector_to_ground(mean);
        [scale * (goal[0] - along), scale * (goal[1] - across)]
    }
}

/// The unweighted mean of points.
fn mean<R: Real>(points: &[[R; 2]]) -> [R; 2] {
    let share = R::lit(1.0 / points.len() as f64);
    [0, 1].map(|k| {
        let column: Vec<R> = points.iter().map(|point| point[k]).collect();
        R::sum(&column) * share
    })
}
