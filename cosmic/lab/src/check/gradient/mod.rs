//! Checks the gradient of a robot's loss against finite differences and against forward mode.

mod robot;
mod table;

use autodiff::check::{Claim, Options, Report, Verdict, check_directions};
use autodiff::{DoubleDouble, Dual, Real};

pub use robot::Perturbation;
use robot::{LIFT, lifted, moving, stands_and_touches, starts_at_a_kink};

use super::probe::Probe;
use crate::report::sheet::Section;
use cosmic::case::Case;
use cosmic::design::{Design, Mixture};
use cosmic::geometry::Ground;
use cosmic::inputs::{ALL, InputBlock, Inputs, Part};
use cosmic::objective::{AnyLoss, Displacement, LossOf, loss_of, of_scene};
use cosmic::projection::Projection;
use cosmic::scene::{Integrator, Scene};
use cosmic::world::Span;

/// If the rounding error of the slopes exceeds this fraction of the slopes, the output mentions it.
const WORN: f64 = 1e-6;
/// The factor from the estimate [`GradientCheck::rounding`] of the rounding error to a bound on it.
const SAFETY: f64 = 64.0;

/// The check of the gradient with respect to one group of parameters.
#[derive(Clone, Debug)]
pub struct Group {
    /// The name of the group of parameters: a block of the inputs.
    pub name: String,
    /// The number of parameters in the group.
    pub numbers: usize,
    /// The norm of the gradient with respect to the group.
    pub norm: f64,
    /// The comparison of slopes along random directions: those of the gradient, of differences, and of forward mode.
    pub report: Report,
    /// True if the robot was lifted off the ground for this check. [`check_gradients_of`] explains why.
    pub lifted: bool,
    /// True if the nodes of the robot were given velocities for this check. [`check_gradients_of`] explains why.
    pub moving: bool,
    /// The verdict on the group's gradient. If the robot was lifted off the ground or given velocities for the check, the
    /// best possible verdict is "kink".
    pub verdict: Verdict,
}

impl Group {
    /// True if the check of this group compared nothing: the gradient is zero or consists of rounding errors, and forward
    /// mode and differences do not contradict that. `rounding` is [`GradientCheck::rounding`].
    fn is_empty(&self, rounding: f64) -> bool {
        self.verdict != Verdict::Wrong && is_below_rounding(self.norm, rounding)
    }

    /// The verdict on a copy of the gradient that is wrong on purpose. `None` if the gradient is not smooth or consists of
    /// rounding errors: then the check cannot tell a wrong gradient from the right one.
    fn control(&self, rounding: f64) -> Option<NegativeControl> {
        let smooth =
            self.report.verdict == Verdict::Smooth && !is_below_rounding(self.norm, rounding);
        let verdict = self.report.control.filter(|_| smooth)?;
        Some(NegativeControl {
            group: self.name.clone(),
            verdict,
        })
    }
}

/// A check of a gradient that is wrong on purpose. If the check accepts it, the other checks prove nothing.
#[derive(Clone, Debug)]
pub struct NegativeControl {
    /// The name of the group whose gradient was made wrong.
    pub group: String,
    /// The verdict on the gradient that was made wrong on purpose.
    pub verdict: Verdict,
}

/// The checks of all groups, and a negative control that tests the check itself.
#[derive(Clone, Debug)]
pub struct GradientCheck {
    /// The number of steps of the rollout.
    pub steps: usize,
    /// How the robot of the check differs from that of the case. [`check_gradients_of`] explains why.
    pub perturbation: Perturbation,
    /// The groups for which the robot of the case has no gradient. Empty unless the robot was [perturbed](Self::perturbation).
    pub still: Vec<String>,
    /// One check for each block of the inputs. A layout has no design vectors, so it has no group `z`.
    pub groups: Vec<Group>,
    /// The negative control, which tests the check itself. `None` if no group has a smooth gradient that is larger than
    /// the rounding error of the displacement. Then the differences confirmed nothing.
    pub control: Option<NegativeControl>,
    /// The height above the ground to which a robot that stands is [lifted](Group::lifted), m.
    pub lift: f64,
    /// An estimate of the rounding error of the slopes, relative to the slopes. Every step rounds the state, and the
    /// motion magnifies these errors as it magnifies any change of the start.
    pub rounding: f64,
}

