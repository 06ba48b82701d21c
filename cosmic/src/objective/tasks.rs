//! The losses of the tasks that a scene can choose. Each takes a few lines.
//!
//! For "position of the payload" read the [position](Trajectory::position) of the body that the scene names in
//! `objective.body`. The losses are also examples for users who write one.

use autodiff::Real;

use super::{Displacement, Loss};
use crate::geometry::Vector;
use crate::scene::{ObjectiveSettings, Scene, TaskKind};
use crate::world::Trajectory;

/// The loss of the task that a scene chooses.
#[derive(Clone, Debug, PartialEq)]
pub struct Objective {
    /// The settings of the task.
    pub settings: ObjectiveSettings,
    /// The loss of the task "far". It also has the ground, and the settings that decide which states all of these
    /// losses read.
    pub far: Displacement,
    /// The fixed goal in the ground's frame, measured from the world's origin, in metres. Its height does not count.
    pub goal: Vector<f64>,
    /// The largest actuation strain of an actuator. It tells the share of actuator in a mixture.
    pub actuator_strain: f64,
}

impl Objective {
    /// The loss of a scene's task.
    pub fn of_scene(scene: &Scene) -> Self {
        Self {
            settings: scene.objective.clone(),
            far: Displacement {
                ground: (&scene.physics).into(),
                settings: scene.loss.clone(),
            },
            goal: scene.controller.goal,
            actuator_strain: scene.materials.actuator_strain(),
        }
    }

    /// How far the robot is from the goal of the task "reach" after a number of steps, m^2. It is the squared distance
    /// along the ground (in space along and across) from the payload to the goal, plus the square of the distance that the
    /// payload would cover in the time `settle`. So a payload that is near but fast has a large loss.
    fn off_target<R: Real>(&self, seen: &Trajectory<R>, step: usize) -> R {
        let place = seen.position(step);
        let place = self.far.ground.vector_to_ground(place);
        let way = seen.velocity(step) * R::lit(self.settings.settle());
        let off = (place - Vector::lit(self.goal)).along();
        off.dot(off) + way.dot(way)
    }

    /// The energy that the actuators give to the robot, per mass of the robot, J/kg. A bar that is an actuator in part
    /// counts in part. While an actuator takes energy from the robot, it counts as 0.
    fn energy<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        let (effort, body) = (
            trajectory.effort(trajectory.last_step()),
            trajectory.robot(),
        );
        if self.actuator_strain == 0.0 {
            return R::zero();
        }
        let given = R::dot(&effort.work, &body.strain) * R::lit(1.0 / self.actuator_strain);
        let mass = match body.presence.is_empty() {
            true => R::sum_of(&body.mass),
            false => R::dot(&body.mass, &body.presence),
        };
        given / mass
    }

    /// The mean of `of` over the numbers of steps after which the loss reads a state.
    fn mean<R: Real>(&self, trajectory: &Trajectory<R>, of: impl Fn(usize) -> R) -> R {
        let observed = self.observed(trajectory.last_step());
        let values: Vec<R> = observed.iter().map(|&step| of(step)).collect();
        R::sum_of(&values) * R::lit(1.0 / values.len() as f64)
    }
}

impl Loss for Objective {
    fn observed(&self, steps: usize) -> Vec<usize> {
        self.far.observed(steps)
    }

    fn nodes(&self) -> usize {
        1
    }

    fn reads_efforts(&self) -> bool {
        self.settings.task == TaskKind::Economy
    }

    fn is_far(&self) -> bool {
        self.settings.task == TaskKind::Far
    }

    fn unit(&self, scale: f64) -> f64 {
        match self.settings.task {
            // The loss is the square of a length.
            TaskKind::Reach => scale * scale,
            _ => scale,
        }
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        match self.settings.task {
            TaskKind::Far => self.far.loss(trajectory),
            TaskKind::Back => -self.far.loss(trajectory),
            TaskKind::Reach => self.mean(trajectory, |step| self.off_target(trajectory, step)),
            TaskKind::Climb => self.mean(trajectory, |step| -trajectory.position(step).up()),
            TaskKind::Economy => {
                let price = R::lit(self.settings.energy_price());
                self.far.loss(trajectory) + self.energy(trajectory) * price
            }
        }
    }
}
