use crate::small::small;
use autodiff::Real;
use autodiff::check::{Claim, Options, Verdict, check_directions};
use cosmic::Registry;
use cosmic::case::Case;
use cosmic::kernel;
use cosmic::laws::{Bar, BarForce, ContactLaw, ForceLaws, Law, on_bars};
use cosmic::scene::{Integrator, Scene};
use cosmic_lab::check::gradient::{Perturbation, is_rounding};
use cosmic_lab::check::{GradientCheck, check_gradients};

cosmic::settings! {
    /// Springs that grow stiffer as they are stretched or compressed.
    struct Stiffening {}
}

impl Law for Stiffening {
    const NAME: &'static str = "stiffening";
}

#[kernel]
impl BarForce for Stiffening {
    fn tension<R: Real>(_: &Self, bar: Bar<R>) -> R {
        R::lit(80.0) * bar.stiffness * (bar.length - bar.target).powi(3)
    }
}

fn stiffening() -> ForceLaws {
    let registry = Registry::default().with_law(on_bars::<Stiffening>());
    let scene = registry.parse("stiffening", "physics.forces = ['stiffening']");
    scene.unwrap().physics.forces
}

/// Checks the gradients of a case, and asserts that there are no failures.
fn passed(case: &Case, steps: usize) -> GradientCheck {
    let check = check_gradients(case, None, steps, &Options::default());
    assert!(check.failures().is_empty(), "{check}");
    check
}

#[test]
fn wrong_groups_and_accepted_controls_are_failures() {
    let mut check = passed(&small([2, 2], |_| ()), 32);
    assert_eq!((check.steps, check.total()), (32, 8));
    check.groups[2].verdict = Verdict::Wrong;
    check.groups[5].verdict = Verdict::Kink;
    check.control.as_mut().unwrap().verdict = Verdict::Smooth;
    check.groups[0].norm = 0.0;
    let failures = [
        "z (nothing could be compared)",
        "b1 (wrong gradient)",
        "the negative control (accepted)",
    ];
    assert_eq!(check.failures(), failures);
    check.control = None;
    let control = "the negative control (nothing could be compared)";
    assert_eq!(check.failures()[2], control);
}

/// The feet of a robot on rough ground stick, so at first its payload does not move, whatever its design and controller
/// are. Its gradient is checked in flight.
#[test]
fn a_robot_without_a_gradient_is_thrown() {
    let sticks = &small([3, 2], |scene| {
        scene.physics.contact = ContactLaw::coulomb();
        (scene.physics.friction, scene.physics.gravity) = (1.0, 9.81);
        (scene.controller.hidden, scene.controller.gain) = (4, [0.1, 0.1]);
    });
    let check = passed(sticks, 64);
    assert_eq!(check.perturbation, Perturbation::Thrown, "{check}");
    assert!(check.still.iter().any(|name| name == "w1"), "{check}");
    // Without a second layer, the first layer has no effect. Then the controller is drawn too.
    let mut mute = sticks.clone();
    mute.controller.block_mut("w2").fill(0.0);
    assert_eq!(passed(&mute, 64).perturbation, Perturbation::Driven);
}

/// Slopes that are smaller than the rounding error of the displacement are not called wrong. A controller hardly moves a
/// slack robot, so nothing can be compared there. The fall of a robot whose actuators have no stroke depends on its design
/// only in the last digits, which differences in double-double may still see.
#[test]
fn slopes_below_the_displacement_s_rounding_do_not_fail() {
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
        let check = check_gradients(case, None, steps, &Options::default());
        assert!(
            check.groups.iter().all(|g| g.verdict != Verdict::Wrong),
            "{check}"
        );
        if std::ptr::eq(case, slack) {
            let empty = format!("{} (nothing could be compared)", check.groups[group].name);
            assert!(check.failures().contains(&empty), "{check}");
        }
        let norm = check.groups[group].norm;
        assert!(0.0 < norm && norm < most, "{check}");
        let control = check.control.as_ref().map(|c| (&c.group[..], c.verdict));
        let of = |group| Some((group, Verdict::Wrong));
        let is_seen = !std::ptr::eq(case, slack) && control == of("z");
        assert!(is_seen || control == of("x0"), "{check}");
    }
}