impl GradientCheck {
    /// The names of the failed checks, with a reason: groups with a wrong gradient, groups for which nothing could be
    /// compared, and the negative control if it is missing or was accepted.
    pub fn failures(&self) -> Vec<String> {
        let group = |group: &Group| match group.verdict {
            Verdict::Wrong => Some(format!("{} (wrong gradient)", group.name)),
            _ if group.is_empty(self.rounding) => {
                Some(format!("{} (nothing could be compared)", group.name))
            }
            _ => None,
        };
        let control = match &self.control {
            None => Some("the negative control (nothing could be compared)"),
            Some(control) if control.verdict == Verdict::Wrong => None,
            Some(_) => Some("the negative control (accepted)"),
        };
        let groups = self.groups.iter().filter_map(group);
        groups.chain(control.map(str::to_owned)).collect()
    }

    /// The names of the groups for which nothing could be compared.
    fn empty(&self) -> Vec<&str> {
        let empty = self.groups.iter().filter(|g| g.is_empty(self.rounding));
        empty.map(|group| &group.name[..]).collect()
    }

    /// The number of checks: one for each group, and the negative control.
    pub fn total(&self) -> usize {
        self.groups.len() + 1
    }
}

/// Compares the gradient of a case with finite differences and forward mode, over the first `steps` steps and along random
/// directions that follow from `seed`. See [`check_gradients_of`].
pub fn gradient(case: &Case, scene: Option<&Scene>, steps: usize, seed: u64) -> Section {
    let options = Options {
        seed,
        // A rollout in double-doubles takes long.
        directions: 2,
        ..Options::default()
    };
    let check = check_gradients(case, scene, steps, &options);
    let of = scene.map_or("displacement", |_| "scene's loss");
    Section {
        title: "Gradient".to_owned(),
        text: format!("of the {of} over {} steps\n{check}\n", check.steps),
        notes: check.notes(),
        tables: vec![check.table()],
        checks: check.total(),
        failures: check.failures(),
        ..Section::default()
    }
}

/// Checks the gradient of a loss for a case. The loss is that of `scene`; without a scene it is the paper's loss `-(s .
/// x_0(T))`. See [`check_gradients_of`].
pub fn check_gradients(
    case: &Case,
    scene: Option<&Scene>,
    steps: usize,
    options: &Options,
) -> GradientCheck {
    match scene {
        Some(scene) => check_gradients_of(&*of_scene(scene), case, steps, options),
        None => {
            let loss = Displacement::at_end(Ground::from(&case.scene.physics));
            check_gradients_of(&loss, case, steps, options)
        }
    }
}

/// Checks the gradient of a loss with respect to every block of a case's inputs, over the first `steps` steps. Use few
/// steps: a robot's motion is chaotic, and over thousands of steps finite differences mean nothing.
///
/// If a node starts exactly on the ground line, the loss has a kink with respect to the positions: moving the node up
/// gives another slope than moving it down. Differences then cannot show the derivative. So the gradient with respect
/// to the positions is checked for a lifted robot, whose lowest node is a hundredth of a spacing above the ground.
///
/// The loss has a kink with respect to the velocities if a node starts on or below the ground line and its velocity
/// decides whether it touches the ground. This happens in two cases: with leapfrog, which moves the nodes before any
/// force has acted, and without gravity. The gradient with respect to the velocities is then checked for the lifted
/// robot too.
///
/// The force of the law `actuator` has a kink where the length of a bar does not change. If the scene has this law, the
/// gradient with respect to the velocities of a robot at rest is checked for a lifted robot whose nodes move slowly.
///
/// The motion may magnify rounding errors so much that they show in the slopes. Differences, which are taken in
/// double-doubles, then disagree and prove nothing. The verdict is a kink, unless forward mode disagrees by more than
/// rounding explains.
///
/// A robot whose payload sticks to the ground has no gradient, so a check of it would compare zeros. Then the gradient is
/// checked for another robot: the robot of the case is thrown, and if that is not enough, its controller is drawn at
/// random. [`failures`](GradientCheck::failures) names the groups that have no gradient even then.
pub fn check_gradients_of(
    loss: &dyn AnyLoss,
    case: &Case,
    steps: usize,
    options: &Options,
) -> GradientCheck {
    let mut case = case.clone();
    case.scene.physics.steps = steps.min(case.scene.physics.steps);
    let still = CaseLoss::new(&case, loss).without_gradient();
    let (perturbation, case) = comparable(case, loss, still.len());
    GradientCheck {
        still: if perturbation == Perturbation::No {
            Vec::new()
        } else {
            still
        },
        ..checked_at(loss, &case, options, perturbation)
    }
}

