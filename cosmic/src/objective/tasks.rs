//! Other tasks than getting far: each a few lines over the states of a rollout.
//!
//! They are examples of losses that a user would write. A loss sees nothing but states, so effort
//! is derived from them: the energy that a robot spends is the energy that its damping takes.

use autodiff::Real;

use super::{Displacement, Loss};
use crate::lattice::State;
use crate::scene::{LossSettings, ObjectiveSettings, PhysicsSettings, TaskKind};
use crate::simulator::Trajectory;

/// What a robot is designed for.
#[derive(Clone, Debug, PartialEq)]
pub enum Objective {
    /// To get far along the ground (the paper's).
    Far(Displacement),
    /// To go to a point and stop.
    Reach(Reach),
    /// To lift the payload, on an incline by walking up.
    Climb(Climb),
    /// To get far the other way, whatever goal the controller is given.
    Back(Displacement),
    /// To get far on little energy.
    Economy(Economy),
}

impl Objective {
    /// The objective of a scene's sections.
    pub fn new(
        settings: &ObjectiveSettings,
        loss: &LossSettings,
        physics: &PhysicsSettings,
    ) -> Self {
        let far = Displacement {
            ground: physics.into(),
            settings: loss.clone(),
        };
        match settings.task {
            TaskKind::Far => Self::Far(far),
            TaskKind::Reach => Self::Reach(Reach {
                far,
                target: settings.target,
                settle: settings.settle,
            }),
            TaskKind::Climb => Self::Climb(Climb { far }),
            TaskKind::Back => Self::Back(far),
            TaskKind::Economy => Self::Economy(Economy {
                far,
                rate: physics.damping,
                dt: physics.dt,
                price: settings.energy_price,
            }),
        }
    }
}

impl Loss for Objective {
    fn observed(&self, steps: usize) -> Vec<usize> {
        match self {
            Self::Far(loss) | Self::Back(loss) => loss.observed(steps),
            Self::Reach(loss) => loss.observed(steps),
            Self::Climb(loss) => loss.observed(steps),
            Self::Economy(loss) => loss.observed(steps),
        }
    }

    fn nodes(&self) -> usize {
        match self {
            Self::Far(loss) | Self::Back(loss) => loss.nodes(),
            Self::Reach(loss) => loss.nodes(),
            Self::Climb(loss) => loss.nodes(),
            Self::Economy(loss) => loss.nodes(),
        }
    }

    fn is_far(&self) -> bool {
        matches!(self, Self::Far(_))
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        match self {
            Self::Far(loss) => loss.loss(trajectory),
            Self::Reach(loss) => loss.loss(trajectory),
            Self::Climb(loss) => loss.loss(trajectory),
            Self::Back(loss) => -loss.loss(trajectory),
            Self::Economy(loss) => loss.loss(trajectory),
        }
    }
}

/// The squared distance along the ground from the payload to a target, plus the square of the way
/// that it would still cover in the time `settle`, m^2: near and slow is good, near and fast is not.
#[derive(Clone, Debug, PartialEq)]
pub struct Reach {
    /// The ground, and which states are looked at.
    pub far: Displacement,
    /// Where to, m along the ground from its origin.
    pub target: f64,
    /// Seconds by which a speed counts as a distance.
    pub settle: f64,
}

impl Loss for Reach {
    fn observed(&self, steps: usize) -> Vec<usize> {
        self.far.observed(steps)
    }

    fn nodes(&self) -> usize {
        1
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        mean(self, trajectory, |state| {
            let [along, _] = self.far.ground.point_to_ground(state.x[0]);
            let [vx, vy] = state.v[0].map(|v| v * R::lit(self.settle));
            let off = along - R::lit(self.target);
            off * off + vx * vx + vy * vy
        })
    }
}

/// Minus the payload's height in the world, m.
#[derive(Clone, Debug, PartialEq)]
pub struct Climb {
    /// Which states are looked at.
    pub far: Displacement,
}

impl Loss for Climb {
    fn observed(&self, steps: usize) -> Vec<usize> {
        self.far.observed(steps)
    }

    fn nodes(&self) -> usize {
        1
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        mean(self, trajectory, |state| -state.x[0][1])
    }
}

/// Minus the payload's position, and a price for the energy that the motion takes.
///
/// Nothing but the actuators puts energy into a robot on level ground for long, and next to the
/// contacts it is the damping that takes it out: `rate |v|^2` per mass and time. The mean over
/// the nodes stands for the mean over the mass, which states do not hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Economy {
    /// The ground, and how densely states are looked at.
    pub far: Displacement,
    /// Damping rate, 1/s.
    pub rate: f64,
    /// Length of a step, s.
    pub dt: f64,
    /// Metres that a joule per kilogram is worth.
    pub price: f64,
}