#[test]
fn an_infinite_slope_is_not_explained_by_rounding() {
    let claim = Claim {
        x: &[1.0],
        gradient: &[2.0],
        forward: Some(&|_: &[f64]| f64::INFINITY),
    };
    let report = check_directions(|x| x[0] + x[0], &claim, &Options::default());
    assert!(!is_rounding(&report, 2.0, 1e-5), "{report}");
}

/// If nodes are light and strains are large, a change of the start grows beyond the range of floats. The check of such
/// a robot is inconclusive; it must not call the gradient wrong.
#[test]
fn slopes_that_consist_of_rounding_are_not_called_wrong() {
    let case = small([3, 3], |scene| {
        scene.lattice.drop = 0.01;
        (scene.physics.node_mass, scene.physics.payload_mass) = (1e-4, 0.0);
        scene.physics.damping = 5.0;
        scene.physics.forces = stiffening();
        (scene.physics.contact, scene.physics.friction) = (ContactLaw::coulomb(), 0.0);
        scene.materials.max_strain = [0.0, 0.0, 0.7];
        (scene.controller.hidden, scene.controller.gain) = (4, [6.0, 6.0]);
        scene.controller.velocity_scale = 0.5;
    });
    let check = check_gradients(&case, None, 200, &Options::default());
    assert!(
        check.groups.iter().all(|g| g.verdict != Verdict::Wrong),
        "{check}"
    );
    let warns = check.to_string().contains("use fewer --steps");
    assert!(check.rounding > 1.0 && warns, "{check}");
    let check = passed(&case, 32);
    assert!(check.rounding < 1e-6 && check.control.is_some(), "{check}");
}

/// At the limit of its force, an actuator has a kink at rest. The gradient with respect to the velocities is then checked for a
/// robot that moves.
#[test]
fn actuators_at_rest_are_moved_off_their_kinks() {
    for integrator in [Integrator::SymplecticEuler, Integrator::Implicit] {
        let check = passed(
            &small([2, 2], |scene| {
                let actuator = [
                    "physics.forces = ['actuator']",
                    "actuator.force = 0.02",
                    "actuator.speed = 0.2",
                ];
                *scene = scene.set(&actuator).unwrap();
                scene.physics.integrator = integrator;
            }),
            32,
        );
        let moving = check.groups.iter().filter(|group| group.moving);
        let moving: Vec<&str> = moving.map(|group| &group.name[..]).collect();
        assert_eq!(moving, ["v0"], "{check}");
        assert!(
            check
                .to_string()
                .contains("v0: at rest the force of the law `actuator` has a kink")
        );
    }
}

/// If a robot stands on the ground, the loss has a kink with respect to the positions. With leapfrog or without
/// gravity, it also has one with respect to the velocities. Without ground there is no kink.
#[test]
fn robots_that_stand_are_lifted_off_their_kinks() {
    type Change = fn(&mut Scene);
    let leapfrog: Change = |s| s.physics.integrator = Integrator::Leapfrog;
    let substeps: Change = |s| {
        (s.physics.integrator, s.physics.substeps) = (Integrator::Leapfrog, 2);
        s.physics.contact = ContactLaw::coulomb();
    };
    // If nodes start below the ground line, the loss has a kink only with respect to the velocities.
    let sunk: Change = |s| {
        (s.physics.integrator, s.lattice.drop) = (Integrator::Leapfrog, -0.003);
    };
    let cases: [(Change, &[&str]); 6] = [
        (|_| (), &["x0"]),
        (leapfrog, &["x0", "v0"]),
        (substeps, &["x0", "v0"]),
        (|s| s.physics.gravity = 0.0, &["x0", "v0"]),
        (sunk, &["v0"]),
        (|s| s.physics.contact = ContactLaw::none(), &[]),
    ];
    for (change, expected) in cases {
        let check = passed(&small([2, 2], change), 32);
        let lifted = check.groups.iter().filter(|group| group.lifted);
        let lifted: Vec<&str> = lifted.map(|group| &group.name[..]).collect();
        assert_eq!(lifted, expected);
    }
}
