//! The observation of a policy.

use std::f64::consts::TAU;

use autodiff::Real;

use super::goals::towards;
use crate::geometry::{Dimension, Ground, Vector, mean, weighted_mean};
use crate::lattice::State;
use crate::scene::{ControllerSettings, GoalKind, Senses};

/// What a policy observes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sight {
    /// The clocks, the goal, and the positions and velocities of the robot.
    Robot,
    /// Only the clocks and the goal: the policy is open loop.
    Clock,
}

impl Sight {
    /// The number of entries in an observation of a robot with this number of nodes.
    pub fn length(
        self,
        settings: &ControllerSettings,
        dimension: Dimension,
        nodes: usize,
    ) -> usize {
        settings.observation_length(
            dimension,
            match self {
                Self::Robot => nodes,
                Self::Clock => 0,
            },
        )
    }

    /// Says whether an observation depends on the positions, and whether it depends on the velocities.
    pub fn senses(self, settings: &ControllerSettings) -> Senses {
        match self {
            Self::Robot => settings.senses(),
            Self::Clock => Senses::default(),
        }
    }

    /// True if the policy observes a goal that is given to the rollout. A policy in open loop does not know such a goal.
    pub(super) fn sees_given_goal(self, settings: &ControllerSettings) -> bool {
        self == Self::Robot && settings.goals == GoalKind::Given && settings.goal_scale != 0.0
    }

    /// True if the goal in the observation moves with the robot and is folded into the weights of a layer.
    pub(super) fn follows_goal(self, settings: &ControllerSettings) -> bool {
        self == Self::Robot && settings.goal_relative && settings.goals != GoalKind::Given
    }
}

/// An observation of the robot. Its entries are the clocks, the goal, the offsets of the nodes from their mean position
/// (D3) as `x0, y0, x1, y1, ...`, and the velocities of the nodes in the same order. Offsets and velocities are in the
/// world's frame. The goal is in the ground's frame (D3).
///
/// `phase` is the phase of the clock in radians: its [frequency](super::frequency()) times the time. The time must be
/// computed as a product `n dt`, not as a sum of steps: phases reach 164 rad, so rounding errors would matter. The state
/// is in the world's frame. `presence` has the presence of each node: its weight in the mean and in the observation;
/// empty means that all nodes are present.
///
/// This function defines the observation. Rollouts do not call it; they [fold](super::Fold) it into the first layer of
/// a policy.
pub fn observation<R: Real>(
    settings: &ControllerSettings,
    phase: f64,
    state: &State<R>,
    presence: &[R],
    ground: &Ground,
) -> Vec<R> {
    let State { x, v, .. } = state;
    let whole = vec![R::one(); x.len()];
    let (mean, presence) = match presence {
        [] => (mean(x), &whole[..]),
        _ => (weighted_mean(x, presence), presence),
    };
    let [offset, velocity] = [settings.offset_scale, settings.velocity_scale].map(R::lit);
    let nodes = x.iter().zip(presence);
    let offsets = nodes.map(|(&x, &p)| (x - mean) * p);
    let velocities = v.iter().zip(presence).map(|(&v, &p)| v * p);
    let mut observation = Vec::with_capacity(settings.observation_length(state.dimension, x.len()));
    observation.extend(phases(settings).map(|ahead| R::lit((phase + ahead).sin())));
    let dimension = state.dimension;
    observation.extend(dimension.components(goal(settings, (dimension, mean), ground)));
    observation.extend(offsets.flat_map(|d| dimension.components(d * offset)));
    observation.extend(velocities.flat_map(|v| dimension.components(v * velocity)));
    observation
}

/// The parts of an observation, or of a row of weights that multiply an observation.
pub(super) struct Parts<'a, R> {
    pub(super) clocks: &'a [R],
    pub(super) goal: &'a [R],
    /// The parts for the offsets of the nodes, node by node; empty if the robot is not observed.
    pub(super) offsets: &'a [R],
    /// Like `offsets`, for the velocities.
    pub(super) velocities: &'a [R],
}

impl<'a, R> Parts<'a, R> {
    pub(super) fn of(observation: &'a [R], clocks: usize, dimension: Dimension) -> Self {
        let (clocks, rest) = observation.split_at(clocks);
        let (goal, of_nodes) = rest.split_at(dimension.count());
        let (offsets, velocities) = of_nodes.split_at(of_nodes.len() / 2);
        Self {
            clocks,
            goal,
            offsets,
            velocities,
        }
    }
}

/// The sine and the cosine of the clock's phase, from which every clock signal is a weighted sum. They are computed in
/// double precision even if the rollout is not. The phase must be computed as for [`observation`].
pub fn clock(phase: f64) -> [f64; 2] {
    let (sin, cos) = phase.sin_cos();
    [sin, cos]
}

/// The phase of each clock in radians. The first clock has phase 0.
pub(super) fn phases(settings: &ControllerSettings) -> impl Iterator<Item = f64> {
    let count = settings.clocks;
    (0..count).map(move |j| TAU * j as f64 / count as f64)
}

/// The observed goal: the goal of the settings, or its offset from the mean position if the settings make it relative.
/// The result is multiplied by the scale of the goal. A goal that is given to a rollout is observed as its offset, which
/// is bounded. Goal and mean position are measured from the world's origin, along the ground, in space across, and normal
/// to it, like the displacement.
fn goal<R: Real>(
    settings: &ControllerSettings,
    (dimension, mean): (Dimension, Vector<R>),
    ground: &Ground,
) -> Vector<R> {
    let scale = R::lit(settings.goal_scale);
    let goal = Vector::lit(settings.goal);
    let offset = || goal - ground.vector_to_ground(mean);
    match (settings.goals, settings.goal_relative) {
        (GoalKind::Given, _) => towards(dimension, offset(), settings.goal_scale),
        (_, true) => offset() * scale,
        (_, false) => goal * scale,
    }
}
