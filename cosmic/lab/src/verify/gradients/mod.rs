//! The gradient of a robot's loss against finite differences and forward mode.

mod table;

use std::sync::Arc;

use autodiff::check::{Claim, Direction, Options, Report, Verdict, check_directions};
use autodiff::{Dual, Real};

use super::probe::norm;
use cosmic::case::Case;
use cosmic::geometry::Ground;
use cosmic::inputs::{ALL, Block, Inputs};
use cosmic::laws::ContactLaw;
use cosmic::objective::{AnyLoss, Displacement, LossOf, Objective, of_scene};
use cosmic::projection::Projection;
use cosmic::scene::{Integrator, ObjectiveSettings, Scene};
use cosmic::task::{Horizon, Task};

/// The height above the ground, m, to which a robot's lowest node is lifted off a kink.
const LIFT: f64 = 1e-3;

/// The check of one group of parameters.
#[derive(Clone, Debug)]
pub struct Group {
    /// The name of its block of the inputs.
    pub name: &'static str,
    /// How many numbers.
    pub numbers: usize,
    /// Length of the gradient by them.
    pub norm: f64,
    /// Slopes along random directions.
    pub report: Report,
    /// True if the slopes are those of a robot lifted off the ground; see [`check_gradients_of`].
    pub lifted: bool,
    /// The report's verdict; at best a kink for a robot that had to be lifted.
    pub verdict: Verdict,
}

impl Group {
    /// True if forward and reverse mode both say that the loss does not depend on the group, and
    /// nothing contradicts them: such a row compares zeros with zeros.
    pub fn is_zero(&self) -> bool {
        let still = |direction: &Direction| direction.forward == Some(0.0);
        let agreed = self.verdict != Verdict::Wrong;
        agreed && self.norm == 0.0 && self.report.directions.iter().all(still)
    }

    /// The verdict on this gradient made wrong; `None` unless the gradient is smooth, because only then
    /// it can be told from a wrong one.
    fn control(&self) -> Option<NegativeControl> {
        let smooth = self.report.verdict == Verdict::Smooth;
        let verdict = self.report.control.filter(|_| smooth)?;
        Some(NegativeControl {
            group: self.name,
            verdict,
        })
    }
}

/// A gradient that is wrong on purpose. A check that misses it checks nothing.
#[derive(Clone, Copy, Debug)]
pub struct NegativeControl {
    /// The group whose gradient was made wrong.
    pub group: &'static str,
    /// The verdict of the check.
    pub verdict: Verdict,
}

/// The check of every group, and of the check itself.
#[derive(Clone, Debug)]
pub struct GradientCheck {
    /// Steps of the rollout.
    pub steps: usize,
    /// One per block of the inputs.
    pub groups: Vec<Group>,
    /// `None` if no group has a smooth gradient to make wrong that is neither zero nor below the
    /// displacement's rounding.
    pub control: Option<NegativeControl>,
    /// An estimate of the rounding of the slopes, as a share of them: every step rounds the state, and
    /// the motion magnifies that like a change of the start, and slopes alike.
    pub rounding: f64,
}

impl GradientCheck {
    /// The failed checks: groups with a wrong gradient, and a negative control that was believed.
    pub fn failures(&self) -> Vec<String> {
        let wrong = |group: &&Group| group.verdict == Verdict::Wrong;
        let groups = self.groups.iter().filter(wrong).map(|g| g.name.to_owned());
        let believed = self.control.iter().filter(|c| c.verdict != Verdict::Wrong);
        let control = believed.map(|_| "the negative control".to_owned());
        groups.chain(control).collect()
    }

    /// The number of checks.
    pub fn total(&self) -> usize {
        self.groups.len() + usize::from(self.control.is_some())
    }
}

/// The share of rounding in the slopes that a check accepts without a note.
const WORN: f64 = 1e-6;
/// This many times [`GradientCheck::rounding`], which is an estimate, make a bound.
const SAFETY: f64 = 64.0;

