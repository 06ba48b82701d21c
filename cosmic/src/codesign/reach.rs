//! Full rollouts of robots: their displacement, and their merit, which is the number by which robots are ranked.

use std::borrow::Borrow;

use autodiff::Real;
use rayon::prelude::*;

use super::evaluator::Evaluator;
use super::progress::Progress;
use super::reliability::Merit;
use crate::design::{Design, Material, Mixture};
use crate::domain::Domain;
use crate::geometry::Vector;
use crate::lattice::State;
use crate::objective::{AnyLoss, LossOf};
use crate::policy::Controller;
use crate::scene::{GradientPrecision, Scene};
use crate::simulator::{Span, Trajectory};
use crate::task::{Task, together};

/// The result of a full rollout. All its numbers are NaN if the rollout diverged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    /// Displacement of the payload in metres: first the component along the ground, then the component normal to it.
    pub moved: Vector<f64>,
    /// The number that robots are ranked by: the displacement along the ground in metres; for tasks other than
    /// distance, minus the loss. With two goals, it is the merit for the worse goal.
    pub merit: f64,
    /// Only with two goals: the displacement along the ground in metres when the goal is behind the robot. A negative
    /// displacement is towards that goal.
    pub behind: Option<f64>,
}

impl Reached {
    /// Displacement along the ground, in metres.
    pub fn along(&self) -> f64 {
        self.moved.forward()
    }

    /// Joins the results for the two goals: this one for the goal ahead, and `behind` for the goal behind the robot.
    /// The merit is the lower one of the two. The merit of `behind` counts with the opposite sign, because for the goal
    /// behind the payload must move backwards, or the loss must be large.
    pub fn with_behind(self, behind: Self) -> Self {
        Self {
            merit: worse(self.merit, -behind.merit),
            behind: Some(behind.along()),
            ..self
        }
    }
}

/// The lower of two merits (numbers by which robots are ranked). NaN if one of them is NaN.
fn worse(a: f64, b: f64) -> f64 {
    if a < b || a.is_nan() { a } else { b }
}

/// True if robots are ranked by their displacement alone. The loss must be the loss for distance, and there must be a
/// single goal.
pub(crate) fn is_ranked_by_distance(scene: &Scene, loss: &dyn AnyLoss) -> bool {
    loss.is_far() && !scene.controller.two_goals
}

impl Evaluator {
    /// Simulates the current robot in a full rollout, in the precision of gradients, and returns the result.
    pub fn evaluate(&self, progress: &Progress) -> Reached {
        self.try_many(&[self.design(progress)], &progress.controller, &self.task)[0]
    }

    /// Simulates the current robot from the unperturbed start, in the precision of gradients, and returns its states
    /// after the numbers of steps in `steps`; `None` if the robot diverges.
    pub fn watch(&self, progress: &Progress, steps: Vec<usize>) -> Option<Trajectory<f64>> {
        let precision = self.scene.gradient.precision;
        let robot = ([self.design(progress)], &progress.controller);
        watched(
            &robot.0,
            robot.1,
            &self.task,
            &[&self.start],
            steps,
            precision,
        )
        .remove(0)
    }

    /// Simulates robots in full rollouts from the unperturbed start, in the precision of gradients, and returns their
    /// results. For perturbed starts, call [`reach_many`](Self::reach_many) with f64, because rounding to f32 would
    /// remove a perturbation of a nanometre.
    pub(super) fn try_many(
        &self,
        designs: &[Design<Mixture<f64>>],
        controller: &Controller<f64>,
        task: &Task,
    ) -> Vec<Reached> {
        let starts = vec![&self.start; designs.len()];
        let precision = self.scene.gradient.precision;
        self.reach_many(designs, controller, task, &starts, precision)
    }

