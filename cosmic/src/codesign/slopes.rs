//! Gradients of the loss with respect to the design and to the controller.

use autodiff::{CotangentBound, Real, Var};

use super::evaluator::Evaluator;
use super::progress::Progress;
use super::reach::{Reached, is_ranked_by_distance};
use super::schedule::Schedule;
use super::slope::{At, Slope};
use crate::design::{Design, Mixture};
use crate::domain::{Domain, draw};
use crate::inputs::{Block, CONTROLLER, DESIGN, Inputs, NOTHING};
use crate::lattice::State;
use crate::objective::{AnyLoss, LossOf};
use crate::projection::Projection;
use crate::random::{Purpose, stream_of};
use crate::scene::{GradientPrecision, HorizonMode};
use crate::simulator::Trajectory;
use crate::task::{Horizon, Task, together};

/// The variables that the loss is differentiated with respect to.
#[derive(Clone, Copy)]
pub(super) enum Sought<'a> {
    /// The design vectors. The given projection is applied to them.
    Design(Projection),
    /// The shares of the materials in each edge of a layout. They are the design vectors of the layout (D7).
    Shares,
    /// The controller of a robot that has this design.
    Controller(&'a Design<Mixture<f64>>),
    /// No variable: only the loss is computed, for a robot that has this design.
    Nothing(&'a Design<Mixture<f64>>),
}

impl Sought<'_> {
    pub(super) fn blocks(&self) -> &'static [Block] {
        match self {
            Self::Design(_) | Self::Shares => DESIGN,
            Self::Controller(_) => CONTROLLER,
            Self::Nothing(_) => NOTHING,
        }
    }

    /// The design that is simulated for the design vectors `z`. For [`Shares`](Self::Shares), `z` is treated as an
    /// undecided design, whose void edges keep their small stiffness.
    pub(super) fn design<R: Real>(&self, task: &Task, z: &[[R; 3]]) -> Design<Mixture<R>> {
        match self {
            Self::Design(projection) => Design::Undecided(task.mixtures(*projection, z)),
            Self::Shares => Design::of_shares(z),
            Self::Controller(design) | Self::Nothing(design) => design.lift(),
        }
    }
}

/// Rollouts whose mean speed exceeds this share of the speed bound are checked. Few walking robots are that fast: the
/// share is 1 m/s if the bound is 100 m/s.
const WALKS: f64 = 0.01;