/// Checks the gradient of a scene's loss, or without a scene of `-(s . x_0(T))`, the paper's loss, of a
/// case; see [`check_gradients_of`].
pub fn check_gradients(
    case: &Case,
    scene: Option<&Scene>,
    steps: usize,
    options: &Options,
) -> GradientCheck {
    let loss = match scene {
        Some(scene) => of_scene(scene),
        None => {
            let at_end = Displacement::at_end(Ground::from(&case.physics)).settings;
            let task = ObjectiveSettings::default();
            Arc::new(Objective::new(&task, &at_end, &case.physics))
        }
    };
    check_gradients_of(&*loss, case, steps, options)
}

/// Checks the gradient of a loss by every block of a case's inputs. The case is cut to `steps` steps.
/// Take few: a robot's motion is chaotic, and over thousands of steps no finite difference means
/// anything.
///
/// A node exactly on the ground line sits on a kink of the positions, with one derivative upwards and
/// another downwards. Several such nodes take sides one by one, and no difference along a line shows
/// that. The derivatives by the positions are then checked for a robot that is lifted until its lowest
/// node is 1 mm above the ground. The derivatives by the velocities have a kink if a node starts on the
/// ground line or below it, and if either leapfrog integrates, whose first drift comes before any force,
/// or nothing has weight: then the velocity of a node decides whether it touches. They are checked for
/// the lifted robot as well.
///
/// If the motion magnifies rounding until it shows in the slopes, differences that disagree prove
/// nothing. The verdict is then a kink, unless forward mode disagrees by more than rounding explains.
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
    // The roundings of steps add up at random.
    let steps_taken = case.physics.steps as f64;
    let options = &Options {
        noise: options.noise.max(f64::EPSILON * steps_taken.sqrt()),
        // Names of inputs differ from block to block.
        names: Vec::new(),
        ..options.clone()
    };
    let leaps = case.physics.integrator == Integrator::Leapfrog;
    let floats = case.physics.gravity == 0.0;
    let is_kink = |block| match block {
        Block::X0 => stands,
        Block::V0 => leaps || floats,
        _ => false,
    };
    let group = |&block: &Block| {
        let above = above.as_ref().filter(|_| is_kink(block));
        let mut group = above.unwrap_or(&here).group(block, options, rounding);
        if above.is_some() {
            (group.lifted, group.verdict) = (true, group.verdict.max(Verdict::Kink));
        }
        group
    };
    let groups: Vec<Group> = ALL.iter().map(group).collect();
    GradientCheck {
        steps: case.physics.steps,
        control: groups.iter().find_map(Group::control),
        groups,
        rounding,
    }
}

/// True if rounding explains the difference of forward and reverse mode.
fn is_rounding(report: &Report, norm: f64, rounding: f64) -> bool {
    report.directions.iter().all(|direction| {
        let forward = direction.forward.unwrap_or(direction.gradient);
        let off = (forward - direction.gradient).abs();
        off <= SAFETY * rounding * norm.max(forward.abs()).min(f64::MAX)
    })
}

/// The rounding of heights in an incline's frame, m.
const ON_LINE: f64 = 1e-12;

/// True if a node starts on the ground line; true if a node starts there or below.
fn stands_and_touches(case: &Case) -> [bool; 2] {
    let any = |is: fn(f64) -> bool| {
        case.physics.contact != ContactLaw::none() && heights(case).into_iter().any(is)
    };
    [any(|h| h.abs() < ON_LINE), any(|h| h < ON_LINE)]
}

/// The heights of all nodes above the ground and its profile, m.
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
    case: &'a Case,
    of: &'a dyn AnyLoss,
    /// The case with the softer stability projection, to which the derivative belongs.
    softer: Case,
    task: Task,
    inputs: Inputs<f64>,
    /// The gradient that is checked, each number in the place of its input.
    gradient: Inputs<f64>,
}

impl<'a> CaseLoss<'a> {
    fn new(case: &'a Case, of: &'a dyn AnyLoss) -> Self {
        let mut softer = case.clone();
        softer.sharpness.beta_stability = softer.sharpness.beta_straight_through;
        let mut subject = Self {
            case,
            of,
            softer,
            task: case.task(),
            inputs: case.inputs(),
            gradient: case.inputs(),
        };
        let loss = |inputs: &Inputs<_>| subject.loss(inputs);
        let (_, gradient) = subject.inputs.differentiate(ALL, loss);
        subject.gradient.set(ALL, &gradient);
        subject
    }

