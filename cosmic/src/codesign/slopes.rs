//! Gradients of the loss.

use autodiff::{CotangentBound, Real, Var};

use super::begin::CoDesign;
use super::progress::Progress;
use super::reach::worse;
use super::schedule::Schedule;
use super::slope::{At, Slope};
use crate::design::{Design, Mixture};
use crate::domain::{Domain, draw};
use crate::inputs::{Block, CONTROLLER, DESIGN, Inputs, NOTHING};
use crate::lattice::State;
use crate::objective::{AnyLoss, LossOf};
use crate::projection::Projection;
use crate::random::{Purpose, stream_of};
use crate::scene::GradientPrecision;
use crate::simulator::Trajectory;
use crate::task::{Horizon, Task, together};

/// The variables of a gradient.
#[derive(Clone, Copy)]
pub(super) enum Sought<'a> {
    /// The design, in a projection.
    Design(Projection),
    /// The shares of the materials in a layout. They are its design vectors (D7).
    Shares,
    /// The controller of a robot of this design.
    Controller(&'a Design<Mixture<f64>>),
    /// No variable: the loss of a robot of this design, without a gradient.
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

    /// The robot's design. Shares that are variables are not decided: their void edges keep their stiffness.
    pub(super) fn design<R: Real>(&self, task: &Task, z: &[[R; 3]]) -> Design<Mixture<R>> {
        match self {
            Self::Design(projection) => Design::Undecided(task.mixtures(*projection, z)),
            Self::Shares => Design::of_shares(z),
            Self::Controller(design) | Self::Nothing(design) => design.lift(),
        }
    }
}

/// The loss that a gradient differentiates, with its rollouts.
struct Sloped<R> {
    loss: R,
    ahead: Seen<R>,
    /// The rollout towards the second of two goals.
    behind: Option<Seen<R>>,
}

/// A rollout towards one goal, with its loss.
struct Seen<R> {
    loss: R,
    trajectory: Trajectory<R>,
}