impl Evaluator {
    /// The point at which an iteration computes its gradients: the current robot, the domains, and the horizon.
    pub(super) fn point(&self, progress: &Progress, now: &Schedule) -> At<'_> {
        At {
            domains: self.domains(progress, now),
            inputs: self.inputs(progress),
            horizon: self.horizon(now),
        }
    }

    /// The inputs of a rollout of the current robot from the unperturbed start.
    pub fn inputs(&self, progress: &Progress) -> Inputs<f64> {
        Inputs {
            z: progress.design.vectors().into_owned(),
            controller: progress.controller.clone(),
            start: self.start.clone(),
        }
    }

    /// The domains over which an iteration averages its gradients; empty for a scene without domain randomisation. They
    /// depend only on the seed and the iteration, so that a resumed run draws the same domains.
    fn domains(&self, progress: &Progress, now: &Schedule) -> Vec<Domain<'_>> {
        let settings = &self.scene.robust;
        let number = now.iteration as u64;
        let mut stream = stream_of(progress.seed, Purpose::DomainRandomisation, number);
        let domain = |_| draw(&self.task, settings, &mut stream);
        (0..settings.samples).map(domain).collect()
    }

    /// The horizon of an iteration: the steps that the gradient is computed over, and the bound on its cotangents.
    fn horizon(&self, now: &Schedule) -> Horizon {
        let gradient = &self.scene.gradient;
        let every = gradient.cotangent_every;
        // The cotangent of a position is a loss per length.
        let per_length = self.unit() / self.task.lattice.scale;
        let bound = |norm: f64| CotangentBound {
            norm: norm * per_length,
            every,
        };
        Horizon {
            steps: now.horizon(),
            mode: self.scene.schedule.horizon_mode,
            cotangent_bound: gradient.cotangent_bound.map(bound),
        }
    }

    /// The [unit of the loss](crate::objective::Loss::unit).
    fn unit(&self) -> f64 {
        self.loss.unit(self.task.lattice.scale)
    }

    /// The gradients with respect to the design, through the performance projection and through the stability
    /// projection; `None` for a projection that has no share in the update. The two rollouts run in SIMD lanes on one
    /// thread if that is possible, otherwise on two threads.
    pub(super) fn design_slopes(&self, at: &At) -> [Option<Slope>; 2] {
        let both = [Projection::Performance, Projection::Stability].map(Sought::Design);
        let alone = |k: usize| {
            let [slope] = self.slopes([both[k]], at);
            Some(slope)
        };
        match self.scene.schedule.stability_share {
            0.0 => [alone(0), None],
            1.0 => [None, alone(1)],
            _ if together(2) == 2 => self.slopes(both, at).map(Some),
            _ => rayon::join(|| alone(0), || alone(1)).into(),
        }
    }

    /// Gradients of the loss, in the precision of the scene: means over the domains, or the gradients of the nominal
    /// task if there are no domains. A gradient may overflow, in f32 sooner than in f64; the caller then skips the
    /// update.
    ///
    /// Several gradients in one call must all be with respect to the design, because their rollouts share the
    /// controller.
    pub(super) fn slopes<const N: usize>(&self, sought: [Sought; N], at: &At) -> [Slope; N] {
        let horizon = &at.horizon;
        at.means(&self.task, |task, inputs| {
            match self.scene.gradient.precision {
                GradientPrecision::F64 => {
                    self.differentiated::<f64, N>(task, inputs, &sought, horizon)
                }
                GradientPrecision::F32 => {
                    self.differentiated::<f32, N>(task, inputs, &sought, horizon)
                }
            }
        })
    }

    /// Returns `displacement`, which was reached in the rollout of a gradient, or NaN if the robot flew apart there.
    ///
    /// The rollout of a gradient does not check whether the robot flies apart. If the mean speed of the payload was
    /// high, the rollout is repeated with this check. Few walking robots are so fast, but all robots that fly apart
    /// are. With domains, the displacement is a mean and is not checked.
    pub(super) fn judged(&self, displacement: f64, sought: Sought, at: &At) -> f64 {
        let physics = &self.scene.physics;
        let (Some(bound), []) = (physics.speed_bound, &at.domains[..]) else {
            return displacement;
        };
        let steps = match at.horizon.mode {
            HorizonMode::Head => at.horizon.steps.min(physics.steps),
            HorizonMode::Tail => physics.steps,
        };
        if displacement.abs() <= WALKS * bound * steps as f64 * physics.dt {
            return displacement;
        }
        let mut task = self.task.clone();
        task.physics.steps = steps;
        let design = sought.design(&self.task, &at.inputs.z);
        let again = self.try_many(&[design], &at.inputs.controller, &task)[0];
        match again.along().is_nan() {
            true => f64::NAN,
            false => displacement,
        }
    }

    /// The merit (the number by which robots are ranked) within the horizon; `None` if robots are ranked by their
    /// displacement alone.
    pub(super) fn merit_horizon(&self, slope: &Slope) -> Option<f64> {
        (!is_ranked_by_distance(&self.scene, &*self.loss)).then_some(slope.merit)
    }

    /// The gradients of one task, computed in the number type `R`.
    fn differentiated<R: Real + Into<f64>, const N: usize>(
        &self,
        task: &Task,
        inputs: &Inputs<f64>,
        sought: &[Sought; N],
        horizon: &Horizon,
    ) -> [Slope; N]
    where
        dyn AnyLoss: LossOf<Var<R>>,
    {
        let mut reached = [None; N];
        let in_type = inputs.lift::<R>();
        let found = in_type.differentiate_copies(sought[0].blocks(), |copies: &[_; N]| {
            let designs: [_; N] = std::array::from_fn(|k| sought[k].design(task, &copies[k].z));
            let losses = self.losses_of(task, &designs, &copies[0], &inputs.start, horizon);
            std::array::from_fn(|k| {
                reached[k] = Some(losses[k].1);
                losses[k].0
            })
        });
        std::array::from_fn(|k| {
            let loss: f64 = found[k].0.into();
            let unit = self.unit();
            let usable = |g: f64| if loss.is_finite() { g / unit } else { f64::NAN };
            let Reached { moved, merit, .. } =
                reached[k].expect("each loss was computed with its result");
            Slope {
                gradient: found[k].1.iter().map(|&g| usable(g.into())).collect(),
                loss,
                displacement: moved.forward(),
                merit,
            }
        })
    }

    /// The loss of each robot within a horizon, and the robot's result measured from `start`. With two goals, the loss
    /// is the mean of the loss for the goal ahead and of minus the loss for the goal behind. The sign changes because
    /// the payload must move backwards to reach the goal behind.
    fn losses_of<R: Real, const N: usize>(
        &self,
        task: &Task,
        designs: &[Design<Mixture<R>>; N],
        inputs: &Inputs<R>,
        start: &State<f64>,
        horizon: &Horizon,
    ) -> Vec<(R, Reached)>
    where
        dyn AnyLoss: LossOf<R>,
    {
        let towards_goal = |task: &Task| -> Vec<(R, Reached)> {
            let seen = task.over_horizon(designs, inputs, &*self.loss, horizon);
            let lost = |seen: &Trajectory<R>| {
                let loss = self.loss.loss_of(seen);
                let moved = self.between(start, seen);
                (loss, self.reached_by(moved, || loss.primal()))
            };
            seen.iter().map(lost).collect()
        };
        self.towards_goals(task, towards_goal, |(loss, ahead), (back, behind)| {
            (R::lit(0.5) * (loss - back), ahead.with_behind(behind))
        })
    }
}

