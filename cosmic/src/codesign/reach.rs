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
    /// Displacement of the payload, or of the body that the scene names, in metres: first the component along the
    /// ground, then the component normal to it.
    pub moved: Vector<f64>,
    /// The number that robots are ranked by: the displacement along the ground in metres; for tasks other than
    /// distance, minus the loss. With two goals, it is the merit for the worse goal.
    pub merit: f64,
    /// Only with two goals: the displacement along the ground in metres when the goal is behind the robot. A negative
    /// displacement is towards that goal.
    pub behind: Option<f64>,
}

impl Reached {
    pub(super) fn along(&self) -> f64 {
        self.moved.forward()
    }

    /// Joins the results for the two goals: this one for the goal ahead, and `behind` for the goal behind the robot.
    /// The merit is the lower one of the two. The merit of `behind` counts with the opposite sign, because for the goal
    /// behind the payload must move backwards, or the loss must be large.
    pub(super) fn with_behind(self, behind: Self) -> Self {
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
    pub(super) fn evaluate(&self, progress: &Progress) -> Reached {
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
        let scale = self.task.lattice.scale;
        match (self.loss.is_far(), self.scene.controller.two_goals) {
            (false, _) => Merit::MinusLoss,
            (true, true) => Merit::ShorterWay { scale },
            (true, false) => Merit::Distance { scale },
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
        let moved = self.between(start, seen);
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

    /// Displacement of the payload, or of the body that the scene names, from `start` to the end of a trajectory in
    /// metres: first the component along the ground, then the component normal to it. Both are NaN if the last state is
    /// [absurd](State::is_absurd).
    pub(super) fn between<R: Real>(&self, start: &State<f64>, seen: &Trajectory<R>) -> Vector<f64> {
        let last = seen.last_step();
        if seen.at(last).map(R::primal).is_absurd() {
            return Vector::NAN;
        }
        let ground = self.task.ground();
        let [from, to] = [
            start.x[seen.marker.payload],
            seen.position(last).map(R::primal),
        ];
        ground.point_to_ground(to) - ground.point_to_ground(from)
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
    all.iter().map(|seen| seen.map(R::into)).collect()
}

/// The index of the largest merit; of equally large merits, the index of the first. A merit has `N` numbers, which are
/// compared from the first to the last: a later number only decides between merits with equal earlier numbers. NaN, the
/// merit of a diverged rollout, is below any number.
pub(crate) fn first_best<const N: usize>(merits: impl IntoIterator<Item = [f64; N]>) -> usize {
    let better = |best: (usize, [f64; N]), (k, merit)| {
        if merit > best.1 { (k, merit) } else { best }
    };
    let merits = merits.into_iter().enumerate();
    merits.fold((0, [f64::NEG_INFINITY; N]), better).0
}

#[cfg(test)]
mod tests {
    use super::{Reached, first_best, worse};
    use crate::codesign::CoDesign;
    use crate::codesign::schedule::Schedule;
    use crate::codesign::tests::{LIVELY, Up, begun, tiny};
    use crate::lattice::State;
    use crate::laws::ContactLaw;
    use crate::scene::{GradientPrecision, Scene, TaskKind};

    /// A robot that moves very far, but not so far that a state is absurd, has not diverged. It falls along a steep
    /// slope for 40 s, so far that the cheap check during the rollout fails and the guard decides.
    #[test]
    fn a_nearly_absurd_state_has_not_diverged() {
        let mut scene = tiny();
        scene.physics.contact = ContactLaw::coulomb();
        scene.physics.friction = 0.0;
        scene.physics.incline_deg = 60.0;
        scene.physics.gravity = 1000.0;
        (scene.physics.damping, scene.physics.steps) = (0.0, 20_000);
        scene.physics.speed_bound = None;
        scene.lattice.spacing = 0.001;
        scene.materials.stiffness = [1e-7, 1.0, 1.0];
        let (evaluator, progress) = begun(&scene);
        let reached = evaluator.evaluate(&progress);
        assert!((5e5..1e6).contains(&reached.along().abs()), "{reached:?}");
        let delivery = evaluator.deliver(&progress);
        assert_eq!(delivery.divergence, None);
        assert_eq!(delivery.along, reached.along());
        assert!(delivery.spread.p10.is_finite(), "{delivery:?}");
    }

    /// A speed bound just below the largest speed of a node makes the rollout diverge; a bound just above it changes
    /// nothing.
    #[test]
    fn a_robot_with_a_node_beyond_the_bound_has_diverged() {
        let mut scene = Scene::parse("fast", &[LIVELY, "iterations = 8"].concat()).unwrap();
        scene.physics.speed_bound = None;
        let free = CoDesign::new(&scene).unwrap();
        let progress = free.begin(1).unwrap();
        let all = free
            .evaluator
            .watch(&progress, (0..=scene.physics.steps).collect());
        let states = all.unwrap().states;
        let speed = |state: &State<f64>| state.speeds().fold(0.0, f64::max);
        let fastest = states.iter().map(speed).fold(0.0, f64::max);
        // The node is fastest between the observed states, not at the end.
        assert!(speed(&states[scene.physics.steps]) < 0.9 * fastest);
        let first = |bound: f64| states.iter().position(|state| speed(state) > bound);
        let mut moves = |bound| {
            scene.physics.speed_bound = bound;
            let codesign = CoDesign::new(&scene).unwrap();
            let at = codesign
                .evaluator
                .point(&progress, &Schedule::at(&scene, 1));
            let walk = codesign
                .evaluator
                .watch(&progress, vec![0, scene.physics.steps]);
            assert_eq!(
                walk.is_none(),
                codesign.evaluator.evaluate(&progress).along().is_nan()
            );
            let slopes = codesign.evaluator.design_slopes(&at);
            (
                codesign.evaluator.evaluate(&progress),
                slopes,
                codesign.evaluator.deliver(&progress),
            )
        };
        let (reached, slopes, delivery) = moves(None);
        for bound in [1.001 * fastest, 1e4] {
            assert_eq!(
                moves(Some(bound)),
                (reached, slopes.clone(), delivery.clone())
            );
        }
        for bound in [0.999, 0.8] {
            let bound = bound * fastest;
            let (beyond, same, flown) = moves(Some(bound));
            assert!(beyond.along().is_nan() && beyond.merit.is_nan());
            assert_eq!(same, slopes);
            let found = flown.divergence.unwrap();
            assert_eq!(Some(found.step + 1), first(bound));
            let says = crate::Error::from(&found).to_string();
            let node = format!("node {} at", found.node);
            let allowed = format!("`physics.speed_bound` allows {bound} m/s");
            for words in [node, allowed] {
                assert!(says.contains(&words), "{says}");
            }
            assert!(flown.along.is_nan() && flown.loads.is_none());
        }
    }

    /// Rollouts of the optimisation are computed in the precision of the scene; the figures to quote are computed in
    /// f64.
    #[test]
    fn rollouts_of_the_optimisation_have_the_precision_of_gradients() {
        let check = |mut scene: Scene| {
            scene.start.tilt = 0.2;
            let double = CoDesign::new(&scene).unwrap();
            scene.gradient.precision = GradientPrecision::F32;
            let single = CoDesign::new(&scene).unwrap();
            let progress = double.begin(1).unwrap();
            let [a, b] = [&double, &single].map(|codesign| codesign.evaluator.evaluate(&progress));
            // The expected rounding error is 0.3 * 24 * 100^(1/2) * 6e-8: lengths of 0.3 m, 24 steps, and in each
            // about 100 operations that round at 6e-8 with random signs.
            for (a, b) in [(a.along(), b.along()), (a.merit, b.merit)] {
                assert!(a != b && (a - b).abs() < 5e-6, "{a} {b}");
            }
            assert_eq!(
                double.evaluator.deliver(&progress),
                single.evaluator.deliver(&progress)
            );
        };
        check(tiny());
        let mut scene = tiny();
        scene.objective.task = TaskKind::Climb;
        check(scene);
    }

    #[test]
    fn the_first_of_equals_is_the_best_and_diverged_rollouts_are_last() {
        let least = f64::NEG_INFINITY;
        assert_eq!(first_best([1.0, 3.0, f64::NAN, 3.0, 2.0].map(|m| [m])), 1);
        assert_eq!(first_best([[f64::NAN], [least], [-5.0]]), 2);
        assert_eq!(first_best([[f64::NAN], [least]]), 0);
        assert_eq!(first_best([[least, 1.0], [least, 2.0], [least, 2.0]]), 1);
    }

    /// With two goals, the merit is the merit for the worse goal. A robot that does not observe its goal moves the same
    /// way for both goals: what it gains for one, it loses for the other.
    #[test]
    fn with_two_goals_the_worse_one_gives_the_merit() {
        let mut scene = Scene::parse("lively", LIVELY).unwrap();
        (scene.controller.two_goals, scene.controller.goal_scale) = (true, 0.0);
        let check = |codesign: CoDesign, ahead: fn(&Reached) -> f64| {
            let progress = codesign.begin(1).unwrap();
            let reached = codesign.evaluator.evaluate(&progress);
            assert_eq!(reached.behind, Some(reached.along()));
            assert!(ahead(&reached) != 0.0);
            assert_eq!(reached.merit, -ahead(&reached).abs());
            let delivery = codesign.evaluator.deliver(&progress);
            assert_eq!(delivery.behind, Some(delivery.spread));
            assert!(delivery.selection.p50 < 0.0);
        };
        check(CoDesign::new(&scene).unwrap(), Reached::along);
        // A caller's loss has to be small for one goal and large for the other.
        check(CoDesign::with_loss(&scene, Up).unwrap(), |reached| {
            reached.merit
        });
        // If the robot observes the goal, the results differ.
        scene.controller.goal_scale = 3.0;
        let codesign = CoDesign::new(&scene).unwrap();
        let reached = codesign.evaluator.evaluate(&codesign.begin(1).unwrap());
        let behind = reached.behind.unwrap();
        assert_ne!(behind, reached.along());
        assert_eq!(reached.merit, reached.along().min(-behind));
    }

    #[test]
    fn a_nan_merit_is_the_worse_merit() {
        assert_eq!(worse(1.0, 2.0), 1.0);
        assert_eq!(worse(2.0, 1.0), 1.0);
        assert!(worse(f64::NAN, 1.0).is_nan() && worse(1.0, f64::NAN).is_nan());
    }
}