/// Moves the robot of a case as little as possible so that every group has a gradient, or as many groups as possible.
/// `still` is the number of groups without a gradient for the robot as it is.
fn comparable(case: Case, loss: &dyn AnyLoss, still: usize) -> (Perturbation, Case) {
    let (mut fewest, mut best) = (still, (Perturbation::No, case.clone()));
    for perturbation in Perturbation::WAYS {
        if fewest == 0 {
            break;
        }
        let robot = perturbation.of(&case);
        let without = CaseLoss::new(&robot, loss).without_gradient().len();
        if without < fewest {
            (fewest, best) = (without, (perturbation, robot));
        }
    }
    best
}

/// Checks the gradient at the robot of a case.
fn checked_at(
    loss: &dyn AnyLoss,
    case: &Case,
    options: &Options,
    perturbation: Perturbation,
) -> GradientCheck {
    let here = CaseLoss::new(case, loss);
    let [stands, touches] = stands_and_touches(case);
    let moving = starts_at_a_kink(case).then(|| moving(case));
    let moving = moving.as_ref().map(|case| CaseLoss::new(case, loss));
    let lifted = touches.then(|| lifted(case));
    let above = lifted.as_ref().map(|case| CaseLoss::new(case, loss));
    let rounding = here.rounding();
    let options = &Options {
        // The names of the inputs are not set, because they differ from block to block.
        names: Vec::new(),
        ..options.clone()
    };
    let leaps = case.scene.physics.integrator == Integrator::Leapfrog;
    let floats = case.scene.physics.gravity == 0.0;
    let is_kink = |part: &Part| match part.block {
        InputBlock::X0 => stands,
        InputBlock::V0 => leaps || floats,
        _ => false,
    };
    let group = |part: &Part| {
        let moving = moving.as_ref().filter(|_| part.block == InputBlock::V0);
        let above = above.as_ref().filter(|_| moving.is_none() && is_kink(part));
        let elsewhere = moving.or(above);
        let mut group = elsewhere.unwrap_or(&here).group(part, options, rounding);
        (group.lifted, group.moving) = (above.is_some(), moving.is_some());
        if elsewhere.is_some() {
            group.verdict = group.verdict.max(Verdict::Kink);
        }
        group
    };
    let groups: Vec<Group> = here.parts().iter().map(group).collect();
    GradientCheck {
        steps: case.scene.physics.steps,
        perturbation,
        still: Vec::new(),
        control: groups.iter().find_map(|group| group.control(rounding)),
        groups,
        lift: LIFT * case.lattice.scale,
        rounding,
    }
}

/// True if a gradient with this norm is zero or so small that changing the parameters by 1 moves the robot less than
/// rounding does.
fn is_below_rounding(norm: f64, rounding: f64) -> bool {
    norm == 0.0 || norm < rounding
}

/// True if rounding explains why forward and reverse mode differ.
pub fn is_rounding(report: &Report, norm: f64, rounding: f64) -> bool {
    report.directions.iter().all(|direction| {
        let forward = direction.forward.unwrap_or(direction.gradient);
        let off = (forward - direction.gradient).abs();
        off <= SAFETY * rounding * norm.max(forward.abs()).min(f64::MAX)
    })
}

/// The loss of a case as a function of its inputs.
struct CaseLoss<'a> {
    probe: Probe<'a>,
    of: &'a dyn AnyLoss,
    /// The case with a softer stability projection. By design, the derivative of the stability projection is the
    /// derivative of this softer projection.
    softer: Case,
    /// The gradient to check, in the form of the inputs: in the place of each input is the derivative with respect to
    /// that input.
    gradient: Inputs<f64>,
    /// A constant that is added to the loss in differences. A loss may be near 0, although it is a difference of positions
    /// and has their rounding errors. With this constant it is at least as large as its unit, so the checker does not
    /// expect a smaller error.
    offset: f64,
}

impl<'a> CaseLoss<'a> {
    fn new(case: &'a Case, of: &'a dyn AnyLoss) -> Self {
        let mut softer = case.clone();
        softer.scene.projection.beta_stability = softer.scene.projection.beta_straight_through;
        let mut subject = Self {
            probe: Probe::new(case),
            of,
            softer,
            gradient: case.inputs(),
            offset: 0.0,
        };
        let inputs = &subject.probe.inputs;
        let (loss, gradient) = inputs.differentiate(ALL, |inputs| subject.loss(inputs));
        subject.gradient.set(ALL, &gradient);
        subject.offset = of.unit(case.lattice.scale).copysign(loss);
        subject
    }