#[cfg(test)]
mod tests {
    use autodiff::Real;

    use super::{At, Evaluator, Slope, Sought};
    use crate::codesign::schedule::Schedule;
    use crate::codesign::tests::{begun, tiny};
    use crate::codesign::{CoDesign, Progress};
    use crate::inputs::{CONTROLLER, DESIGN, Inputs};
    use crate::objective::{AnyLoss, LossOf};
    use crate::projection::Projection;
    use crate::scene::{GradientPrecision, HorizonMode, MovedBody, Named, Scene, TaskKind};
    use crate::simulator::stability::Vibration;
    use crate::task::{Horizon, Task};

    /// The loss of the robot with which the optimisation of a scene begins, as a function of its inputs.
    fn loss_at<R: Real>(evaluator: &Evaluator, inputs: &Inputs<R>, horizon: &Horizon) -> R
    where
        dyn AnyLoss: LossOf<R>,
    {
        let (task, start) = (&evaluator.task, &evaluator.start);
        let design = Sought::Design(Projection::Performance).design(task, &inputs.z);
        evaluator.losses_of(task, &[design], inputs, start, horizon)[0].0
    }

    /// The slopes of the loss over 24 steps along a direction in the design and along one in the controller. Each must
    /// agree with a finite difference.
    fn slopes_agree_with_differences(scene: &Scene) -> [f64; 2] {
        let (evaluator, progress) = begun(scene);
        let (inputs, horizon) = (evaluator.inputs(&progress), Horizon::head(24));
        [DESIGN, CONTROLLER].map(|blocks| {
            let loss = |inputs: &Inputs<_>| loss_at(&evaluator, inputs, &horizon);
            let (_, gradient) = inputs.differentiate(blocks, loss);
            let numbers = inputs.get(blocks);
            let direction: Vec<f64> = (0..numbers.len()).map(|k| (k as f64).cos()).collect();
            let at = |h: f64| {
                let moved = numbers.iter().zip(&direction).map(|(x, d)| x + h * d);
                let mut inputs = inputs.clone();
                inputs.set(blocks, &moved.collect::<Vec<_>>());
                loss_at(&evaluator, &inputs, &horizon)
            };
            let slope: f64 = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
            let h = 1e-5;
            let difference = (at(h) - at(-h)) / (2.0 * h);
            // The absolute error is 1e-12: positions of 0.1 m are rounded at 1e-17, and differences are divided by
            // h. The relative truncation error is h^2 beta^2 = 4e-8.
            let off = (difference - slope).abs();
            assert!(off < 1e-7 * slope.abs() + 1e-11, "{difference} {slope}");
            slope
        })
    }

    /// The robot falls freely, so that the loss has no kinks.
    #[test]
    fn the_gradient_for_two_goals_agrees_with_differences() {
        let mut scene = tiny();
        (scene.lattice.drop, scene.controller.two_goals) = (1.0, true);
        scene.controller.goal_scale = 1.0;
        let slopes = slopes_agree_with_differences(&scene);
        assert!(slopes.iter().all(|slope| *slope != 0.0));
    }