    /// Compares a layout and its alternatives (`others`) by one full rollout each. Returns the best layout and the
    /// result of its rollout. Of equally good layouts, it returns the first. A layout without alternatives needs no
    /// rollout.
    pub(super) fn farthest(
        &self,
        layout: Vec<Material>,
        others: impl IntoIterator<Item = Vec<Material>>,
        controller: &Controller<f64>,
    ) -> (Vec<Material>, Option<Reached>) {
        let mut layouts: Vec<_> = std::iter::once(layout).chain(others).collect();
        if layouts.len() == 1 {
            return (layouts.remove(0), None);
        }
        let reached = self.reached(&layouts, controller, &self.task);
        let best = first_best(reached.iter().map(|r| [r.merit]));
        (layouts.swap_remove(best), Some(reached[best]))
    }

    /// The results of several layouts with one controller, in the order of the layouts. The rollouts run in parallel.
    pub(super) fn reached(
        &self,
        layouts: &[Vec<Material>],
        controller: &Controller<f64>,
        task: &Task,
    ) -> Vec<Reached> {
        let designs: Vec<_> = layouts.iter().cloned().map(Design::Layout).collect();
        let side_by_side = |designs: &[_]| self.try_many(designs, controller, task);
        let groups = designs.par_chunks(together(layouts.len()));
        groups.flat_map_iter(side_by_side).collect()
    }

    /// Simulates a robot in a full rollout in one domain, and returns the result.
    pub fn reach(
        &self,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
        domain: &Domain,
    ) -> Reached {
        let (task, starts) = (&domain.task, [&domain.start]);
        self.reach_many(&[design], controller, task, &starts, GradientPrecision::F64)[0]
    }

    /// The kind of merit by which robots of this scene are ranked.
    pub(super) fn merit(&self) -> Merit {
        match (self.loss.is_far(), self.scene.controller.two_goals) {
            (false, _) => Merit::MinusLoss,
            (true, true) => Merit::ShorterWay,
            (true, false) => Merit::Distance,
        }
    }

    /// Simulates robots in full rollouts from several starts, and returns their results. `designs` has one design for
    /// all starts, or one for each start. With two goals, every robot is also simulated towards the goal behind it.
    pub(super) fn reach_many(
        &self,
        designs: &[impl Borrow<Design<Mixture<f64>>>],
        controller: &Controller<f64>,
        task: &Task,
        starts: &[&State<f64>],
        precision: GradientPrecision,
    ) -> Vec<Reached> {
        let steps = task.physics.steps;
        let observed = match self.loss.is_far() {
            true => vec![steps],
            false => self.loss.observed(steps),
        };
        let towards_goal = |task: &Task| -> Vec<Reached> {
            let seen = watched(
                designs,
                controller,
                task,
                starts,
                observed.clone(),
                precision,
            );
            let pairs = starts.iter().zip(seen);
            (pairs.map(|(start, seen)| self.reached_in(start, seen.as_ref()))).collect()
        };
        self.towards_goals(task, towards_goal, Reached::with_behind)
    }

    /// Calls `roll` for the task with the goal ahead. In a scene with two goals, also calls it for the goal behind, and
    /// joins the two results of each robot.
    pub(super) fn towards_goals<T>(
        &self,
        task: &Task,
        roll: impl Fn(&Task) -> Vec<T>,
        join: impl Fn(T, T) -> T,
    ) -> Vec<T> {
        // All rollouts for the goal ahead come first, because the bits of a gradient depend on the order.
        let ahead = roll(task);
        if !self.scene.controller.two_goals {
            return ahead;
        }
        let pairs = ahead.into_iter().zip(roll(&task.turned_back()));
        pairs.map(|(ahead, behind)| join(ahead, behind)).collect()
    }

    /// The result of a rollout towards one goal. If the rollout diverged (`seen` is `None`), all its numbers are NaN.
    fn reached_in(&self, start: &State<f64>, seen: Option<&Trajectory<f64>>) -> Reached {
        let Some(seen) = seen else {
            return self.reached_by(Vector::NAN, || f64::NAN);
        };
        let moved = self.between(start, seen.at(seen.last_step()));
        self.reached_by(moved, || LossOf::<f64>::loss_of(&*self.loss, seen))
    }

