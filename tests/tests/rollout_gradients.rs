//! Gradients of whole rollouts by every block of their inputs: reverse mode against forward mode
//! and finite differences, for every contact law, ground and projection.

use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::{Function, Real};
use cosmic::case::Case;
use cosmic::ground::Ground;
use cosmic::inputs::DESIGN;
use cosmic::laws::ContactLaw;
use cosmic::objective::Displacement;
use cosmic::projection::Projection;
use cosmic::scene::{HorizonMode, LossKind, LossSettings, Scene};
use cosmic::task::{Horizon, Task};
use cosmic_lab::verify::check_gradients;

/// Long enough to fall, hit the ground and push off; short enough for differences.
const STEPS: usize = 90;

/// A small robot that falls on the ground while it moves along it.
fn robot(contact: ContactLaw, incline_deg: f64, projection: Projection) -> Case {
    let mut scene = Scene::paper();
    (scene.lattice.columns, scene.lattice.rows) = (3, 2);
    // High enough that nothing touches in the first step, low enough to fall in a third of the
    // time.
    scene.lattice.drop = 0.004;
    scene.controller.hidden = 6;
    // The controller must have a say within so few steps.
    scene.controller.velocity_scale = 0.5;
    scene.physics.contact = contact;
    scene.physics.friction = 0.4;
    scene.physics.incline_deg = incline_deg;
    scene.physics.steps = STEPS;
    let mut case = Case::of_scene(&scene, 3).unwrap_or_else(|error| panic!("{error}"));
    case.projection = projection;
    let ground = Ground::from(&scene.physics);
    let velocity = |i: usize| ground.vector_to_world([0.5 + 0.02 * i as f64, -0.01 * i as f64]);
    case.start.v = (0..case.lattice.nodes()).map(velocity).collect();
    // Away from the mixture in which all edges are alike.
    let z = case.design.undecided_mut().expect("a start of mixtures");
    for (e, z) in z.iter_mut().enumerate() {
        z[1] += 0.002 * (e as f64).sin();
        z[2] += 0.002 * (1.7 * e as f64).cos();
    }
    case
}

/// How often a node stands on the ground line: every touch and every step of rest.
fn touches(case: &Case) -> usize {
    let every_step: Vec<usize> = (0..=STEPS).collect();
    let results = case.evaluate(false, &every_step);
    let results = results.unwrap_or_else(|error| panic!("{error}"));
    let ground = Ground::from(&case.physics);
    let states = results.trajectory.values();
    let points = states.flat_map(|state| state.to_ground(&ground).x);
    // To the rounding of an incline's frame.
    points.filter(|x| x[1].abs() < 1e-12).count()
}

#[test]
fn every_block_under_every_contact_law_and_projection() {
    for contact in [ContactLaw::infinite(), ContactLaw::coulomb()] {
        for incline_deg in [0.0, 15.0] {
            for projection in [Projection::Performance, Projection::Stability] {
                let case = robot(contact.clone(), incline_deg, projection);
                let name = format!("{contact:?}, {incline_deg} degrees, {projection:?}");
                assert!(touches(&case) > 0, "{name}: nothing touches the ground");
                let check = check_gradients(&case, None, STEPS, &Options::default());
                assert_eq!(check.groups.len(), 7);
                for group in &check.groups {
                    let text = format!("{name}, {}:\n{}", group.name, group.report);
                    assert_eq!(group.verdict, Verdict::Smooth, "{text}");
                    assert!(group.norm > 0.0, "{text}");
                }
                let control = check.control.map(|control| control.verdict);
                assert_eq!(
                    control,
                    Some(Verdict::Wrong),
                    "{name}: the negative control"
                );
            }
        }
    }
}

/// A loss of the design vectors over a horizon, made wrong by a factor on its derivative.
struct OfDesign<'a> {
    case: &'a Case,
    task: Task,
    loss: Displacement,
    horizon: Horizon,
    wrong_by: f64,
}

impl Function for OfDesign<'_> {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let mut inputs = self.case.inputs().lift();
        inputs.set(DESIGN, x);
        let design = self.case.projected(self.case.projection, &inputs.z);
        let loss = (self.task).loss(&design, &inputs, &self.loss, &self.horizon);
        loss.straight_through(loss * R::lit(1.0 + self.wrong_by))
    }
}

/// The loss that the optimiser takes: a mean over the last part of the rollout.
#[test]
fn the_mean_loss_of_a_rollout() {
    let case = robot(ContactLaw::infinite(), 0.0, Projection::Performance);
    for (wrong_by, expected) in [(0.0, Verdict::Smooth), (1e-3, Verdict::Wrong)] {
        let function = OfDesign {
            task: case.task(),
            loss: Displacement {
                ground: Ground::from(&case.physics),
                settings: LossSettings {
                    kind: LossKind::Mean,
                    window: 64,
                    every: 8,
                },
            },
            horizon: Horizon::head(STEPS),
            case: &case,
            wrong_by,
        };
        let report = check_gradient(
            &function,
            case.design.vectors().as_flattened(),
            &Options::default(),
        );
        // Forward mode is as wrong as reverse mode here: it is the differences that notice.
        assert_eq!(report.verdict, expected, "{report}");
    }
}

/// A design that detached steps lead to: the derivative is that of the tail alone, from the state
/// that the head ends in.
#[test]
fn the_tail_of_a_rollout() {
    const TAIL: usize = 40;
    let case = robot(ContactLaw::coulomb(), 15.0, Projection::Performance);
    let task = case.task();
    let at_end = || Displacement::at_end(Ground::from(&case.physics));
    let horizon = Horizon {
        steps: TAIL,
        mode: HorizonMode::Tail,
        cotangent_bound: None,
    };
    let inputs = case.inputs();
    let (value, tail) = inputs.differentiate(DESIGN, |inputs| {
        let design = case.projected(case.projection, &inputs.z);
        task.loss(&design, inputs, &at_end(), &horizon)
    });
    // The whole value, with a part of the gradient. Where head and tail meet, the state goes
    // through the world's frame: a rounding of 1e-17, which 40 steps multiply by a hundred at most.
    let whole = case.displacement_loss(&task, &inputs);
    assert!((value - whole).abs() < 1e-14, "{value} {whole}");
    let (_, all) = inputs.differentiate(DESIGN, |inputs| case.displacement_loss(&task, inputs));
    assert_ne!(tail, all);
    assert!(tail.iter().any(|g| *g != 0.0));
}