impl CoDesign {
    /// The point of an iteration's gradients.
    pub(super) fn point(&self, progress: &Progress, now: &Schedule) -> At<'_> {
        At {
            domains: self.domains(progress, now),
            inputs: self.inputs(progress),
            horizon: self.horizon(now),
        }
    }

    /// The inputs of the present robot's rollout from the unperturbed start.
    pub fn inputs(&self, progress: &Progress) -> Inputs<f64> {
        Inputs {
            z: progress.design.vectors().into_owned(),
            controller: progress.controller.clone(),
            start: self.start.clone(),
        }
    }

    /// The domains of an iteration's gradients; none if the scene asks for the nominal robot. Every
    /// iteration has its own, by its number, so that a resumed run draws the same domains.
    fn domains(&self, progress: &Progress, now: &Schedule) -> Vec<Domain<'_>> {
        let settings = &self.scene.robust;
        let number = now.iteration as u64;
        let mut stream = stream_of(progress.seed, Purpose::DomainRandomisation, number);
        let domain = |_| draw(&self.task, settings, &mut stream);
        (0..settings.samples).map(domain).collect()
    }

    /// The steps that carry the gradient in an iteration, and how its cotangents are bounded.
    fn horizon(&self, now: &Schedule) -> Horizon {
        let gradient = &self.scene.gradient;
        let every = gradient.cotangent_every;
        let bound = |norm| CotangentBound { norm, every };
        Horizon {
            steps: now.horizon(),
            mode: self.scene.schedule.horizon_mode,
            cotangent_bound: gradient.cotangent_bound.map(bound),
        }
    }

    /// The gradients by the design in the performance and the stability projection; `None` for a
    /// projection without a share in the update. On one thread the two rollouts run side by side in
    /// lanes, on more threads in parallel.
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

    /// Gradients of the loss in the scene's precision, as means over the domains or of the nominal
    /// task. A gradient may overflow, in f32 sooner than in f64: the caller skips that update.
    ///
    /// Several gradients in one call are all by the design: their rollouts share the controller.
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

    /// The gradients of one task in the number type `R`.
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
        let mut displacements = [0.0; N];
        let mut merits = [0.0; N];
        let in_type = inputs.lift::<R>();
        let found = in_type.differentiate_copies(sought[0].blocks(), |copies: &[_; N]| {
            let designs: [_; N] = std::array::from_fn(|k| sought[k].design(task, &copies[k].z));
            let losses = self.losses_of(task, &designs, &copies[0], horizon);
            std::array::from_fn(|k| {
                [displacements[k], merits[k]] = self.reached_within(&losses[k], &inputs.start);
                losses[k].loss
            })
        });
        std::array::from_fn(|k| {
            let loss: f64 = found[k].0.into();
            let usable = |g: f64| if loss.is_finite() { g } else { f64::NAN };
            Slope {
                gradient: found[k].1.iter().map(|&g| usable(g.into())).collect(),
                loss,
                displacement: displacements[k],
                merit: merits[k],
            }
        })
    }

    /// The displacement ahead after a horizon, and the merit.
    fn reached_within<R: Real + Into<f64>>(
        &self,
        sloped: &Sloped<Var<R>>,
        start: &State<f64>,
    ) -> [f64; 2] {
        let reached = |seen: &Seen<Var<R>>| {
            let last = seen.trajectory.at(seen.trajectory.last_step());
            let [along, _] = self.between(start, &last.map(|x| x.value().into()));
            let loss: f64 = seen.loss.value().into();
            [along, if self.loss.is_far() { along } else { -loss }]
        };
        let [along, merit] = reached(&sloped.ahead);
        let merit = sloped.behind.iter().fold(merit, |merit, behind| {
            let [_, behind] = reached(behind);
            worse(merit, -behind)
        });
        [along, merit]
    }

    /// The losses and their rollouts. With two goals a loss is the mean of the loss for the goal
    /// ahead and of minus the loss for the goal behind: the payload is to get as far back.
    fn losses_of<R: Real, const N: usize>(
        &self,
        task: &Task,
        designs: &[Design<Mixture<R>>; N],
        inputs: &Inputs<R>,
        horizon: &Horizon,
    ) -> Vec<Sloped<R>>
    where
        dyn AnyLoss: LossOf<R>,
    {
        let losses = |task: &Task| {
            let seen = task.over_horizon(designs, inputs, &*self.loss, horizon);
            seen.into_iter().map(|trajectory| Seen {
                loss: self.loss.loss_of(&trajectory),
                trajectory,
            })
        };
        let ahead = losses(task);
        if !self.scene.controller.two_goals {
            let alone = |ahead: Seen<R>| Sloped {
                loss: ahead.loss,
                ahead,
                behind: None,
            };
            return ahead.map(alone).collect();
        }
        let both = |(ahead, behind): (Seen<R>, Seen<R>)| Sloped {
            loss: R::lit(0.5) * (ahead.loss - behind.loss),
            ahead,
            behind: Some(behind),
        };
        // All rollouts ahead come first: the bits of the gradient depend on the order.
        let ahead: Vec<Seen<R>> = ahead.collect();
        let behind = losses(&task.turned_back());
        ahead.into_iter().zip(behind).map(both).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{At, Slope, Sought};
    use crate::codesign::schedule::Schedule;
    use crate::codesign::tests::tiny;
    use crate::codesign::{CoDesign, Progress};
    use crate::inputs::{CONTROLLER, DESIGN, Inputs};
    use crate::projection::Projection;
    use crate::scene::{GradientPrecision, HorizonMode, Scene};
    use crate::simulator::stability::Vibration;
    use crate::task::{Horizon, Task};

    /// The loss of two goals, its gradient by design and controller against differences. The robot
    /// falls freely: nothing has a kink.
    #[test]
    fn the_loss_of_two_goals_has_the_gradient_of_differences() {
        let mut scene = tiny();
        (scene.lattice.drop, scene.controller.two_goals) = (1.0, true);
        scene.controller.goal_scale = 1.0;
        let codesign = CoDesign::new(&scene).unwrap();
        let progress = codesign.begin(1).unwrap();
        let inputs = codesign.inputs(&progress);
        let horizon = Horizon::head(24);
        let value = |inputs: &Inputs<f64>| {
            let design = Sought::Design(Projection::Performance).design(&codesign.task, &inputs.z);
            codesign.losses_of(&codesign.task, &[design], inputs, &horizon)[0].loss
        };
        for blocks in [DESIGN, CONTROLLER] {
            let (_, gradient) = inputs.differentiate(blocks, |inputs| {
                let sought = Sought::Design(Projection::Performance);
                let design = sought.design(&codesign.task, &inputs.z);
                codesign.losses_of(&codesign.task, &[design], inputs, &horizon)[0].loss
            });
            let numbers = inputs.get(blocks);
            let direction: Vec<f64> = (0..numbers.len()).map(|k| (k as f64).cos()).collect();
            let at = |h: f64| {
                let moved = numbers.iter().zip(&direction).map(|(x, d)| x + h * d);
                let mut inputs = inputs.clone();
                inputs.set(blocks, &moved.collect::<Vec<_>>());
                value(&inputs)
            };
            let slope: f64 = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
            let h = 1e-5;
            let difference = (at(h) - at(-h)) / (2.0 * h);
            // Positions of 0.1 m rounded at 1e-17 and divided by h: 1e-12; truncation h^2 beta^2,
            // 4e-8, of the slope.
            assert!((difference - slope).abs() < 1e-7 * slope.abs() + 1e-11);
            assert!(slope != 0.0);
        }
    }

    /// The slope by the design over so many steps in the domains of the first iteration.
    fn slope_in_domains(scene: &Scene, steps: usize) -> Slope {
        let codesign = CoDesign::new(scene).unwrap();
        let progress = codesign.begin(1).unwrap();
        let mut at = codesign.point(&progress, &Schedule::at(scene, 1));
        at.horizon = Horizon::head(steps);
        let [slope] = codesign.slopes([Sought::Design(Projection::Performance)], &at);
        slope
    }

    /// Where the network does not see the goal, what it does ahead it does behind: in every domain.
    #[test]
    fn both_goals_are_pursued_by_the_same_robot() {
        let mut scene = tiny();
        (scene.controller.two_goals, scene.controller.goal_scale) = (true, 0.0);
        scene.robust.samples = 3;
        let slope = slope_in_domains(&scene, 20);
        assert_eq!(slope.loss, 0.0);
        // Two sweeps that cancel, each of numbers below 1 rounded at 1e-16.
        assert!(slope.gradient.iter().all(|g| g.abs() < 1e-14));
    }

    /// A robot moves from where it stands, not from where the nominal one does.
    #[test]
    fn displacements_are_from_each_start() {
        let mut scene = tiny();
        (scene.robust.samples, scene.robust.start) = (2, 0.5);
        let slope = slope_in_domains(&scene, 1);
        // A step of 2 ms at speeds of springs that are off by half a metre: 50 m/s, not 0.1 m at
        // once.
        assert!(slope.displacement.abs() < 0.1, "{}", slope.displacement);
        assert!(slope.displacement != 0.0);
    }

    #[test]
    fn slopes_in_f32_are_those_in_f64_to_their_digits() {
        let mut scene = tiny();
        // From among all materials: a start with a slope by everything.
        scene.start.tilt = 0.2;
        let double = CoDesign::new(&scene).unwrap();
        scene.gradient.precision = GradientPrecision::F32;
        let single = CoDesign::new(&scene).unwrap();
        let progress = double.begin(1).unwrap();
        let design = double.design(&progress);
        let at = At {
            domains: Vec::new(),
            inputs: double.inputs(&progress),
            horizon: Horizon::head(24),
        };
        for sought in [
            Sought::Design(Projection::Performance),
            Sought::Design(Projection::Stability),
            Sought::Controller(&design),
        ] {
            let [[a], [b]] = [&double, &single].map(|codesign| codesign.slopes([sought], &at));
            let off: f64 = (a.gradient.iter().zip(&b.gradient))
                .map(|(a, b)| (a - b).powi(2))
                .sum();
            let norm: f64 = a.gradient.iter().map(|g| g * g).sum();
            // 24 steps of some hundred operations, each rounded at 6e-8, that add up as they
            // come: 24 * 100^(1/2) * 6e-8. Where both were of one type, they would be equal.
            let (share, tolerance) = ((off / norm).sqrt(), 1.5e-5);
            assert!(share > 0.0 && share < tolerance, "{share}");
            assert!(norm > 0.0);
            // Of 0.3 m, at the same digits.
            assert!((a.displacement - b.displacement).abs() < 0.3 * tolerance);
        }
    }

    /// Side by side or one by one: the same bits, over domains and with two goals too.
    #[test]
    fn slopes_taken_together_are_those_taken_alone() {
        let check = |scene: &Scene, mode: HorizonMode| {
            let codesign = CoDesign::new(scene).unwrap();
            let progress = codesign.begin(1).unwrap();
            let at = At {
                horizon: Horizon {
                    mode,
                    ..Horizon::head(20)
                },
                ..codesign.point(&progress, &Schedule::at(scene, 1))
            };
            let both = [Projection::Performance, Projection::Stability].map(Sought::Design);
            let together = codesign.slopes(both, &at);
            let alone = both.map(|sought| codesign.slopes([sought], &at).into_iter().next());
            assert_eq!(together.clone().map(Some), alone);
            assert_ne!(together[0].gradient, together[1].gradient);
            assert_eq!(codesign.design_slopes(&at), together.map(Some));
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

    /// The largest frequency of a task's robot, 1/s.
    fn frequency(codesign: &CoDesign, progress: &Progress, task: &Task) -> f64 {
        let body = task.body(&codesign.design(progress));
        let rest = &task.lattice.positions;
        Vibration::new(&task.lattice, &body, &task.physics, rest).largest_frequency()
    }

    #[test]
    fn time_steps_are_held_against_the_robots_that_are_drawn() {
        let mut scene = tiny();
        let alone = CoDesign::new(&scene).unwrap();
        let progress = alone.begin(0).unwrap();
        let nominal = (
            alone.step_check(&progress),
            frequency(&alone, &progress, &alone.task),
        );
        (scene.robust.samples, scene.robust.stiffness) = (32, 0.4);
        let drawing = CoDesign::new(&scene).unwrap();
        let progress = drawing.begin(0).unwrap();
        let check = drawing.step_check(&progress);
        let drawn = drawing.domains(&progress, &Schedule::at(&scene, 1));
        let drawn = drawn
            .iter()
            .map(|w| frequency(&drawing, &progress, &w.task));
        let fastest = drawn.fold(0.0, f64::max);
        let faster = scene.robust.faster();
        assert!(nominal.1 < fastest && fastest < faster * nominal.1);
        // Products and quotients of the same numbers, in another order.
        let is = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-14;
        assert!(is(
            check.bound.frequency,
            faster * nominal.0.bound.frequency
        ));
        let [any, any_drawn] = [nominal.0, check].map(|check| check.any_design.unwrap());
        // Symplectic Euler's damped limit is all but inverse to the frequency.
        assert!(any_drawn < any / (0.97 * faster), "{any_drawn} of {any}");
    }
}