impl Economy {
    /// The energy that damping takes over the states observed, J/kg, averaged over the nodes:
    /// states hold no masses to weigh them by.
    pub fn energy<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        let square = |v: &[R; 2]| R::dot(v, v);
        let at = |step: usize| {
            let squares: Vec<R> = trajectory.at(step).v.iter().map(square).collect();
            R::sum(&squares) * R::lit(1.0 / squares.len() as f64)
        };
        let observed = self.observed(trajectory.last_step());
        // Each state stands for the steps since the one before, the first for those since the
        // start.
        let since = |k: usize| observed[k] - k.checked_sub(1).map_or(0, |before| observed[before]);
        let weighed = |k: usize| at(observed[k]) * R::lit(since(k) as f64);
        let weighed: Vec<R> = (0..observed.len()).map(weighed).collect();
        R::sum(&weighed) * R::lit(self.rate * self.dt)
    }
}

impl Loss for Economy {
    /// The whole rollout, every `every` steps.
    fn observed(&self, steps: usize) -> Vec<usize> {
        let every = self.far.settings.every;
        (steps % every..=steps).step_by(every).collect()
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        self.far.loss(trajectory) + self.energy(trajectory) * R::lit(self.price)
    }
}

/// The mean of a function over the states that a loss observes.
fn mean<R: Real>(loss: &impl Loss, trajectory: &Trajectory<R>, of: impl Fn(&State<R>) -> R) -> R {
    let observed = loss.observed(trajectory.last_step());
    let values: Vec<R> = observed.iter().map(|&s| of(trajectory.at(s))).collect();
    R::sum(&values) * R::lit(1.0 / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::{Loss, Objective};
    use crate::lattice::State;
    use crate::scene::{LossSettings, ObjectiveSettings, PhysicsSettings, TaskKind};
    use crate::simulator::Trajectory;

    fn objective(task: TaskKind) -> Objective {
        let settings = ObjectiveSettings {
            task,
            target: 1.0,
            settle: 0.5,
            energy_price: 0.25,
        };
        let loss = LossSettings {
            window: 2,
            every: 1,
            ..LossSettings::default()
        };
        let physics = PhysicsSettings {
            dt: 0.5,
            damping: 2.0,
            ..PhysicsSettings::default()
        };
        Objective::new(&settings, &loss, &physics)
    }

    /// A payload, and a node that rests, after 1, 2 and 3 steps.
    fn walk() -> Trajectory<f64> {
        let state = |(x, v): (f64, f64)| State {
            x: vec![[x, 0.25 * x], [0.0, 0.0]],
            v: vec![[v, 0.0], [0.0, 0.0]],
        };
        Trajectory {
            steps: vec![0, 1, 2, 3],
            states: [(0.0, 0.0), (2.0, 4.0), (4.0, 2.0), (2.0, 0.0)]
                .map(state)
                .to_vec(),
        }
    }

    #[test]
    fn each_task_sees_its_own() {
        let loss = |task| objective(task).loss(&walk());
        assert_eq!(loss(TaskKind::Far), -3.0);
        assert_eq!(loss(TaskKind::Back), 3.0);
        assert_eq!(loss(TaskKind::Climb), -0.75);
        // 3 m too far and a metre per settling time, then 1 m too far and at rest.
        assert_eq!(loss(TaskKind::Reach), 0.5 * (9.0 + 1.0 + 1.0));
        // (16 + 4) / 2 nodes * 2 / s * 0.5 s = 10 J/kg at a quarter of a metre each.
        assert_eq!(loss(TaskKind::Economy), -3.0 + 2.5);
    }

    #[test]
    fn no_task_looks_at_more_nodes_than_it_says() {
        use TaskKind::{Back, Climb, Economy, Far, Reach};
        for task in [Far, Back, Climb, Reach, Economy] {
            let objective = objective(task);
            let mut seen = walk();
            for State { x, v } in &mut seen.states {
                x.truncate(objective.nodes());
                v.truncate(objective.nodes());
            }
            assert_eq!(seen == walk(), task == Economy, "{task:?}");
            assert_eq!(objective.loss(&seen), objective.loss(&walk()), "{task:?}");
        }
    }

    #[test]
    fn energy_is_summed_up_from_start_to_end() {
        let observed = objective(TaskKind::Economy).observed(3);
        assert_eq!(observed, [0, 1, 2, 3]);
        assert_eq!(objective(TaskKind::Reach).observed(3), [2, 3]);
        // States at steps 1 and 3, of one and two steps; at step 3 of all three.
        let energy = |every, walk: &Trajectory<f64>| {
            let Objective::Economy(mut economy) = objective(TaskKind::Economy) else {
                unreachable!("that task was asked for")
            };
            economy.far.settings.every = every;
            economy.energy(walk)
        };
        // 16 / 2 nodes * 2 / s * 0.5 s, and at rest after three steps.
        assert_eq!([2, 16].map(|every| energy(every, &walk())), [8.0, 0.0]);
        let mut fast = walk();
        fast.states[3].v[0] = [2.0, 0.0];
        // 4 / 2 nodes * 2 / s * 3 steps of 0.5 s.
        assert_eq!(energy(16, &fast), 6.0);
    }
}
