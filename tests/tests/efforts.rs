//! The efforts of bars in a rollout: their gradients, and what they agree with.

use autodiff::Real;
use autodiff::check::{Options, Verdict};
use cosmic::objective::Loss;
use cosmic::simulator::{Span, Trajectory};
use cosmic_lab::verify::check_gradients_of;
use cosmic_tests::{numbers, references, robot, workspace};

/// The integrators, each as settings in TOML.
const WORLDS: [&str; 4] = [
    "",
    "physics = {contact = 'coulomb', friction = 0.4, substeps = 2, integrator = 'leapfrog', forces = ['damper']}",
    "physics = {contact = 'coulomb', friction = 0.4, forces = ['actuator']}\nactuator = {force = 0.1, speed = 4.0}",
    "physics = {integrator = 'implicit', contact = 'coulomb', friction = 0.4, passes = 2, forces = ['damper']}",
];

/// A sum of all efforts: activations, forces and energy per mass.
struct Toil;

impl Loss for Toil {
    fn observed(&self, steps: usize) -> Vec<usize> {
        vec![steps / 2, steps]
    }

    fn reads_efforts(&self) -> bool {
        true
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        let efforts = trajectory.efforts.as_ref().expect("the loss reads efforts");
        let weighed = |numbers: &[R]| {
            let terms = numbers.iter().enumerate();
            let terms: Vec<R> = terms
                .map(|(k, &x)| x * R::lit(1.0 + 0.1 * k as f64))
                .collect();
            R::sum_of(&terms)
        };
        let all = efforts.of_states.iter().map(|effort| {
            let work = weighed(&effort.work) / R::sum_of(&efforts.body.mass);
            weighed(&effort.activation) + weighed(&effort.tension) + work
        });
        all.fold(R::zero(), |sum, toil| sum + toil)
    }
}

/// The gradients with respect to the design, the controller and the start agree in every mode.
#[test]
fn efforts_have_the_right_gradients() {
    for world in WORLDS {
        let check = check_gradients_of(&Toil, &robot(world), 24, &Options::default());
        assert!(!check.groups.is_empty());
        for group in &check.groups {
            let is_right = group.verdict == Verdict::Smooth;
            assert!(is_right, "{world}: {}, {}", group.name, group.report);
        }
    }
}

/// Efforts change no state. In an explicit step, the tension is that of the state before the step, and the work of a bar
/// is the sum of what it gives.
#[test]
fn efforts_are_those_of_the_states() {
    for world in &WORLDS[..3] {
        let case = robot(world);
        let (task, design) = (case.task(), case.own_design());
        let plain = Span::from_start((0..=40).collect());
        let metered = Span {
            metered: true,
            ..plain.clone()
        };
        let [plain, seen] = [plain, metered]
            .map(|span| task.rollout(&design, &case.controller, &case.start, &span));
        assert_eq!(plain.states, seen.states);
        assert!(plain.efforts.is_none());
        let moments = task.moments(&design, &case.controller, &plain);
        let mut given = vec![0.0; moments[0].tension.len()];
        let mut most = 0.0_f64;
        for (k, moment) in moments[..40].iter().enumerate() {
            let effort = seen.effort(k + 1);
            for (edge, sum) in given.iter_mut().enumerate() {
                if *world == WORLDS[1] {
                    continue;
                }
                let tension = moment.tension[edge];
                // Forces are sums of a few terms of at most 10 N, which are added in another order.
                assert!((effort.tension[edge] - tension).abs() < 1e-12);
                *sum += case.physics.dt * (-tension * moment.rate[edge]).max(0.0);
                assert!((effort.work[edge] - *sum).abs() < 1e-12);
                most = most.max(*sum);
            }
            // A bar never takes back what it has given.
            let before = &seen.effort(k).work;
            assert!(before.iter().zip(&effort.work).all(|(a, b)| a <= b));
        }
        assert!(*world == WORLDS[1] || most > 1e-6, "{most}");
    }
}

/// The forces and the energies of implicit steps are those of an independent program.
#[test]
fn efforts_of_implicit_steps_are_reproduced() {
    for reference in references(&workspace().join("tests/data/implicit")) {
        let case = reference.case();
        let span = Span {
            metered: true,
            ..Span::from_start(vec![case.physics.steps])
        };
        let run = (case.task()).rollout(&case.own_design(), &case.controller, &case.start, &span);
        let (effort, expected) = (run.effort(case.physics.steps), &reference.json["coverage"]);
        for (name, got) in [("tension_last", &effort.tension), ("work", &effort.work)] {
            reference.check(name, "forward", [got, &numbers(&expected[name])]);
        }
    }
}

/// In short steps, the forces that an implicit step uses are those of explicit steps.
#[test]
fn forces_of_implicit_steps_approach_those_of_explicit_ones() {
    let [explicit, implicit] = ["symplectic_euler", "implicit"].map(|integrator| {
        let case = robot(&format!(
            "physics = {{integrator = '{integrator}', dt = 2e-5, contact = 'coulomb', friction = 0.4, forces = ['damper']}}"
        ));
        let span = Span {
            metered: true,
            ..Span::from_start(vec![89, 90])
        };
        case.task()
            .rollout(&case.own_design(), &case.controller, &case.start, &span)
    });
    let size = |numbers: &[f64]| numbers.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let apart = |a: &[f64], b: &[f64]| -> f64 {
        let pairs: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        size(&pairs) / size(a)
    };
    // An implicit step takes the forces at its end. The fastest vibrations, at some 300 rad/s, change them by 0.6 % in a step.
    let tensions = [&explicit, &implicit].map(|seen| &seen.effort(90).tension);
    assert!(size(tensions[0]) > 0.1);
    assert!(apart(tensions[0], tensions[1]) < 0.02);
    // The work after 90 explicit steps has the powers at times 0 to 89 (at time 0 it is small), that after 89 implicit steps
    // those at times 1 to 89.
    assert!(apart(&explicit.effort(90).work, &implicit.effort(89).work) < 0.02);
}