    /// The result of a robot for one goal, from the displacement `moved` of its payload. `loss` computes the loss; it
    /// is called only if the merit is minus the loss.
    pub(super) fn reached_by(&self, moved: Vector<f64>, loss: impl Fn() -> f64) -> Reached {
        Reached {
            moved,
            merit: if self.loss.is_far() {
                moved.forward()
            } else {
                -loss()
            },
            behind: None,
        }
    }

    /// Displacement of the payload from `start` to `last` in metres: first the component along the ground, then the
    /// component normal to it. Both are NaN if `last` is an [absurd](State::is_absurd) state.
    pub(super) fn between(&self, start: &State<f64>, last: &State<f64>) -> Vector<f64> {
        if last.is_absurd() {
            return Vector::NAN;
        }
        let ground = self.task.ground();
        ground.point_to_ground(last.x[0]) - ground.point_to_ground(start.x[0])
    }
}

/// Simulates robots from several starts in `precision`, and returns the states of each robot after the numbers of steps
/// in `steps`; `None` for a robot that diverges. `designs` has one design for all starts, or one for each start.
fn watched(
    designs: &[impl Borrow<Design<Mixture<f64>>>],
    controller: &Controller<f64>,
    task: &Task,
    starts: &[&State<f64>],
    steps: Vec<usize>,
    precision: GradientPrecision,
) -> Vec<Option<Trajectory<f64>>> {
    let span = Span::from_start(steps);
    let watched = Span {
        watched: true,
        ..span.clone()
    };
    let roll = match precision {
        GradientPrecision::F64 => roll_in::<f64>,
        GradientPrecision::F32 => roll_in::<f32>,
    };
    let borrowed: Vec<_> = designs.iter().map(Borrow::borrow).collect();
    let all = roll(&borrowed, controller, task, starts, &watched);
    let seen = |(k, seen): (usize, Trajectory<f64>)| {
        let is_cleared = |last| task.simulator.is_cleared(last);
        if seen.states.last().is_none_or(is_cleared) {
            return Some(seen);
        }
        // The cheap check during the rollout failed. It is stricter than the guard, so the guard decides in a second
        // rollout.
        let design = borrowed[k % borrowed.len()];
        let guarded = task.guarded(design, controller, starts[k], &span);
        guarded.divergence.is_none().then_some(guarded.trajectory)
    };
    all.into_iter().enumerate().map(seen).collect()
}

/// Simulates robots in the number type `R`, and returns the trajectories rounded to f64.
fn roll_in<R: Real + Into<f64>>(
    designs: &[&Design<Mixture<f64>>],
    controller: &Controller<f64>,
    task: &Task,
    starts: &[&State<f64>],
    span: &Span,
) -> Vec<Trajectory<f64>> {
    let designs: Vec<_> = designs.iter().map(|design| design.lift::<R>()).collect();
    let starts: Vec<_> = starts.iter().map(|start| start.map(R::lit)).collect();
    let all = task.rollout_many(&designs, &controller.map(R::lit), &starts, span);
    let rounded = |Trajectory { steps, states }: Trajectory<R>| Trajectory {
        states: states.iter().map(|state| state.map(R::into)).collect(),
        steps,
    };
    all.into_iter().map(rounded).collect()
}

/// The index of the largest merit; of equally large merits, the index of the first. A merit has `N` numbers, which are
/// compared from the first to the last: a later number only decides between merits with equal earlier numbers. NaN, the
/// merit of a diverged rollout, is below any number.
pub fn first_best<const N: usize>(merits: impl IntoIterator<Item = [f64; N]>) -> usize {
    let better = |best: (usize, [f64; N]), (k, merit)| {
        if merit > best.1 { (k, merit) } else { best }
    };
    let merits = merits.into_iter().enumerate();
    merits.fold((0, [f64::NEG_INFINITY; N]), better).0
}
