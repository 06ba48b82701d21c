//! What a policy observes.

use std::f64::consts::TAU;

use autodiff::Real;

use crate::geometry::{Ground, Vector, mean, weighted_mean};
use crate::lattice::State;
use crate::scene::{ControllerSettings, Senses};

/// What a policy observes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sight {
    /// Clocks, goal, and the motion of the robot.
    Robot,
    /// Clocks and goal: the policy is open loop.
    Clock,
}

impl Sight {
    /// The length of an observation for a number of nodes, or the largest `usize` if it would be longer: a file may
    /// state an absurd number of clocks.
    pub fn length(self, settings: &ControllerSettings, nodes: usize) -> usize {
        let robot = match self {
            Self::Robot => 4 * nodes,
            Self::Clock => 0,
        };
        settings.clocks.saturating_add(2 + robot)
    }

    /// Whether an observation depends on positions and on velocities.
    pub fn senses(self, settings: &ControllerSettings) -> Senses {
        match self {
            Self::Robot => settings.senses(),
            Self::Clock => Senses::default(),
        }
    }

    /// Whether the observed goal moves with the robot.
    pub(super) fn follows_goal(self, settings: &ControllerSettings) -> bool {
        self == Self::Robot && settings.goal_relative
    }
}

/// The length of an observation of the [`Robot`](Sight::Robot).
pub fn observation_length(settings: &ControllerSettings, nodes: usize) -> usize {
    Sight::Robot.length(settings, nodes)
}

/// An observation of the robot: clocks; goal; offsets of the nodes from their mean (D3) as `x0, y0, x1, y1, ...`;
/// velocities of the nodes in the same order. Offsets and velocities are in the world's frame, the goal is in the
/// ground's frame (D3).
///
/// `time` is in seconds since the start. It must be computed as a product `n dt`, not as a sum of steps: phases reach
/// 164 rad, so rounding errors would matter. The state is in the world's frame. `presence` has the weight of each node
/// in the mean and in the observation; empty means that all nodes are present.
///
/// This function defines the observation. Rollouts do not call it; they [fold](super::Fold) it into the first layer of
/// a policy.
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
    let offsets = nodes.map(|(&x, &p)| (x - mean) * p);
    let velocities = v.iter().zip(presence).map(|(&v, &p)| v * p);
    let mut observation = Vec::with_capacity(observation_length(settings, x.len()));
    observation.extend(phases(settings).map(|phase| R::lit((turn + phase).sin())));
    observation.extend(goal(settings, mean, ground));
    observation.extend(offsets.flatten().map(|d| offset * d));
    observation.extend(velocities.flatten().map(|v| velocity * v));
    observation
}

/// `sin(omega t)` and `cos(omega t)`. Every clock is a weighted sum of the two. They are computed in double precision
/// even if the rollout is not. `time` must be a product `n dt`, as for [`observation`].
pub fn clock(settings: &ControllerSettings, time: f64) -> [f64; 2] {
    let (sin, cos) = (settings.omega * time).sin_cos();
    [sin, cos]
}

/// The phase of each clock relative to the first, in radians.
pub(super) fn phases(settings: &ControllerSettings) -> impl Iterator<Item = f64> {
    let count = settings.clocks;
    (0..count).map(move |j| TAU * j as f64 / count as f64)
}

/// The goal of the settings, or its offset from the mean position if it is relative, times the scale of the goal. Goal
/// and mean position are measured from the world's origin, along the ground and normal to it, like the displacement.
fn goal<R: Real>(settings: &ControllerSettings, mean: Vector<R>, ground: &Ground) -> Vector<R> {
    let scale = R::lit(settings.goal_scale);
    let goal = Vector::lit(settings.goal.into());
    if !settings.goal_relative {
        return goal * scale;
    }
    (goal - ground.vector_to_ground(mean)) * scale
}
