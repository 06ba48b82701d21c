//! What a policy sees: its observation, as an equation.

use std::f64::consts::TAU;

use autodiff::Real;

use crate::ground::Ground;
use crate::lattice::{State, mean};
use crate::scene::ControllerSettings;

/// What a policy sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sight {
    /// Clocks, goal, and the robot's own motion.
    Robot,
    /// Clocks and goal: the policy is open loop.
    Clock,
}

impl Sight {
    /// The length of an observation of so many nodes. Absurd numbers of clocks, as a file may have
    /// them, give an absurd length, which nothing fits.
    pub fn length(self, settings: &ControllerSettings, nodes: usize) -> usize {
        let robot = match self {
            Self::Robot => 4 * nodes,
            Self::Clock => 0,
        };
        settings.clocks.saturating_add(2 + robot)
    }

    /// Whether positions and velocities make any difference to an observation.
    pub fn senses(self, settings: &ControllerSettings) -> [bool; 2] {
        match self {
            Self::Robot => settings.senses(),
            Self::Clock => [false; 2],
        }
    }

    /// Whether the observed goal moves with the robot.
    pub(super) fn follows_goal(self, settings: &ControllerSettings) -> bool {
        self == Self::Robot && settings.goal_relative
    }
}

/// The length of an observation with the [`Robot`](Sight::Robot) in it.
pub fn observation_length(settings: &ControllerSettings, nodes: usize) -> usize {
    Sight::Robot.length(settings, nodes)
}

/// An observation of the robot: clocks; goal; offsets of the nodes from their mean (D3) as
/// `x0, y0, x1, y1, ...`; velocities of the nodes likewise. Offsets and velocities are taken in
/// the world's frame, the goal in the ground's (D3).
///
/// `time` is in seconds since the start: a product `n dt`, never a sum, as phases reach 164 rad. The
/// state is in the world's frame. `presence` weighs the nodes in the mean, and what is observed of each;
/// empty, every node counts alike.
///
/// This is the definition. A rollout [folds](super::Fold) it into the first layer of a policy.
pub fn observation<R: Real>(
    settings: &ControllerSettings,
    time: f64,
    state: &State<R>,
    presence: &[R],
    ground: &Ground,
) -> Vec<R> {
    let State { x, v } = state;
    let turn = settings.omega * time;
    let whole = vec![R::one(); x.len()];
    let (mean, presence) = match presence {
        [] => (mean(x), &whole[..]),
        _ => (weighted_mean(x, presence), presence),
    };
    let [offset, velocity] = [settings.offset_scale, settings.velocity_scale].map(R::lit);
    let nodes = x.iter().zip(presence);
    let offsets = nodes.map(|(&[px, py], &p)| [p * (px - mean[0]), p * (py - mean[1])]);
    let velocities = v.iter().zip(presence).map(|(v, &p)| v.map(|v| p * v));
    let mut observation = Vec::with_capacity(observation_length(settings, x.len()));
    observation.extend(phases(settings).map(|phase| R::lit((turn + phase).sin())));
    observation.extend(goal(settings, mean, ground));
    observation.extend(offsets.flatten().map(|d| offset * d));
    observation.extend(velocities.flatten().map(|v| velocity * v));
    observation
}

fn weighted_mean<R: Real>(points: &[[R; 2]], weights: &[R]) -> [R; 2] {
    let sum = R::sum_of(weights);
    [0, 1].map(|k| {
        let column: Vec<R> = points.iter().map(|point| point[k]).collect();
        R::dot(&column, weights) / sum
    })
}

/// `sin(omega t)` and `cos(omega t)`, of which every clock is a mixture; in double precision
/// whatever the rollout runs in. `time` is a product `n dt`, as for [`observation`].
pub fn clock(settings: &ControllerSettings, time: f64) -> [f64; 2] {
    let (sin, cos) = (settings.omega * time).sin_cos();
    [sin, cos]
}

/// How far each clock is ahead of the first, in radians.
pub(super) fn phases(settings: &ControllerSettings) -> impl Iterator<Item = f64> {
    let count = settings.clocks;
    (0..count).map(move |j| TAU * j as f64 / count as f64)
}

/// The goal as it enters: the numbers given, or what is left of them from the mean position,
/// measured along the ground and across it from the world's origin, as the displacement is.
fn goal<R: Real>(settings: &ControllerSettings, mean: [R; 2], ground: &Ground) -> [R; 2] {
    let scale = R::lit(settings.goal_scale);
    let goal = settings.goal.map(R::lit);
    if !settings.goal_relative {
        return goal.map(|g| scale * g);
    }
    let [along, across] = ground.vector_to_ground(mean);
    [scale * (goal[0] - along), scale * (goal[1] - across)]
}
