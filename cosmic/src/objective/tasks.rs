//! The losses of the tasks that a scene can choose. Each takes a few lines.
//!
//! Where they read the position of the payload, they read the [position](Trajectory::position) of the body that the
//! scene names in `objective.body`. They are also examples for users who write a loss. A loss reads only states, so the
//! energy that a robot spends is computed from its states: it is taken to be the energy that the damping removes.

use autodiff::Real;

use super::{Displacement, Loss};
use crate::geometry::Vector;
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

    /// How far the robot is from the goal of the task "reach" after a number of steps, m^2. It is the squared distance
    /// along the ground from the payload to the target, plus the square of the distance that the payload would cover in
    /// the time `settle`. So a payload that is near but fast has a large loss.
    fn off_target<R: Real>(&self, seen: &Trajectory<R>, step: usize) -> R {
        let place = seen.position(step);
        let along = self.far.ground.point_to_ground(place).forward();
        let way = seen.velocity(step) * R::lit(self.settings.settle);
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

    /// The mean of `of` over the numbers of steps after which the loss reads a state.
    fn mean<R: Real>(&self, trajectory: &Trajectory<R>, of: impl Fn(usize) -> R) -> R {
        let observed = self.observed(trajectory.last_step());
        let values: Vec<R> = observed.iter().map(|&step| of(step)).collect();
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
                let price = R::lit(self.settings.energy_price);
                self.far.loss(trajectory) + self.energy(trajectory) * price
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Loss, Objective};
    use crate::geometry::Vector;
    use crate::lattice::State;
    use crate::scene::{Named, Scene, TaskKind};
    use crate::simulator::Trajectory;

    fn objective(task: TaskKind) -> Objective {
        let text = "
            base = 'stability'
            [objective]
            target = 1.0
            settle = 0.5
            energy_price = 0.25
            [loss]
            window = 2
            every = 1
            [physics]
            dt = 0.5
            damping = 2.0
        ";
        let mut scene = Scene::parse("tasks", text).unwrap();
        scene.objective.task = task;
        Objective::new(&scene.objective, &scene.loss, &scene.physics)
    }

    /// The states of a moving payload and a node at rest: at the start and after 1, 2 and 3 steps.
    fn walk() -> Trajectory<f64> {
        let state = |(x, v): (f64, f64)| State {
            x: vec![Vector::new([x, 0.25 * x]), Vector::zero()],
            v: vec![Vector::new([v, 0.0]), Vector::zero()],
        };
        let states = [(0.0, 0.0), (2.0, 4.0), (4.0, 2.0), (2.0, 0.0)].map(state);
        Trajectory::new(vec![0, 1, 2, 3], states.to_vec())
    }

    #[test]
    fn each_task_has_its_loss() {
        let loss = |task| objective(task).loss(&walk());
        assert_eq!(loss(TaskKind::Far), -3.0);
        assert_eq!(loss(TaskKind::Back), 3.0);
        assert_eq!(loss(TaskKind::Climb), -0.75);
        // In the first state the payload is 3 m beyond the target and moves 1 m in the time `settle`. In the second it
        // is 1 m beyond the target and at rest.
        assert_eq!(loss(TaskKind::Reach), 0.5 * (9.0 + 1.0 + 1.0));
        // The energy is (16 + 4) / 2 nodes * 2 / s * 0.5 s = 10 J/kg. Each J/kg has the price of 0.25 m.
        assert_eq!(loss(TaskKind::Economy), -3.0 + 2.5);
    }

    #[test]
    fn tasks_read_only_the_nodes_that_they_name() {
        for &(name, task) in TaskKind::ALL {
            let objective = objective(task);
            let mut seen = walk();
            for State { x, v } in &mut seen.states {
                x.truncate(objective.nodes());
                v.truncate(objective.nodes());
            }
            assert_eq!(objective.loss(&seen), objective.loss(&walk()), "{name}");
        }
    }

    #[test]
    fn energy_is_summed_from_start_to_end() {
        let observed = objective(TaskKind::Economy).observed(3);
        assert_eq!(observed, [0, 1, 2, 3]);
        assert_eq!(objective(TaskKind::Reach).observed(3), [2, 3]);
        // With `every` = 2, the state after step 1 counts for one step and the state after step 3 for two steps. With
        // `every` = 16, the state after step 3 counts for all three steps.
        let energy = |every, walk: &Trajectory<f64>| {
            let mut economy = objective(TaskKind::Economy);
            economy.far.settings.every = every;
            economy.energy(walk)
        };
        // With `every` = 2 the energy is 16 / 2 nodes * 2 / s * 0.5 s. With 16 it is zero, because the robot is at rest
        // after three steps.
        assert_eq!([2, 16].map(|every| energy(every, &walk())), [8.0, 0.0]);
        let mut fast = walk();
        fast.states[3].v[0] = Vector::new([2.0, 0.0]);
        // The energy is 4 / 2 nodes * 2 / s * 3 steps of 0.5 s.
        assert_eq!(energy(16, &fast), 6.0);
    }
}