    /// See [`GradientCheck::rounding`].
    fn rounding(&self) -> f64 {
        let largest = |x: &[f64]| x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let steps = self.case.physics.steps as f64;
        f64::EPSILON
            * steps
            * norm(&self.gradient.block(Block::X0))
            * largest(&self.inputs.block(Block::X0))
    }

    /// Checks the gradient by a block.
    fn group(&self, block: Block, options: &Options, rounding: f64) -> Group {
        let gradient = &*self.gradient.block(block);
        let (report, length) = (self.check(block, gradient, options), norm(gradient));
        let magnified = rounding > WORN && is_rounding(&report, length, rounding);
        // If the norm is below the rounding, a unit change of the parameters moves the robot by less
        // than rounding does.
        let mut verdict = report.verdict;
        if magnified || length < rounding {
            verdict = verdict.min(Verdict::Kink);
        }
        Group {
            name: block.name(),
            numbers: gradient.len(),
            norm: length,
            report,
            lifted: false,
            verdict,
        }
    }

    fn check(&self, block: Block, gradient: &[f64], options: &Options) -> Report {
        let x = &*self.inputs.block(block);
        let value = |x: &[f64]| {
            let mut inputs = self.inputs.clone();
            inputs.set(&[block], x);
            self.moved_loss(&inputs)
        };
        let forward = |direction: &[f64]| {
            let dual = |(&value, &slope): (&f64, &f64)| Dual {
                value,
                tangent: [slope],
            };
            let moving: Vec<Dual<f64, 1>> = x.iter().zip(direction).map(dual).collect();
            let mut inputs = self.inputs.lift();
            inputs.set(&[block], &moving);
            self.loss(&inputs).tangent[0]
        };
        let claim = Claim {
            x,
            gradient,
            forward: Some(&forward),
        };
        check_directions(value, &claim, options)
    }

    /// The function whose gradient is checked.
    fn loss<R: Real>(&self, inputs: &Inputs<R>) -> R
    where
        dyn AnyLoss + 'a: LossOf<R>,
    {
        self.loss_of(&self.case.mixture(self.case.projection, &inputs.z), inputs)
    }

    /// The function of the differences. The stability projection has the derivative of a softer one, so
    /// differences see the change of the soft projection on top of the sharp value.
    fn moved_loss(&self, inputs: &Inputs<f64>) -> f64 {
        if self.case.projection == Projection::Performance || self.case.frozen.is_some() {
            return self.loss(inputs);
        }
        let soft = |z| self.softer.mixture(Projection::Stability, z);
        let mut moved = self.case.mixture(Projection::Stability, &self.inputs.z);
        let change = soft(&inputs.z).into_iter().zip(soft(&self.inputs.z));
        for (share, (there, here)) in moved.iter_mut().zip(change) {
            for k in 0..3 {
                share[k] += there[k] - here[k];
            }
        }
        self.loss_of(&moved, inputs)
    }

    fn loss_of<R: Real>(&self, mixture: &[[R; 3]], inputs: &Inputs<R>) -> R
    where
        dyn AnyLoss + 'a: LossOf<R>,
    {
        let horizon = Horizon::head(self.case.physics.steps);
        self.task.loss(mixture, inputs, self.of, &horizon)
    }
}

#[cfg(test)]
mod tests {
    use super::{
        Case, Claim, GradientCheck, Options, Verdict, check_directions, check_gradients,
        is_rounding,
    };
    use crate::verify::probe::small;
    use cosmic::laws::ContactLaw;
    use cosmic::scene::{Integrator, Scene};

    /// A check without failures.
    fn passed(case: &Case, steps: usize) -> GradientCheck {
        let check = check_gradients(case, None, steps, &Options::default());
        assert!(check.failures().is_empty(), "{check}");
        check
    }

    #[test]
    fn wrong_groups_and_believed_controls_are_failures() {
        let mut check = passed(&small([2, 2], |_| ()), 32);
        assert_eq!((check.steps, check.total()), (32, 8));
        check.groups[2].verdict = Verdict::Wrong;
        check.groups[5].verdict = Verdict::Kink;
        check.control.as_mut().unwrap().verdict = Verdict::Smooth;
        assert_eq!(check.failures(), ["b1", "the negative control"]);
    }

