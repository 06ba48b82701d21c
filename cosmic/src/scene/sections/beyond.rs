//! Settings that go beyond the paper, off in the paper's scenes: other tasks, robust designs, and given goals.

use super::item_name::ItemName;
use crate::geometry::Dimension;
use crate::scene::Scene;
use crate::settings;
use crate::settings::{DEVIATION, within};
use serde::Serialize;

settings! {
    /// The task of the robot. Displacement is reported for every task.
    struct ObjectiveSettings {
        /// The task: to get far, to be near a point, to climb, to go back, or to save energy.
        task: TaskKind = TaskKind::Far,
            read "without an `own_loss`" if Scene::has_task,
            source "paper: far";
        /// The part of the robot whose displacement counts: the payload, the centre of mass, or the mean of the nodes in
        /// use. Each is taken to begin at the place of the payload.
        body: MovedBody = MovedBody::Payload, source "paper: the payload";
        /// Name of a loss that the program adds. It replaces the loss of the task.
        own_loss: ItemName = ItemName::loss(), source "the paper has none";
        /// Weight of the second term of a task. With 1, "reach" counts a speed of 1 m/s as 0.2 m from the goal, and "economy"
        /// 1 J per kilogram of the robot as 0.01 m.
        weight: f64 = 1.0, allowed within(0.0, 1e6),
            read "with the tasks `reach` and `economy`" if |s: &Scene| {
                [TaskKind::Reach, TaskKind::Economy].contains(&s.objective.task) && s.has_task()
            },
            source "beyond the paper";
    }
}

impl ObjectiveSettings {
    /// For the task "reach": the time by which the payload's speed is multiplied, to count as a distance from the goal,
    /// in seconds.
    pub(crate) fn settle(&self) -> f64 {
        0.2 * self.weight
    }

    /// For the task "economy": the price, in metres, of a joule that the actuators give per kilogram of the robot.
    pub(crate) fn energy_price(&self) -> f64 {
        0.01 * self.weight
    }
}

settings! {
    /// The task of the robot.
    enum TaskKind {
        /// To get far along the ground.
        Far = "far",
        /// To get to the goals of a rollout and stay there. With a fixed goal: to be near `controller.goal`, and slow, in
        /// the states that the loss covers; such a robot passes the goal and keeps moving.
        Reach = "reach",
        /// To get the payload high.
        Climb = "climb",
        /// To get far in the opposite direction.
        Back = "back",
        /// To get far with little energy.
        Economy = "economy",
    }
}

settings! {
    /// The part of the robot whose displacement counts.
    #[derive(Default)]
    enum MovedBody {
        /// The payload.
        #[default]
        Payload = "payload",
        /// The centre of mass.
        Mass = "mass",
        /// The mean of the nodes that have a bar. While edges are undecided, each node counts by how solid its edges
        /// are.
        Nodes = "nodes",
    }
}

settings! {
    /// Gradients averaged over random variations of the robot and its surroundings.
    struct RobustSettings {
        /// Number of random variations per gradient, drawn anew in every iteration; 0 for the nominal robot only.
        samples: usize = 0, allowed within(0.0, 1e4), source "paper: 0";
        /// Factor on the largest deviations of the robot: 2 % of a spacing for a coordinate of the start, and 10 % for the
        /// stiffness of an edge and the mass of a node.
        spread: f64 = 1.0, allowed within(0.0, 9.0),
            read "with `samples` above 0" if |s: &Scene| s.robust.samples > 0,
            source "beyond the paper";
        /// Largest relative deviation of the coefficient of friction.
        friction: f64 = 0.2, allowed DEVIATION,
            read "with `samples` above 0 and a contact law that slips" if |s: &Scene| s.robust.samples > 0 && s.slips(),
            source "beyond the paper";
    }
}

/// The largest random deviations of a robot and its surroundings from the nominal ones.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scatter {
    /// The largest deviation of a coordinate of the start, in units of the lattice's [scale](crate::lattice::Lattice::scale),
    /// which is ten spacings.
    pub start: f64,
    /// The largest relative deviation of the coefficient of friction.
    pub friction: f64,
    /// The largest relative deviation of the stiffness of an edge.
    pub stiffness: f64,
    /// The largest relative deviation of the mass of a node.
    pub mass: f64,
}

settings! {
    /// The goals for which a controller is trained and by which robots are ranked, if goals are inputs of a rollout.
    struct GoalsSettings {
        /// The two places along the ground between which goals are drawn, measured from the payload at the start. Each goal is
        /// at least a quarter of this range away from the goal before it; the first one from the payload at the start.
        along: [f64; 2] = [-1.5, 1.5], allowed within(-1e3, 1e3), unit "m",
            auto "`[-1.5 m, 1.5 m]` times `l / 0.5 m`", source "beyond the paper";
        /// In space: the two places across between which goals are drawn, measured from the payload at the start. With
        /// `[0, 0]` every goal is straight ahead or behind.
        across: [f64; 2] = [0.0, 0.0], allowed within(-1e3, 1e3), unit "m",
            read "for a robot in space" if |s: &Scene| s.lattice.dimension() == Dimension::Space,
            source "beyond the paper";
    }
}

impl GoalsSettings {
    /// Number of rollouts per gradient, each to one goal that is drawn anew in every iteration, half of them behind.
    pub const SAMPLES: usize = 8;

    /// Number of goals, one after the other, in each rollout by which robots are ranked.
    pub const COUNT: usize = 3;

    /// Least distance along the ground from one goal to the next, and from the payload at the start to the first goal, m.
    pub fn apart(&self) -> f64 {
        let [low, high] = self.along;
        0.25 * (high - low)
    }

    /// The numbers of steps at which goals change in a rollout of `steps` steps. A rollout has at most as many goals as
    /// steps.
    pub fn changes(steps: usize) -> impl Iterator<Item = usize> {
        let count = Self::COUNT.min(steps.max(1));
        (1..count).map(move |k| k * steps / count)
    }
}

impl RobustSettings {
    /// The largest deviations.
    pub fn scatter(&self) -> Scatter {
        Scatter {
            start: 0.002 * self.spread,
            friction: self.friction,
            stiffness: 0.1 * self.spread,
            mass: 0.1 * self.spread,
        }
    }

    /// The largest ratio of the highest frequency of a random variation of the robot to that of the nominal robot. A
    /// variation may vibrate faster, because its edges may be stiffer and its nodes lighter. The ratio is 1 if there
    /// are no variations.
    pub fn faster(&self) -> f64 {
        let Scatter {
            stiffness, mass, ..
        } = self.scatter();
        match self.samples {
            0 => 1.0,
            _ => ((1.0 + stiffness) / (1.0 - mass)).sqrt(),
        }
    }
}
