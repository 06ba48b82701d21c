//! The efforts of bars in a rollout: their gradients, and what they agree with.

use autodiff::Real;
use autodiff::check::Verdict;
use cosmic::case::Case;
use cosmic::design::{Design, Material};
use cosmic::geometry::Vector;
use cosmic::objective::Loss;
use cosmic::walk::{self, Energy};
use cosmic::world::{Span, Trajectory};
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
    for settings in &WORLDS[..3] {
        let case = robot(settings);
        let (world, robot) = (case.world(), case.robot());
        let plain = Span::from_start((0..=40).collect());
        let metered = Span {
            metered: true,
            ..plain.clone()
        };
        let [plain, seen] = [plain, metered].map(|span| world.run_one(&robot, &span));
        assert_eq!(plain.states, seen.states);
        assert!(plain.efforts.is_none());
        let moments = walk::moments(&world, &robot, &plain);
        for (k, moment) in moments[..40].iter().enumerate() {
            let effort = seen.effort(k + 1);
            let pairs = effort.tension.iter().zip(&moment.tension);
            // Forces are sums of a few terms of at most 10 N, which are added in another order.
            let apart = pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
            assert!(apart < 1e-12 || *settings == WORLDS[1]);
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
    case.world().run_one(&case.robot(), &span)
}

/// Skeleton, and an actuator in every third edge.
fn layout(case: &Case) -> Vec<Material> {
    let material = |edge| match edge % 3 {
        0 => Material::Actuator,
        _ => Material::Skeleton,
    };
    (0..case.lattice.edges.len()).map(material).collect()
}

/// The work of a bar in a step is the trapezoid of its force and its length. The power of a robot is the work of its
/// actuators, by the time.
#[test]
fn powers_are_trapezoids_of_force_and_length() {
    for settings in WORLDS {
        let case = robot(settings);
        let (steps, world, layout) = (60, case.world(), layout(&case));
        let (robot, seen) = (case.robot(), metered(&case, steps));
        let bars = walk::bar_loads(&world, &layout, &robot, &Span::of_steps(steps));
        let energy = Energy::of(&world, &layout, &bars, &robot.body, steps, 0.5);
        let moments = walk::moments(&world, &robot, &seen);
        let seconds = steps as f64 * case.scene.physics.dt;
        let (mut given, mut net) = (0.0, 0.0);
        for (edge, bar) in bars.iter().enumerate() {
            let bar = bar.as_ref().expect("a solid bar");
            let [i, j] = case.lattice.edges[edge];
            let length = |k: usize| {
                let d = seen.states[k].x[j] - seen.states[k].x[i];
                (d.dot(d) + case.lattice.softening()).sqrt()
            };
            // An implicit step uses forces that are not those of its states.
            let pull = |k: usize| match settings.contains("implicit") && k > 0 {
                true => seen.effort(k).tension[edge],
                false => moments[k].tension[edge],
            };
            let work = |k: usize| -0.5 * (pull(k) + pull(k + 1)) * (length(k + 1) - length(k));
            let works: Vec<f64> = (0..steps).map(work).collect();
            let sum =
                |of: fn(f64) -> f64| works.iter().map(|work| of(*work)).sum::<f64>() / seconds;
            let (own_given, own_net) = (sum(|work| work.max(0.0)), sum(|work| work));
            // Forces and lengths are those of the loads up to the order of sums.
            assert!((bar.given - own_given).abs() < 1e-11, "{settings}: {bar:?}");
            assert!((bar.net - own_net).abs() < 1e-11, "{settings}: {bar:?}");
            if edge % 3 == 0 {
                (given, net) = (given + own_given, net + own_net);
            }
            let (mut travel, mut force, mut power) = (0.0, 0.0_f64, 0.0_f64);
            for k in 0..steps {
                travel += (length(k + 1) - length(k)).abs();
                force = force.max(seen.effort(k + 1).tension[edge].abs());
                power = power.max(works[k].abs() / case.scene.physics.dt);
            }
            assert!((bar.travel - travel / seconds).abs() < 1e-12);
            assert_eq!(bar.force.peak, force);
            assert!(
                (bar.power.peak - power).abs() < 1e-9,
                "{settings}: {power} {bar:?}"
            );
        }
        let both = [(energy.power, given), (energy.net_power, net)];
        assert!(
            both.iter().all(|(a, b)| (a - b).abs() < 1e-10),
            "{settings}: {energy:?}"
        );
        assert!(energy.power > energy.net_power);
        let per_metre = energy.power * seconds / 0.5;
        // Two roundings in another order.
        assert!((energy.per_metre.unwrap() / per_metre - 1.0).abs() < 1e-15);
        let weight = energy.mass * case.scene.physics.gravity;
        assert!((energy.cost_of_transport.unwrap() * weight / per_metre - 1.0).abs() < 1e-14);
        let still = Energy::of(&world, &layout, &bars, &robot.body, steps, 1e-3);
        assert_eq!((still.per_metre, still.cost_of_transport), (None, None));
    }
}

/// The work of a skeleton that only dampens, J, and of its actuators, in 0.18 s with a step of 2 ms divided by `finer`: by
/// the trapezoids, and by the energies that close the budget of the discrete steps.
fn works(integrator: &str, finer: usize) -> [[f64; 2]; 2] {
    let mut case = robot(&format!(
        "physics = {{dt = 0.002, integrator = '{integrator}', contact = 'coulomb', friction = 0.8, damping = 0.0, \
         forces = ['damper']}}"
    ));
    case.scene.physics.dt /= finer as f64;
    case.scene.physics.steps *= finer;
    let layout = layout(&case);
    case.design = Design::Layout(layout.clone());
    let (steps, seconds) = (case.scene.physics.steps, 0.18);
    let span = Span::of_steps(steps);
    let loads = walk::bar_loads(&case.world(), &layout, &case.robot(), &span);
    let budget = metered(&case, steps);
    let sum = |of: &dyn Fn(usize) -> f64| {
        let of_material = |material| {
            let edges = (0..layout.len()).filter(|edge| layout[*edge] == material);
            edges.map(of).sum::<f64>()
        };
        [Material::Skeleton, Material::Actuator].map(of_material)
    };
    [
        sum(&|edge| seconds * loads[edge].as_ref().expect("a solid bar").net),
        sum(&|edge| budget.effort(steps).net[edge]),
    ]
}

/// A skeleton that only dampens takes energy. At the step of a scene its work is close to the limit for small steps; the
/// energies that close the budget of the discrete steps are not.
#[test]
fn a_damped_skeleton_gives_no_energy() {
    let apart = |a: f64, b: f64| (a / b - 1.0).abs();
    let [explicit, leapfrog, implicit] =
        ["symplectic_euler", "leapfrog", "implicit"].map(|integrator| {
            let all = [1, 2, 4, 8].map(|finer| works(integrator, finer));
            for (k, [[skeleton, actuators], _]) in all.iter().enumerate() {
                assert!(
                    *skeleton < 0.0 && *actuators > 0.0,
                    "{integrator}, {k}: {all:?}"
                );
            }
            all
        });
    // Numbers were 1.9 % and 18 % off for the skeleton, 2.0 % and 5.3 % for the actuators.
    let [[limit, of_actuators], _] = explicit[3];
    let [trapezoid, budget] = explicit[0];
    assert!(apart(trapezoid[0], limit) < 0.04 && apart(budget[0], limit) > 0.1);
    assert!(apart(trapezoid[1], of_actuators) < 0.03 && apart(budget[1], of_actuators) > 0.04);
    // Both integrators approach the same limit: 2.3 % apart.
    assert!(apart(leapfrog[3][0][0], limit) < 0.05);
    // The implicit step itself takes energy from the motion, at 2 ms more than half of the work of the skeleton. The work
    // of the actuators was 8 % off, and by the budget 40 %.
    let [trapezoid, budget] = implicit[0];
    assert!(apart(trapezoid[1], of_actuators) < 0.15 && apart(budget[1], of_actuators) > 0.3);
    assert!(apart(implicit[3][0][0], limit) < 0.05);
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
        let run = case.world().run_one(&case.robot(), &span);
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
