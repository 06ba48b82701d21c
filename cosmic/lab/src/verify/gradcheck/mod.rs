//! Checks the gradient of a robot's loss against finite differences and against forward mode.

mod table;

use autodiff::check::{Claim, Direction, Options, Report, Verdict, check_directions};
use autodiff::{Dual, Real};

use super::probe::{Probe, norm};
use cosmic::case::Case;
use cosmic::design::{Design, Mixture};
use cosmic::geometry::Ground;
use cosmic::inputs::{ALL, Block, Inputs, Part};
use cosmic::laws::ContactLaw;
use cosmic::objective::{AnyLoss, Displacement, LossOf, of_scene};
use cosmic::projection::Projection;
use cosmic::scene::{Integrator, Scene};
use cosmic::task::Horizon;

/// The height, in metres, to which a robot's lowest node is lifted above the ground. A node exactly on the ground is at
/// a kink of the loss.
const LIFT: f64 = 1e-3;
/// If the rounding error of the slopes exceeds this fraction of the slopes, the output mentions it.
const WORN: f64 = 1e-6;
/// The factor from the estimate [`GradientCheck::rounding`] of the rounding error to a bound on it.
const SAFETY: f64 = 64.0;
/// A bound on the rounding errors of heights above an inclined ground, in metres.
const ON_LINE: f64 = 1e-12;

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
    /// The verdict on the group's gradient. If the robot was lifted off the ground for the check, the best possible
    /// verdict is "kink".
    pub verdict: Verdict,
}

impl Group {
    /// True if the loss does not depend on the group: forward and reverse mode return zeros, and differences do not
    /// contradict that. A check of such a group proves little.
    fn is_zero(&self) -> bool {
        let still = |direction: &Direction| direction.forward == Some(0.0);
        let agreed = self.verdict != Verdict::Wrong;
        agreed && self.norm == 0.0 && self.report.directions.iter().all(still)
    }

    /// The verdict on a copy of the gradient that is wrong on purpose. `None` if the gradient is not smooth: then the
    /// check cannot tell a wrong gradient from the right one.
    fn control(&self) -> Option<NegativeControl> {
        let smooth = self.report.verdict == Verdict::Smooth;
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
    /// One check for each block of the inputs.
    pub groups: Vec<Group>,
    /// The negative control, which tests the check itself. `None` if no group has a smooth gradient that is larger than
    /// the rounding error of the displacement.
    pub control: Option<NegativeControl>,
    /// An estimate of the rounding error of the slopes, relative to the slopes. Every step rounds the state, and the
    /// motion magnifies these errors as it magnifies any change of the start.
    pub rounding: f64,
}

impl GradientCheck {
    /// The names of the failed checks: groups with a wrong gradient, and the negative control if it was accepted.
    pub fn failures(&self) -> Vec<String> {
        let wrong = |group: &&Group| group.verdict == Verdict::Wrong;
        let groups = self.groups.iter().filter(wrong).map(|g| g.name.to_owned());
        let believed = self.control.iter().filter(|c| c.verdict != Verdict::Wrong);
        let control = believed.map(|_| "the negative control".to_owned());
        groups.chain(control).collect()
    }

    /// The number of checks: one for each group, and the negative control if there is one.
    pub fn total(&self) -> usize {
        self.groups.len() + usize::from(self.control.is_some())
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
            let loss = Displacement::at_end(Ground::from(&case.physics));
            check_gradients_of(&loss, case, steps, options)
        }
    }
}