    /// The weights of the centre of mass and of the nodes in use depend on the design, and the gradients contain that.
    /// The lowest nodes stand on the ground, so that the centre of mass can move.
    #[test]
    fn gradients_for_every_body_agree_with_differences() {
        for &(name, body) in MovedBody::ALL {
            for task in [TaskKind::Far, TaskKind::Reach, TaskKind::Climb] {
                let mut scene = tiny();
                (scene.objective.body, scene.objective.task) = (body, task);
                scene.start.tilt = 0.2;
                let slopes = slopes_agree_with_differences(&scene);
                assert!(slopes.iter().all(|slope| *slope != 0.0), "{name}");
            }
        }
    }

    /// Bars pull equally on both of their ends. So in free fall no design and no controller moves the centre of mass
    /// along the ground, but they move the payload and the mean of the nodes.
    #[test]
    fn bars_do_not_move_the_centre_of_mass() {
        let slope = |body| {
            let mut scene = tiny();
            (scene.lattice.drop, scene.objective.body) = (1.0, body);
            // With `one_piece`, the masses of nodes that are only partly in use would count less.
            (scene.start.tilt, scene.design.one_piece) = (0.2, false);
            let slope = slope_in_domains(&scene, 24);
            slope.gradient.iter().map(|g| g.abs()).fold(0.0, f64::max)
        };
        let [payload, mass, nodes] =
            [MovedBody::Payload, MovedBody::Mass, MovedBody::Nodes].map(slope);
        assert!(payload > 1e-5 && nodes > 1e-5, "{payload} {nodes}");
        // The gradient is a sum of numbers as large as the gradient for the payload, which cancel up to rounding.
        assert!(mass < 1e-9 * payload, "{mass} {payload}");
    }

    /// In the mode "tail" a displacement counts from the start of the whole rollout.
    #[test]
    fn a_tail_counts_from_the_start() {
        let mut scene = tiny();
        scene.objective.body = MovedBody::Nodes;
        let (evaluator, progress) = begun(&scene);
        let inputs = evaluator.inputs(&progress);
        let loss = |steps, mode| {
            let horizon = Horizon {
                mode,
                ..Horizon::head(steps)
            };
            loss_at::<f64>(&evaluator, &inputs, &horizon)
        };
        let whole = loss(24, HorizonMode::Head);
        assert_eq!(loss(8, HorizonMode::Tail), whole);
        assert_ne!(loss(8, HorizonMode::Head), whole);
    }

    /// The gradient with respect to the design over `steps` steps, averaged over the domains of the first iteration.
    fn slope_in_domains(scene: &Scene, steps: usize) -> Slope {
        let (evaluator, progress) = begun(scene);
        let mut at = evaluator.point(&progress, &Schedule::at(scene, 1));
        at.horizon = Horizon::head(steps);
        let [slope] = evaluator.slopes([Sought::Design(Projection::Performance)], &at);
        slope
    }

    /// A robot whose controller does not observe the goal moves the same way for both goals, in every domain. So the
    /// losses for the two goals cancel.
    #[test]
    fn both_goals_have_the_same_robot() {
        let mut scene = tiny();
        (scene.controller.two_goals, scene.controller.goal_scale) = (true, 0.0);
        scene.robust.samples = 3;
        let slope = slope_in_domains(&scene, 20);
        assert_eq!(slope.loss, 0.0);
        // Two gradients cancel. They come from numbers below 1 that are rounded at 1e-16.
        assert!(slope.gradient.iter().all(|g| g.abs() < 1e-14));
    }

    #[test]
    fn displacements_are_measured_from_the_start_of_the_domain() {
        let mut scene = tiny();
        (scene.robust.samples, scene.robust.start) = (2, 0.5);
        let slope = slope_in_domains(&scene, 1);
        // Springs that are stretched by half a metre accelerate nodes to 50 m/s. In a step of 2 ms, the payload then
        // moves less than 0.1 m.
        assert!(slope.displacement.abs() < 0.1, "{}", slope.displacement);
        assert!(slope.displacement != 0.0);
    }

