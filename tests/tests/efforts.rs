//! The efforts of bars in a rollout: their gradients, and what they agree with.

use autodiff::Real;
use autodiff::check::Verdict;
use cosmic::case::Case;
use cosmic::design::Material;
use cosmic::geometry::Vector;
use cosmic::objective::Loss;
use cosmic::simulator::{Span, Trajectory};
use cosmic_lab::check::check_gradients_of;
use cosmic_tests::{few_directions, numbers, references, robot, workspace};

/// The integrators, each as settings in TOML.
const WORLDS: [&str; 4] = [
    "",
    "physics = {contact = 'coulomb', friction = 0.4, substeps = 2, integrator = 'leapfrog', forces = ['damper']}",
    "physics = {contact = 'coulomb', friction = 0.4, forces = ['actuator']}\nactuator = {force = 0.1, speed = 4.0}",
    "physics = {integrator = 'implicit', contact = 'coulomb', friction = 0.4, forces = ['damper']}",
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
            let work = weighed(&effort.work) + weighed(&effort.net);
            let work = work / R::sum_of(&efforts.body.mass);
            weighed(&effort.activation) + weighed(&effort.tension) + work
        });
        all.fold(R::zero(), |sum, toil| sum + toil)
    }
}

/// The gradients with respect to the design, the controller and the start agree in every mode.
#[test]
fn efforts_have_the_right_gradients() {
    for world in WORLDS {
        let check = check_gradients_of(&Toil, &robot(world), 24, &few_directions());
        assert!(!check.groups.is_empty());
        for group in &check.groups {
            let is_right = group.verdict == Verdict::Smooth;
            assert!(is_right, "{world}: {}, {}", group.name, group.report);
        }
    }
}

/// Efforts change no state. In an explicit step, the tension is that of the state before the step, and a bar never takes
/// back what it has given.
#[test]
fn efforts_are_those_of_the_states() {
    for world in &WORLDS[..3] {
        let case = robot(world);
        let (simulator, body) = (case.task().simulator, case.body());
        let plain = Span::from_start((0..=40).collect());
        let metered = Span {
            metered: true,
            ..plain.clone()
        };
        let [plain, seen] = [plain, metered]
            .map(|span| simulator.rollout(&body, &case.controller, &case.start, &span));
        assert_eq!(plain.states, seen.states);
        assert!(plain.efforts.is_none());
        let moments = simulator.moments(&body, &case.controller, &plain);
        for (k, moment) in moments[..40].iter().enumerate() {
            let effort = seen.effort(k + 1);
            let pairs = effort.tension.iter().zip(&moment.tension);
            // Forces are sums of a few terms of at most 10 N, which are added in another order.
            let apart = pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
            assert!(apart < 1e-12 || *world == WORLDS[1]);
            let before = &seen.effort(k).work;
            assert!(before.iter().zip(&effort.work).all(|(a, b)| a <= b));
        }
        let given = seen.effort(40).work.iter().sum::<f64>();
        assert!(given > 1e-6, "{given}");
    }
}

/// The energy that a step brings to the nodes, J: by the bars, by gravity, by drag and by the ground, and the change of the
/// kinetic energy.
#[derive(Debug, Default)]
struct Budget {
    bars: f64,
    gravity: f64,
    drag: f64,
    ground: f64,
    kinetic: f64,
    /// The largest impulse of the ground, as a change of velocity, on a node in the air, m/s.
    in_air: f64,
}