    /// The parts of the inputs with respect to which the loss is differentiated. A layout has one material per edge, so
    /// its design vectors are no variables.
    fn parts(&self) -> Vec<Part> {
        let is_layout = self.probe.case.design.layout().is_some();
        let mut parts = self.probe.inputs.parts();
        parts.retain(|part| part.block != InputBlock::Z || !is_layout);
        parts
    }

    /// The names of the parts for which there is no gradient to compare.
    fn without_gradient(&self) -> Vec<String> {
        let rounding = self.rounding();
        let is_usable = |norm: f64| norm.is_finite() && !is_below_rounding(norm, rounding);
        let parts = self.parts().into_iter();
        let without = parts.filter(|part| !is_usable(f64::norm(&self.gradient.part(part))));
        without.map(|part| part.name).collect()
    }

    /// Estimates [`GradientCheck::rounding`].
    fn rounding(&self) -> f64 {
        let largest = |x: &[f64]| x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let steps = self.probe.case.scene.physics.steps as f64;
        let start = largest(&self.probe.inputs.block(InputBlock::X0));
        f64::EPSILON * steps * f64::norm(&self.gradient.block(InputBlock::X0)) * start
    }

    /// Checks the gradient with respect to one block of the inputs.
    fn group(&self, part: &Part, options: &Options, rounding: f64) -> Group {
        let (x, gradient) = (self.probe.inputs.part(part), self.gradient.part(part));
        let forward = |direction: &[f64]| {
            let pairs = x.iter().zip(direction);
            let dual = |(&value, &d)| Dual {
                value,
                tangent: [d],
            };
            let mut inputs = self.probe.inputs.lift();
            inputs.set_part(part, &pairs.map(dual).collect::<Vec<_>>());
            self.loss(&inputs).tangent[0]
        };
        let claim = Claim {
            x: &x,
            gradient: &gradient,
            forward: Some(&forward),
        };
        let value = |x: &[DoubleDouble]| {
            let mut inputs = self.probe.inputs.lift();
            inputs.set_part(part, x);
            self.moved_loss(&inputs) + DoubleDouble::lit(self.offset)
        };
        let (report, norm) = (
            check_directions(value, &claim, options),
            f64::norm(&gradient),
        );
        let magnified = rounding > WORN && is_rounding(&report, norm, rounding);
        let mut verdict = report.verdict;
        if magnified || norm < rounding {
            verdict = verdict.min(Verdict::Kink);
        }
        Group {
            name: part.name.clone(),
            numbers: gradient.len(),
            norm,
            report,
            lifted: false,
            moving: false,
            verdict,
        }
    }

    /// The loss as a function of the inputs. The gradient that is checked is the gradient of this function.
    fn loss<R: Real>(&self, inputs: &Inputs<R>) -> R
    where
        dyn AnyLoss + 'a: LossOf<R>,
    {
        let case = self.probe.case;
        self.loss_of(&case.projected(case.projection, &inputs.z), inputs)
    }

    /// The loss as a function of the inputs, for finite differences. By design, the derivative of the stability
    /// projection comes from a softer projection. So this function projects the design vectors sharply, and then adds
    /// the change of the softer projection when the inputs move.
    fn moved_loss(&self, inputs: &Inputs<DoubleDouble>) -> DoubleDouble {
        let case = self.probe.case;
        let at: Inputs<DoubleDouble> = self.probe.inputs.lift();
        let mut design = case.projected(Projection::Stability, &at.z);
        let (Projection::Stability, Some(moved)) = (case.projection, design.undecided_mut()) else {
            return self.loss(inputs);
        };
        let soft = |z: &[_]| self.softer.projected(Projection::Stability, z);
        let (there, here) = (soft(&inputs.z), soft(&at.z));
        let (there, here) = (there.mixtures(), here.mixtures());
        for (shares, (there, here)) in moved.iter_mut().zip(there.iter().zip(&*here)) {
            for k in 0..3 {
                shares.0[k] += there.0[k] - here.0[k];
            }
        }
        self.loss_of(&design, inputs)
    }

    fn loss_of<R: Real>(&self, design: &Design<Mixture<R>>, inputs: &Inputs<R>) -> R
    where
        dyn AnyLoss + 'a: LossOf<R>,
    {
        let world = &self.probe.world;
        let span = Span::of_steps(world.physics().steps);
        loss_of(world, &inputs.robot(world, design), self.of, &span)
    }
}
