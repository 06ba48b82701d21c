//! Rollouts leave out terms without effect. Their results agree with those of the full simulator.

use autodiff::{Parameters, Real};
use cosmic::case::Case;
use cosmic::inputs::{ALL, CONTROLLER, Inputs};
use cosmic::lattice::Body;
use cosmic::lattice::State;
use cosmic::laws::ContactLaw;
use cosmic::objective::{Displacement, Loss, loss_of};
use cosmic::scene::{ControllerSettings, LossSettings, Scene};
use cosmic::world::{Span, Trajectory, World};
use cosmic_tests::farthest;

const STEPS: usize = 256;

/// A robot with a layout that stands on three legs.
fn layout() -> Case {
    case("baseline_tall", |_| ())
}

fn case(scene: &str, change: impl FnOnce(&mut Scene)) -> Case {
    let mut scene = Scene::load(scene).unwrap();
    scene.physics.steps = STEPS;
    change(&mut scene);
    Case::of_scene(&scene, 3).unwrap()
}

/// A positive number that is smaller than the rounding error of any sum to which it is added.
const TINY: f64 = 1e-150;

/// This body with a tiny strain for every edge whose strain is 0. Steps then compute the controller's outputs for these
/// edges.
fn straining(body: &Body<f64>) -> Body<f64> {
    Body {
        strain: body.strain.iter().map(|s| s.max(TINY)).collect(),
        ..body.clone()
    }
}

/// The last state of a rollout of the case with the given body.
fn end(case: &Case, world: &World, body: &Body<f64>) -> State<f64> {
    let robot = world.robot(body.clone(), case.controller.clone(), &case.start);
    let span = Span::of_steps(case.scene.physics.steps);
    world.run_one(&robot, &span).states.remove(0)
}

/// Leaving out the controller's outputs for edges without strain does not change a bit, because each output is a
/// separate sum.
#[test]
fn outputs_of_edges_that_do_not_strain_change_no_bit() {
    let case = layout();
    let (world, body) = (case.world(), case.body());
    let idle = body.strain.iter().filter(|s| **s == 0.0).count();
    assert_eq!((idle, body.strain.len()), (88, 110));
    let planned = end(&case, &world, &body);
    assert_eq!(planned, end(&case, &world, &straining(&body)));
    // The robot must walk; otherwise there would be nothing to compare.
    assert!(farthest(&planned, &case.start) > 0.01);
}

/// The bits of gradients do not depend on whether a loss declares which nodes it observes. The cotangents of all other
/// nodes are zero in any case.
#[test]
fn nodes_that_a_loss_does_not_observe_change_no_bit() {
    /// The loss of the payload's displacement. If the flag is true, it declares that it observes only the payload.
    struct Far(Displacement, bool);
    impl Loss for Far {
        fn observed(&self, steps: usize) -> Vec<usize> {
            self.0.observed(steps)
        }
        fn nodes(&self) -> usize {
            if self.1 { 1 } else { usize::MAX }
        }
        fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
            assert_eq!(trajectory.states[0].x.len() == 1, self.1);
            self.0.loss(trajectory)
        }
    }
    let case = case("incline", |_| ());
    let world = case.world();
    let far = Displacement {
        ground: world.ground(),
        settings: LossSettings::default(),
    };
    let span = Span::of_steps(STEPS);
    let [payload, all] = [true, false].map(|alone| {
        let loss = Far(far.clone(), alone);
        case.inputs().differentiate(ALL, |inputs| {
            let design = case.projected(case.projection, &inputs.z);
            loss_of(&world, &inputs.robot(&world, &design), &loss, &span)
        })
    });
    assert_eq!(payload, all);
    assert!(payload.1.iter().any(|g| *g != 0.0));
}

/// In a robot without actuators, the controller has no outputs, so the rollout leaves out the network.
#[test]
fn a_robot_without_actuators_has_no_controller() {
    let case = layout();
    let (world, mut body) = (case.world(), case.body());
    body.strain.fill(0.0);
    let full = straining(&body);
    assert_eq!(end(&case, &world, &body), end(&case, &world, &full));
}

/// The gradient with respect to the weights agrees with the gradient of the full simulator except for rounding. It is a
/// sum of fewer terms, in another order.
#[test]
fn the_gradient_by_weights_is_that_of_the_full_simulator() {
    let case = layout();
    let (world, body) = (case.world(), case.body());
    let gradient = |body: &Body<f64>| {
        case.inputs()
            .differentiate(CONTROLLER, |inputs: &Inputs<_>| {
                let (body, controller) = (body.map(Real::lit), inputs.controller.clone());
                let robot = world.robot(body, controller, &inputs.start);
                let seen = world.run_one(&robot, &Span::of_steps(STEPS));
                seen.states[0].x[5].forward()
            })
    };
    let (value, some) = gradient(&body);
    let (full_value, all) = gradient(&straining(&body));
    assert_eq!(value, full_value);
    let largest = all.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
    assert!(largest > 0.0);
    for (a, b) in some.iter().zip(&all) {
        // Sums of a hundred terms are rounded in each of 256 steps. In that time, perturbations grow by less than a
        // factor of about two.
        assert!((a - b).abs() < 1e-11 * largest, "{a} {b}");
    }
}

/// A rollout changes only by rounding if controller inputs with a scale of 0 are left out: the sum of a hidden unit has
/// the same terms in another order.
#[test]
fn inputs_with_a_scale_of_zero_change_a_rollout_by_rounding_only() {
    let scales: [fn(&mut ControllerSettings) -> &mut f64; 2] =
        [|s| &mut s.offset_scale, |s| &mut s.velocity_scale];
    for scale in scales {
        let case = case("baseline_tall", |scene| *scale(&mut scene.controller) = 0.0);
        let mut full = case.scene.controller.clone();
        *scale(&mut full) = TINY;
        let full = (case.world()).with_physics(&case.scene.physics, &full);
        let body = case.body();
        let planned = end(&case, &case.world(), &body);
        let apart = farthest(&planned, &end(&case, &full, &body));
        // Activations differ by about 1e-16 in each of 256 steps, and the motion has contacts.
        assert!(apart < 1e-12, "{apart} m");
        assert!(farthest(&planned, &case.start) > 1e-3);
    }
}

/// Without ground, a robot moves as it does far above the ground.
#[test]
fn no_ground_is_equal_to_a_ground_out_of_reach() {
    let fall = |contact: ContactLaw, drop: f64| {
        let case = case("baseline_tall", |scene| {
            scene.physics.contact = contact;
            scene.lattice.drop = drop;
        });
        end(&case, &case.world(), &case.body())
    };
    // The robot falls for 0.5 s from a height of 4 m.
    let planned = fall(ContactLaw::none(), 4.0);
    for contact in [ContactLaw::infinite(), ContactLaw::coulomb()] {
        assert_eq!(planned, fall(contact.clone(), 4.0), "{contact:?}");
    }
    // In a world whose ground is in reach, the motion is different, so the test can fail.
    assert!(
        farthest(
            &fall(ContactLaw::none(), 0.0),
            &fall(ContactLaw::infinite(), 0.0)
        ) > 0.1
    );
}
