//! The losses of the tasks that a scene can choose. Each takes a few lines.
//!
//! They are also examples for users who write a loss. A loss reads only states, so the energy that a robot spends is
//! computed from its states: it is taken to be the energy that the damping removes.

use autodiff::Real;

use super::{Displacement, Loss};
use crate::geometry::Vector;
use crate::lattice::State;
use crate::scene::{LossSettings, ObjectiveSettings, PhysicsSettings, TaskKind};
use crate::simulator::Trajectory;

/// The loss of the task that a scene chooses.
#[derive(Clone, Debug, PartialEq)]
pub struct Objective {
    /// The settings of the task.
    pub settings: ObjectiveSettings,
    /// The loss of the task "far". It also has the ground, and the settings that decide which states all of these
    /// losses read.
    pub far: Displacement,
    /// The damping rate, in 1/s.
    pub damping: f64,
    /// The length of a step, in seconds.
    pub dt: f64,
}

impl Objective {
    /// Makes the loss from three sections of a scene.
    pub fn new(
        settings: &ObjectiveSettings,
        loss: &LossSettings,
        physics: &PhysicsSettings,
    ) -> Self {
        Self {
            settings: settings.clone(),
            far: Displacement {
                ground: physics.into(),
                settings: loss.clone(),
            },
            damping: physics.damping,
            dt: physics.dt,
        }
    }

    /// How far the robot is from the goal of the task "reach", m^2. It is the squared distance along the ground from
    /// the payload to the target, plus the square of the distance that the payload would cover in the time `settle`. So
    /// a payload that is near but fast has a large loss.
    fn off_target<R: Real>(&self, state: &State<R>) -> R {
        let along = self.far.ground.point_to_ground(state.x[0]).forward();
        let way = state.v[0] * R::lit(self.settings.settle);
        let off = along - R::lit(self.settings.target);
        off * off + way.dot(way)
    }

    /// The energy that damping removes from the start to the last observed state, J/kg.
    ///
    /// On level ground only the actuators add energy to a robot in the long run; contacts and damping remove it. Per
    /// mass, damping removes energy at a rate of `damping |v|^2`. States hold no masses, so `|v|^2` is averaged over
    /// the nodes with equal weights.
    fn energy<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        let square = |v: &Vector<R>| R::dot(v.as_slice(), v.as_slice());
        let at = |step: usize| {
            let squares: Vec<R> = trajectory.at(step).v.iter().map(square).collect();
            R::sum_of(&squares) * R::lit(1.0 / squares.len() as f64)
        };
        let observed = self.observed(trajectory.last_step());
        // The weight of a state is the number of steps since the observed state before it. For the first state, it is
        // the number of steps since the start.
        let since = |k: usize| observed[k] - k.checked_sub(1).map_or(0, |before| observed[before]);
        let weighed = |k: usize| at(observed[k]) * R::lit(since(k) as f64);
        let weighed: Vec<R> = (0..observed.len()).map(weighed).collect();
        R::sum_of(&weighed) * R::lit(self.damping * self.dt)
    }

    /// The mean of `of` over the states that the loss reads.
    fn mean<R: Real>(&self, trajectory: &Trajectory<R>, of: impl Fn(&State<R>) -> R) -> R {
        let observed = self.observed(trajectory.last_step());
        let values: Vec<R> = observed.iter().map(|&s| of(trajectory.at(s))).collect();
        R::sum_of(&values) * R::lit(1.0 / values.len() as f64)
    }
}

impl Loss for Objective {
    fn observed(&self, steps: usize) -> Vec<usize> {
        match self.settings.task {
            // Energy is spent over the whole rollout, so states of the whole rollout are observed.
            TaskKind::Economy => {
                let every = self.far.settings.every;
                (steps % every..=steps).step_by(every).collect()
            }
            _ => self.far.observed(steps),
        }
    }

    fn nodes(&self) -> usize {
        match self.settings.task {
            TaskKind::Economy => usize::MAX,
            _ => 1,
        }
    }

    fn is_far(&self) -> bool {
        self.settings.task == TaskKind::Far
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        match self.settings.task {
            TaskKind::Far => self.far.loss(trajectory),
            TaskKind::Back => -self.far.loss(trajectory),
            TaskKind::Reach => self.mean(trajectory, |state| self.off_target(state)),
            TaskKind::Climb => self.mean(trajectory, |state| -state.x[0].up()),
            TaskKind::Economy => {
                let price = R::lit(self.settings.energy_price);
                self.far.loss(trajectory) + self.energy(trajectory) * price
            }
        }
    }
}