    /// A slack robot does not feel its controller, and nothing but the last digits tells how a robot is made
    /// that falls and does not move: such slopes are not called wrong, and are no control.
    #[test]
    fn slopes_below_the_displacement_s_rounding_fail_nothing() {
        let slack = &small([2, 2], |scene| {
            (scene.physics.contact, scene.materials.stiffness) = (ContactLaw::none(), [1e-16; 3]);
        });
        let falling = &small([3, 3], |scene| {
            (scene.controller.hidden, scene.physics.contact) = (4, ContactLaw::none());
            scene.materials.max_strain = [0.0; 3];
        });
        for (case, steps, group, most) in [
            (slack, 32, 1, 1e-16),
            (falling, 64, 0, 1e-9),
            (falling, 256, 0, 1e-9),
        ] {
            let check = passed(case, steps);
            let norm = check.groups[group].norm;
            assert!(0.0 < norm && norm < most, "{check}");
            assert_eq!(check.control.map(|c| c.group), Some("x0"), "{check}");
        }
    }

    #[test]
    fn an_infinite_slope_is_not_put_down_to_rounding() {
        let claim = Claim {
            x: &[1.0],
            gradient: &[2.0],
            forward: Some(&|_: &[f64]| f64::INFINITY),
        };
        let report = check_directions(|x| 2.0 * x[0], &claim, &Options::default());
        assert!(!is_rounding(&report, 2.0, 1e-5), "{report}");
    }

    /// Light nodes under large strains without damping: a change of the start grows beyond what
    /// floats hold, and nothing can be said.
    #[test]
    fn slopes_that_rounding_makes_up_are_not_called_wrong() {
        let case = small([3, 3], |scene| {
            scene.lattice.drop = 0.01;
            (scene.physics.node_mass, scene.physics.payload_mass) = (1e-4, 0.0);
            (scene.physics.damping, scene.physics.stiffening) = (5.0, 80.0);
            (scene.physics.contact, scene.physics.friction) = (ContactLaw::coulomb(), 0.0);
            scene.materials.max_strain = [0.0, 0.0, 0.7];
            (scene.controller.hidden, scene.controller.gain) = (4, [6.0, 6.0]);
            scene.controller.velocity_scale = 0.5;
        });
        let check = passed(&case, 200);
        let says_so = check.to_string().contains("take fewer steps");
        assert!(check.rounding > 1.0 && says_so, "{check}");
        let check = passed(&case, 32);
        assert!(check.rounding < 1e-6 && check.control.is_some(), "{check}");
    }

    /// Where robots stand on ground, leapfrog has a kink of the velocities as well, and so has a
    /// world without weight; where there is no ground, nothing has.
    #[test]
    fn robots_that_stand_are_lifted_off_their_kinks() {
        let lifted = |change: &dyn Fn(&mut Scene)| {
            let check = passed(&small([2, 2], change), 32);
            let lifted = check.groups.iter().filter(|group| group.lifted);
            lifted.map(|group| group.name).collect::<Vec<_>>()
        };
        let leapfrog = |s: &mut Scene| s.physics.integrator = Integrator::Leapfrog;
        assert_eq!(lifted(&|_| ()), ["x0"]);
        assert_eq!(lifted(&leapfrog), ["x0", "v0"]);
        for substeps in [1, 2] {
            let leaps = |s: &mut Scene| {
                leapfrog(s);
                s.physics.substeps = substeps;
                s.physics.contact = ContactLaw::coulomb();
            };
            assert_eq!(lifted(&leaps), ["x0", "v0"]);
        }
        let floats = |s: &mut Scene| s.physics.gravity = 0.0;
        assert_eq!(lifted(&floats), ["x0", "v0"]);
        // Nodes that rest below the line: their velocities alone have a kink.
        let sunk = |s: &mut Scene| {
            leapfrog(s);
            s.lattice.drop = -0.003;
        };
        assert_eq!(lifted(&sunk), ["v0"]);
        let nowhere = |s: &mut Scene| s.physics.contact = ContactLaw::none();
        assert_eq!(lifted(&nowhere), Vec::<&str>::new());
    }
}
