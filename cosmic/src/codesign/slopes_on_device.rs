//! Gradients of the loss, computed on a device for all domains, designs and goals together.

use std::borrow::Cow;

use autodiff::{Tape, Var};

use super::evaluator::Evaluator;
use super::on_device::{OnDevice, batch_of};
use super::reach::{Goal, Reached};
use super::slope::{At, Slope};
use super::slopes::Sought;
use crate::domain::{Domain, turned_back};
use crate::geometry::Vector;
use crate::inputs::{CONTROLLER, DESIGN};
use crate::population::{GradientBatch, RobotGradient};
use crate::scene::{GoalKind, HorizonMode, MovedBody};
use crate::simulator::{Span, Wanted};
use crate::task::Task;

impl Evaluator {
    /// The gradients of the loss of this part of the robot, like [`slopes`](Self::slopes).
    pub(super) fn slopes_on<const N: usize>(
        &self,
        device: &OnDevice,
        body: MovedBody,
        sought: &[Sought; N],
        at: &At,
    ) -> [Slope; N] {
        let domains = self.domains_of(body, at);
        let asked = self.asked(&domains, sought, at);
        let asked = self.after_head(device, asked, at);
        let Some(found) = asked.and_then(|asked| device.gradients(&asked)) else {
            return std::array::from_fn(|_| Slope {
                loss: f64::NAN,
                displacement: f64::NAN,
                merit: f64::NAN,
                ..Slope::default()
            });
        };
        let of_domain = |(d, domain): (usize, &Domain)| -> [Slope; N] {
            std::array::from_fn(|k| {
                let of_goals: Vec<_> = found.iter().map(|found| &found[d * N + k]).collect();
                self.slope_of(&of_goals, sought[k], domain, at)
            })
        };
        let mut slopes: Vec<[Slope; N]> = domains.iter().enumerate().map(of_domain).collect();
        if at.domains.is_empty() {
            return slopes.remove(0);
        }
        std::array::from_fn(|k| Slope::mean(slopes.iter().map(|slopes| &slopes[k])))
    }

    /// The domains of a point, or the nominal one if it has none, with this part of the robot as the one that counts.
    fn domains_of<'a>(&'a self, body: MovedBody, at: &'a At) -> Vec<Domain<'a>> {
        let mut domains = match at.domains.is_empty() {
            true => vec![Domain::of(&self.task, at.inputs.start.clone())],
            false => at.domains.clone(),
        };
        if body != self.scene.objective.body {
            for domain in &mut domains {
                domain.task = Cow::Owned(domain.task.as_ref().clone().with_moved(body));
            }
        }
        domains
    }

    /// The robots whose losses a point needs: for each goal those of all domains, each with all designs.
    pub(super) fn asked<const N: usize>(
        &self,
        domains: &[Domain],
        sought: &[Sought; N],
        at: &At,
    ) -> Vec<GradientBatch> {
        let task = &*domains[0].task;
        let mut span = task.span_of(&*self.loss, &at.horizon);
        if at.horizon.mode == HorizonMode::Tail {
            span.first = task.physics.steps - span.steps();
        }
        let of_domain = |domain: &Domain| sought.map(|s| s.design(&domain.task, &at.inputs.z));
        let designs: Vec<_> = domains.iter().flat_map(of_domain).collect();
        let designs: Vec<_> = designs.iter().collect();
        let by = Wanted {
            bodies: sought[0].blocks() == DESIGN,
            controllers: sought[0].blocks() == CONTROLLER,
            surroundings: false,
        };
        let towards = |goal: Goal| {
            let towards: Cow<[Domain]> = match goal {
                Goal::Ahead => Cow::Borrowed(domains),
                Goal::Behind => Cow::Owned(turned_back(domains)),
            };
            let repeated = towards.iter().flat_map(|domain| vec![domain.clone(); N]);
            let repeated: Vec<Domain> = repeated.collect();
            GradientBatch {
                of: batch_of(&designs, &at.inputs.controller, &repeated, &span),
                by,
                loss: self.loss.clone(),
                origins: Vec::new(),
            }
        };
        match self.scene.controller.goals {
            GoalKind::Two => vec![towards(Goal::Ahead), towards(Goal::Behind)],
            GoalKind::Fixed | GoalKind::Given => vec![towards(Goal::Ahead)],
        }
    }

    /// These robots after the steps before the horizon, which carry no gradient. `None` if the device failed.
    fn after_head(
        &self,
        device: &OnDevice,
        mut asked: Vec<GradientBatch>,
        at: &At,
    ) -> Option<Vec<GradientBatch>> {
        let first = asked[0].of.span.first;
        if at.horizon.mode == HorizonMode::Head || first == 0 {
            return Some(asked);
        }
        let heads = asked.iter().map(|asked| {
            let mut head = asked.of.clone();
            head.span = Span::from_start(vec![first]);
            head
        });
        let reached = device.rollouts(&heads.collect::<Vec<_>>())?;
        for (asked, reached) in asked.iter_mut().zip(reached) {
            asked.origins = asked
                .of
                .starts
                .iter()
                .map(|start| start.x.clone())
                .collect();
            asked.of.starts = reached.into_iter().flat_map(|seen| seen.states).collect();
        }
        Some(asked)
    }

    /// The slope of a robot in one domain, from its losses for all goals.
    fn slope_of(
        &self,
        of_goals: &[&RobotGradient],
        sought: Sought,
        domain: &Domain,
        at: &At,
    ) -> Slope {
        let result = |of: &RobotGradient| -> (f64, Vec<f64>, Reached) {
            let moved: Vector<f64> = self.between(&domain.start, &of.trajectory);
            let gradient = match sought {
                Sought::Design(_) | Sought::Shares => {
                    by_vectors(of, sought, &domain.task, &at.inputs.z)
                }
                Sought::Controller(_) => of.controller.clone(),
                Sought::Nothing(_) => Vec::new(),
            };
            (of.loss, gradient, self.reached_by(moved, || of.loss))
        };
        let (loss, gradient, reached) = match of_goals {
            [ahead, behind] => {
                let ((loss, mut gradient, ahead), (back, of_back, behind)) =
                    (result(ahead), result(behind));
                for (g, back) in gradient.iter_mut().zip(of_back) {
                    *g = 0.5 * (*g - back);
                }
                (0.5 * (loss - back), gradient, ahead.with_behind(behind))
            }
            of_goals => result(of_goals[0]),
        };
        let unit = self.unit();
        let usable = |g: f64| if loss.is_finite() { g / unit } else { f64::NAN };
        Slope {
            gradient: gradient.into_iter().map(usable).collect(),
            loss,
            displacement: reached.along(),
            merit: reached.merit,
            stuck: false,
        }
    }
}

/// The derivatives by the design vectors `z`, from those by the numbers of the body.
fn by_vectors(of: &RobotGradient, sought: Sought, task: &Task, z: &[[f64; 3]]) -> Vec<f64> {
    let mut tape = Tape::new();
    let body = tape.record(z.as_flattened(), |z: &[Var<f64>]| {
        let (z, _) = z.as_chunks();
        task.body(&sought.design(task, z)).numbers()
    });
    tape.pullback(&body, &of.body.numbers()).to_vec()
}