/// Checks the gradient of a loss with respect to every block of a case's inputs, over the first `steps` steps. Use few
/// steps: a robot's motion is chaotic, and over thousands of steps finite differences mean nothing.
///
/// If a node starts exactly on the ground line, the loss has a kink with respect to the positions: moving the node up
/// gives another slope than moving it down. Differences then cannot show the derivative. So the gradient with respect
/// to the positions is checked for a lifted robot, whose lowest node is 1 mm above the ground.
///
/// The loss has a kink with respect to the velocities if a node starts on or below the ground line and its velocity
/// decides whether it touches the ground. This happens in two cases: with leapfrog, which moves the nodes before any
/// force has acted, and without gravity. The gradient with respect to the velocities is then checked for the lifted
/// robot too.
///
/// The motion may magnify rounding errors so much that they show in the slopes. Differences that disagree then prove
/// nothing. The verdict is a kink, unless forward mode disagrees by more than rounding explains.
pub fn check_gradients_of(
    loss: &dyn AnyLoss,
    case: &Case,
    steps: usize,
    options: &Options,
) -> GradientCheck {
    let mut case = case.clone();
    case.physics.steps = steps.min(case.physics.steps);
    let here = CaseLoss::new(&case, loss);
    let [stands, touches] = stands_and_touches(&case);
    let lifted = touches.then(|| lifted(&case));
    let above = lifted.as_ref().map(|case| CaseLoss::new(case, loss));
    let rounding = here.rounding();
    // The rounding errors of the steps are random, so their sum grows with the square root of the number of steps.
    let steps_taken = case.physics.steps as f64;
    let options = &Options {
        noise: options.noise.max(f64::EPSILON * steps_taken.sqrt()),
        // The names of the inputs are not set, because they differ from block to block.
        names: Vec::new(),
        ..options.clone()
    };
    let leaps = case.physics.integrator == Integrator::Leapfrog;
    let floats = case.physics.gravity == 0.0;
    let is_kink = |part: &Part| match part.block {
        Block::X0 => stands,
        Block::V0 => leaps || floats,
        _ => false,
    };
    let group = |part: &Part| {
        let above = above.as_ref().filter(|_| is_kink(part));
        let mut group = above.unwrap_or(&here).group(part, options, rounding);
        if above.is_some() {
            (group.lifted, group.verdict) = (true, group.verdict.max(Verdict::Kink));
        }
        group
    };
    let groups: Vec<Group> = here.probe.inputs.parts().iter().map(group).collect();
    GradientCheck {
        steps: case.physics.steps,
        control: groups.iter().find_map(Group::control),
        groups,
        rounding,
    }
}

/// True if rounding explains why forward and reverse mode differ.
pub fn is_rounding(report: &Report, norm: f64, rounding: f64) -> bool {
    report.directions.iter().all(|direction| {
        let forward = direction.forward.unwrap_or(direction.gradient);
        let off = (forward - direction.gradient).abs();
        off <= SAFETY * rounding * norm.max(forward.abs()).min(f64::MAX)
    })
}

/// Returns two answers: whether a node starts on the ground line, and whether a node starts on or below it.
fn stands_and_touches(case: &Case) -> [bool; 2] {
    let any = |is: fn(f64) -> bool| {
        case.physics.contact != ContactLaw::none() && heights(case).into_iter().any(is)
    };
    [any(|h| h.abs() < ON_LINE), any(|h| h < ON_LINE)]
}

/// The heights of all nodes above the terrain, m.
fn heights(case: &Case) -> Vec<f64> {
    let state = case.start.to_ground(&Ground::from(&case.physics));
    let profile = case.physics.ground.resolved();
    state.x.iter().map(|&x| profile.above(x)).collect()
}

fn lifted(case: &Case) -> Case {
    let by = LIFT - heights(case).into_iter().fold(0.0, f64::min);
    let mut case = case.clone();
    let normal = Ground::from(&case.physics).normal();
    for x in &mut case.start.x {
        *x += normal * by;
    }
    case
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
}

impl<'a> CaseLoss<'a> {
    fn new(case: &'a Case, of: &'a dyn AnyLoss) -> Self {
        let mut softer = case.clone();
        softer.sharpness.beta_stability = softer.sharpness.beta_straight_through;
        let mut subject = Self {
            probe: Probe::new(case),
            of,
            softer,
            gradient: case.inputs(),
        };
        let (_, gradient) = subject.probe.reverse(ALL, |inputs| subject.loss(inputs));
        subject.gradient.set(ALL, &gradient);
        subject
    }

    /// Estimates [`GradientCheck::rounding`].
    fn rounding(&self) -> f64 {
        let largest = |x: &[f64]| x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let steps = self.probe.case.physics.steps as f64;
        let start = largest(&self.probe.inputs.block(Block::X0));
        f64::EPSILON * steps * norm(&self.gradient.block(Block::X0)) * start
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
        let value = |x: &[f64]| {
            let mut inputs = self.probe.inputs.clone();
            inputs.set_part(part, x);
            self.moved_loss(&inputs)
        };
        let (report, norm) = (check_directions(value, &claim, options), norm(&gradient));
        let magnified = rounding > WORN && is_rounding(&report, norm, rounding);
        // If the norm is below the rounding error, changing the parameters by 1 moves the robot less than rounding
        // does.
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
    fn moved_loss(&self, inputs: &Inputs<f64>) -> f64 {
        let case = self.probe.case;
        let at = &self.probe.inputs.z;
        let mut design = case.projected(Projection::Stability, at);
        let (Projection::Stability, Some(moved)) = (case.projection, design.undecided_mut()) else {
            return self.loss(inputs);
        };
        let soft = |z: &[_]| self.softer.projected(Projection::Stability, z);
        let (there, here) = (soft(&inputs.z), soft(at));
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
        let horizon = Horizon::head(self.probe.case.physics.steps);
        (self.probe.task).loss(design, inputs, self.of, &horizon)
    }
}