/// The budget of the step after state `k`, in plain loops. `is_implicit` tells how nodes move in it.
fn budget(case: &Case, seen: &Trajectory<f64>, k: usize, is_implicit: bool) -> Budget {
    let (lattice, physics, body) = (&case.lattice, &case.scene.physics, case.body());
    let (dt, [before, after]) = (physics.dt, [&seen.states[k], &seen.states[k + 1]]);
    let decay = (-physics.damping * dt).exp();
    let (efforts, nodes) = ([seen.effort(k), seen.effort(k + 1)], 0..lattice.nodes());
    // The impulses of the bars. In an implicit step they act along the bars as they are at its end.
    let at = if is_implicit { after } else { before };
    let mut impulse = vec![Vector::<f64>::zero(); lattice.nodes()];
    for (edge, &[i, j]) in lattice.edges.iter().enumerate() {
        let d = at.x[j] - at.x[i];
        let length = (d.dot(d) + lattice.softening()).sqrt();
        let pull = d * (efforts[1].tension[edge] * dt / length);
        impulse[i] += pull;
        impulse[j] -= pull;
    }
    let sum = |numbers: &[f64]| numbers.iter().sum::<f64>();
    let mut budget = Budget {
        bars: sum(&efforts[1].net) - sum(&efforts[0].net),
        ..Budget::default()
    };
    for node in nodes {
        let (mass, v, end) = (body.mass[node], before.v[node], after.v[node]);
        let (drag, gravity) = (
            v * (decay - 1.0),
            Vector::from([0.0, -physics.gravity * dt]),
        );
        let free = v + drag + gravity + impulse[node] * (1.0 / mass);
        // The velocity after the push: explicit steps ask the ground later, implicit ones during the push.
        let pushed = match is_implicit {
            true => (after.x[node] - before.x[node]) * (1.0 / dt),
            false => free,
        };
        let mean = (v + pushed) * 0.5;
        budget.gravity += mass * gravity.dot(mean);
        budget.drag += mass * drag.dot(mean);
        budget.ground += mass * (pushed - free).dot(mean);
        budget.ground += 0.5 * mass * (end.dot(end) - pushed.dot(pushed));
        budget.kinetic += 0.5 * mass * (end.dot(end) - v.dot(v));
        if after.x[node].up() > 1e-6 {
            let by_ground = (pushed - free).norm() + (end - pushed).norm();
            budget.in_air = budget.in_air.max(by_ground);
        }
    }
    budget
}

/// The work of the bars (actuators and skeleton), of gravity, of drag and of the ground is the change of the kinetic energy,
/// in explicit and in implicit steps. The ground acts on no node in the air, and takes energy.
#[test]
fn the_energy_of_a_step_is_accounted_for() {
    let laws = "contact = 'coulomb', friction = 0.4, damping = 2.0, forces = ['damper', 'stops', 'actuator']";
    let more = "actuator = {force = 0.1, speed = 4.0}\nstops = {at = 0.1, stiffness = 100.0}";
    for (integrator, is_implicit, tolerance) in [
        // Energies are some 0.1 J with 16 digits, and a step takes some ms.
        ("integrator = 'symplectic_euler'", false, 1e-9),
        // A step tells tensions, but not the directions in which its last pass applied them. They approach those at its end;
        // after 16 passes, the independent program comes within 1e-4. With its own impulses its budget closes to 1e-13 W.
        ("integrator = 'implicit'", true, 1e-3),
    ] {
        let mut case = robot(&format!("physics = {{{integrator}, {laws}}}\n{more}"));
        case.scene.physics.passes = 16;
        let steps = case.scene.physics.steps;
        let seen = metered(&case, steps);
        let (mut lost, mut moved) = (0.0, 0.0_f64);
        for k in 0..steps {
            let all = budget(&case, &seen, k, is_implicit);
            let brought = all.bars + all.gravity + all.drag + all.ground;
            let off = (brought - all.kinetic) / case.scene.physics.dt;
            assert!(
                off.abs() < tolerance,
                "{integrator}, step {k}: {off:e} W, {all:?}"
            );
            assert!(
                all.in_air < 10.0 * tolerance,
                "{integrator}, step {k}: {all:?}"
            );
            lost += all.ground;
            moved = moved.max(all.bars.abs());
        }
        assert!(lost < -1e-6 && moved > 1e-6, "{lost} J, {moved} J");
    }
}