    #[test]
    fn gradients_in_f32_agree_with_gradients_in_f64() {
        let mut scene = tiny();
        // A tilted start mixes all materials in different shares, so the gradient has no zeros.
        scene.start.tilt = 0.2;
        let double = CoDesign::new(&scene).unwrap();
        scene.gradient.precision = GradientPrecision::F32;
        let single = CoDesign::new(&scene).unwrap();
        let progress = double.begin(1).unwrap();
        let design = double.evaluator.design(&progress);
        let at = At {
            domains: Vec::new(),
            inputs: double.evaluator.inputs(&progress),
            horizon: Horizon::head(24),
        };
        for sought in [
            Sought::Design(Projection::Performance),
            Sought::Design(Projection::Stability),
            Sought::Controller(&design),
        ] {
            let [[a], [b]] =
                [&double, &single].map(|codesign| codesign.evaluator.slopes([sought], &at));
            let off: f64 = (a.gradient.iter().zip(&b.gradient))
                .map(|(a, b)| (a - b).powi(2))
                .sum();
            let norm: f64 = a.gradient.iter().map(|g| g * g).sum();
            // The expected relative error is 24 * 100^(1/2) * 6e-8: 24 steps, and in each about 100 operations that
            // round at 6e-8 with random signs. It is not 0, because the two gradients have different number types.
            let (share, tolerance) = ((off / norm).sqrt(), 1.5e-5);
            assert!(share > 0.0 && share < tolerance, "{share}");
            assert!(norm > 0.0);
            // Displacements are about 0.3 m and have the same relative error.
            assert!((a.displacement - b.displacement).abs() < 0.3 * tolerance);
        }
    }

    /// Two gradients in one call have the same bits as two calls, also over domains and with two goals.
    #[test]
    fn gradients_computed_together_are_bit_identical_to_single_ones() {
        let check = |scene: &Scene, mode: HorizonMode| {
            let (evaluator, progress) = begun(scene);
            let at = At {
                horizon: Horizon {
                    mode,
                    ..Horizon::head(20)
                },
                ..evaluator.point(&progress, &Schedule::at(scene, 1))
            };
            let both = [Projection::Performance, Projection::Stability].map(Sought::Design);
            let together = evaluator.slopes(both, &at);
            let alone = both.map(|sought| evaluator.slopes([sought], &at).into_iter().next());
            assert_eq!(together.clone().map(Some), alone);
            assert_ne!(together[0].gradient, together[1].gradient);
            assert_eq!(evaluator.design_slopes(&at), together.map(Some));
        };
        let mut scene = tiny();
        scene.start.tilt = 0.2;
        check(&scene, HorizonMode::Head);
        check(&scene, HorizonMode::Tail);
        scene.gradient.precision = GradientPrecision::F32;
        check(&scene, HorizonMode::Head);
        scene.controller.two_goals = true;
        scene.robust.samples = 2;
        scene.gradient.precision = GradientPrecision::F64;
        check(&scene, HorizonMode::Head);
    }

    /// The largest frequency of a vibration of the task's robot, in 1/s.
    fn frequency(codesign: &CoDesign, progress: &Progress, task: &Task) -> f64 {
        let body = task.body(&codesign.evaluator.design(progress));
        let rest = &task.lattice.positions;
        Vibration::new(&task.lattice, &body, &task.physics, rest).largest_frequency()
    }

    #[test]
    fn time_steps_are_checked_for_the_robots_that_are_drawn() {
        let mut scene = tiny();
        let alone = CoDesign::new(&scene).unwrap();
        let progress = alone.begin(0).unwrap();
        let nominal = (
            alone.step_check(&progress),
            frequency(&alone, &progress, &alone.evaluator.task),
        );
        (scene.robust.samples, scene.robust.stiffness) = (32, 0.4);
        let drawing = CoDesign::new(&scene).unwrap();
        let progress = drawing.begin(0).unwrap();
        let check = drawing.step_check(&progress);
        let drawn = drawing
            .evaluator
            .domains(&progress, &Schedule::at(&scene, 1));
        let drawn = drawn
            .iter()
            .map(|w| frequency(&drawing, &progress, &w.task));
        let fastest = drawn.fold(0.0, f64::max);
        let faster = scene.robust.faster();
        assert!(nominal.1 < fastest && fastest < faster * nominal.1);
        // Both sides are products and quotients of the same numbers, but rounded in another order.
        let is = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-14;
        assert!(is(
            check.bound.frequency,
            faster * nominal.0.bound.frequency
        ));
        let [any, any_drawn] = [nominal.0, check].map(|check| check.any_design.unwrap());
        // The longest stable time step of the damped symplectic Euler method is nearly proportional to 1 / frequency.
        assert!(any_drawn < any / (0.97 * faster), "{any_drawn} of {any}");
    }
}
