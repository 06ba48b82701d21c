//! Settings that go beyond the paper, all off by default: other tasks, robust designs, and a search over starts that
//! drops weak starts early.

use super::Scene;
use super::chosen::Chosen;
use super::robot::GoalKind;
use crate::settings;
use crate::settings::{DEVIATION, SHARE, above, within};

settings! {
    /// The task of the robot. Displacement is reported for every task.
    struct ObjectiveSettings {
        /// The task: to get far, to be near a point, to climb, to go back, or to save energy.
        task: TaskKind = TaskKind::Far,
            read "without an `own_loss`" if Scene::has_task,
            source "paper: far";
        /// The part of the robot whose displacement counts: the payload, the centre of mass, or the mean of the nodes
        /// in use. Every task, every reported distance and every choice by distance follows it; only an `own_loss`
        /// reads what it likes. The centre of mass and the mean node count from the payload's place at the start.
        body: MovedBody = MovedBody::Payload, source "paper: the payload";
        /// Name of a loss that the program adds. It replaces the loss of the task.
        own_loss: Chosen = Chosen::loss(), source "the paper has none";
        /// For "reach" with a fixed goal: the desired position of the payload along the ground, from its origin, in the
        /// states that the loss covers.
        target: f64 = 1.0, allowed within(-1e3, 1e3), unit "m",
            read "with the task `reach` and a fixed goal" if |s: &Scene| {
                s.objective.task == TaskKind::Reach && s.has_task() && s.controller.goals != GoalKind::Given
            },
            source "beyond the paper";
        /// For "reach": the time by which the payload's speed is multiplied, to count as a distance from the target or
        /// the goal.
        settle: f64 = 0.2, allowed within(0.0, 1e3), unit "s",
            read "with the task `reach`" if |s: &Scene| s.objective.task == TaskKind::Reach && s.has_task(),
            source "beyond the paper";
        /// For "economy": the price, in metres, of a joule that the actuators give per kilogram of the robot.
        energy_price: f64 = 0.01, allowed within(0.0, 1e6), unit "m kg/J",
            read "with the task `economy`" if |s: &Scene| s.objective.task == TaskKind::Economy && s.has_task(),
            source "beyond the paper";
    }
}

settings! {
    /// The task of the robot.
    enum TaskKind {
        /// To get far along the ground.
        Far = "far",
        /// To get to the goals of a rollout and stay there. With a fixed goal: to be near `target`, and slow, in the states
        /// that the loss covers; such a robot passes the target and keeps moving.
        Reach = "reach",
        /// To get the payload high.
        Climb = "climb",
        /// To get far the other way.
        Back = "back",
        /// To get far on little energy.
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
        /// Largest deviation of a coordinate of the start. It counts as `lattice.units` says: for `relative` in ten
        /// spacings, for `absolute` in metres.
        start: f64 = 0.002, allowed within(0.0, 1.0),
            read "with `samples` above 0" if |s: &Scene| s.robust.samples > 0,
            source "beyond the paper";
        /// Largest relative deviation of the coefficient of friction.
        friction: f64 = 0.2, allowed DEVIATION,
            read "with `samples` above 0 and a contact law that slips" if |s: &Scene| s.robust.samples > 0 && s.slips(),
            source "beyond the paper";
        /// Largest relative deviation of the stiffness of an edge.
        stiffness: f64 = 0.1, allowed DEVIATION,
            read "with `samples` above 0" if |s: &Scene| s.robust.samples > 0,
            source "beyond the paper";
        /// Largest relative deviation of the mass of a node.
        mass: f64 = 0.1, allowed DEVIATION,
            read "with `samples` above 0" if |s: &Scene| s.robust.samples > 0,
            source "beyond the paper";
    }
}

settings! {
    /// The goals for which a controller is trained and by which robots are ranked, if goals are inputs of a rollout.
    struct GoalsSettings {
        /// Number of rollouts per gradient, each to one goal that is drawn anew in every iteration. Half of the goals are
        /// ahead of the payload and half behind it, as far as a goal of a sequence is from the goal before it.
        samples: usize = 8, allowed within(1.0, 1e4), source "beyond the paper";
        /// Number of goals, one after the other, of a rollout in which robots are ranked. Each holds for the same time.
        count: usize = 3, allowed within(1.0, 64.0), source "beyond the paper";
        /// The two places along the ground between which goals are drawn, counted from the payload at the start.
        along: [f64; 2] = [-1.5, 1.5], allowed within(-1e3, 1e3), unit "m",
            auto "`[-1.5 m, 1.5 m]` times `l / 0.5 m`", source "beyond the paper";
        /// Least distance from one goal to the next, and from the payload at the start to the first goal.
        apart: f64 = 0.75, allowed above(0.0, 1e3), unit "m", auto "0.75 m times `l / 0.5 m`",
            source "beyond the paper";
    }
}

impl GoalsSettings {
    /// The numbers of steps at which goals change in a rollout of `steps` steps.
    pub fn changes(&self, steps: usize) -> impl Iterator<Item = usize> {
        let count = self.count;
        (1..count).map(move |k| k * steps / count)
    }
}

impl RobustSettings {
    /// The largest ratio of the highest frequency of a random variation of the robot to that of the nominal robot. A
    /// variation may vibrate faster, because its edges may be stiffer and its nodes lighter. The ratio is 1 if there
    /// are no variations.
    pub fn faster(&self) -> f64 {
        match self.samples {
            0 => 1.0,
            _ => ((1.0 + self.stiffness) / (1.0 - self.mass)).sqrt(),
        }
    }
}

settings! {
    /// How `optimize --starts N --search halving` drops weak starts. Other commands do not read it.
    struct SearchSettings {
        /// Iterations after which starts are dropped, ascending. No start is dropped at the last iteration of the run
        /// or later.
        rungs: [usize; 3] = [60, 200, 260], allowed within(1.0, 1e5),
            auto "60, 200 and 260 for 300 iterations, and in proportion", source "beyond the paper";
        /// Share of the starts that continue after each rung. The number of starts is rounded up.
        keep: [f64; 3] = [0.34, 0.5, 0.5], allowed SHARE, source "beyond the paper";
        /// Number of iterations before a rung that count. A start is judged by its median over these iterations.
        window: usize = 10, allowed within(1.0, 1e5), source "beyond the paper";
    }
}