/// A rollout from the start that is observed and metered in every step.
fn metered(case: &Case, steps: usize) -> Trajectory<f64> {
    let span = Span {
        metered: true,
        ..Span::from_start((0..=steps).collect())
    };
    (case.task().simulator).rollout(&case.body(), &case.controller, &case.start, &span)
}

/// The power of a robot is the work that its steps record, by the time.
#[test]
fn powers_are_those_of_the_steps() {
    for world in WORLDS {
        let case = robot(world);
        let (steps, task) = (60, case.task());
        let seen = metered(&case, steps);
        let body = case.body();
        let layout: Vec<Material> = (0..body.strain.len())
            .map(|edge| {
                if edge % 3 == 0 {
                    Material::Actuator
                } else {
                    Material::Skeleton
                }
            })
            .collect();
        let (simulator, materials) = (&task.simulator, &case.scene.materials);
        let bars = simulator.loads(&layout, &body, &case.controller, &case.start, steps);
        let energy = simulator.energy_of(&layout, &bars, &body, materials, steps, 0.5);
        let of_actuators = |numbers: &[f64]| numbers.iter().step_by(3).sum::<f64>();
        let (last, seconds) = (seen.effort(steps), steps as f64 * case.scene.physics.dt);
        for (found, work) in [(energy.power, &last.work), (energy.net_power, &last.net)] {
            // Works are summed in another order.
            assert!(
                (found - of_actuators(work) / seconds).abs() < 1e-12,
                "{world}: {energy:?}"
            );
        }
        assert!(energy.power > energy.net_power);
        let per_metre = energy.power * seconds / 0.5;
        // Two roundings in another order.
        assert!((energy.per_metre.unwrap() / per_metre - 1.0).abs() < 1e-15);
        let weight = energy.mass * case.scene.physics.gravity;
        assert!((energy.cost_of_transport.unwrap() * weight / per_metre - 1.0).abs() < 1e-14);
        let still = simulator.energy_of(&layout, &bars, &body, materials, steps, 1e-3);
        assert_eq!((still.per_metre, still.cost_of_transport), (None, None));
        for (edge, bar) in bars.iter().enumerate() {
            let bar = bar.as_ref().expect("a solid bar");
            let [i, j] = case.lattice.edges[edge];
            let length = |k: usize| {
                let d = seen.states[k].x[j] - seen.states[k].x[i];
                (d.dot(d) + case.lattice.softening()).sqrt()
            };
            let net = |k: usize| seen.effort(k).net[edge];
            let (mut travel, mut force, mut power) = (0.0, 0.0_f64, 0.0_f64);
            for k in 0..steps {
                travel += (length(k + 1) - length(k)).abs();
                force = force.max(seen.effort(k + 1).tension[edge].abs());
                power = power.max((net(k + 1) - net(k)).abs() / case.scene.physics.dt);
            }
            assert!((bar.travel - travel / seconds).abs() < 1e-12);
            assert_eq!(bar.force.peak, force);
            // The powers are differences of sums, which are added in another order.
            assert!((bar.power.peak - power).abs() < 1e-11);
        }
    }
}

/// The forces and the energies of implicit steps are those of an independent program.
#[test]
fn efforts_of_implicit_steps_are_reproduced() {
    for reference in references(&workspace().join("tests/data/implicit")) {
        let case = reference.case();
        let span = Span {
            metered: true,
            ..Span::from_start(vec![case.scene.physics.steps])
        };
        let run =
            (case.task().simulator).rollout(&case.body(), &case.controller, &case.start, &span);
        let (effort, expected) = (
            run.effort(case.scene.physics.steps),
            &reference.json["coverage"],
        );
        for (name, got) in [
            ("tension_last", &effort.tension),
            ("work", &effort.work),
            ("net", &effort.net),
        ] {
            reference.check(name, "forward", [got, &numbers(&expected[name])]);
        }
    }
}
