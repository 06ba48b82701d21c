//! The check of a time step compares it first with a cheap bound, and only if that fails with the largest frequency.

use cosmic::case::Case;
use cosmic::design::Design;
use cosmic::geometry::Vector;
use cosmic::lattice::Body;
use cosmic::laws::{ContactLaw, Damper};
use cosmic::scene::{AnyDesign, Integrator, Scene, UnstableStep, stable_step};
use cosmic::search::CoDesign;
use cosmic::walk;
use cosmic::world::stability::Vibration;
use cosmic::world::{Grade, Span, StepCheck};
use cosmic_tests::laws;

fn scene(dt: f64) -> Scene {
    let mut scene = Scene::paper();
    (scene.lattice.columns, scene.lattice.rows) = (3, 2);
    scene.controller.hidden = 2;
    scene.physics.dt = dt;
    scene
}

fn case(scene: &Scene) -> Case {
    Case::of_scene(scene, 0).expect("any lattice starts so")
}

fn check(dt: f64) -> StepCheck {
    case(&scene(dt)).step_check()
}

#[test]
fn a_step_is_compared_with_the_bound_and_beyond_it_with_the_frequency() {
    let loose = check(1.0);
    let exact = loose.exact.expect("a second is beyond any bound");
    let physics = scene(1.0).physics;
    let [limit, bound] = [exact, loose.bound].map(|l| stable_step(&physics, l.frequency, 0.0));
    assert!(bound < limit && limit < 1.5 * bound, "{bound} {limit}");
    let [safe, close, unstable] = [0.99 * bound, 0.5 * (bound + limit), 1.01 * limit].map(check);
    let grades = [safe, close, unstable].map(|check| check.grade());
    assert_eq!(grades, [Grade::Safe, Grade::Close, Grade::Unstable]);
    assert!(safe.exact.is_none() && safe.to_string().is_empty());
    let node = format!("node {}", loose.bound.node);
    for word in ["safe bound", &node, "physics.dt"] {
        assert!(close.to_string().contains(word), "{close}");
    }
    // A time step between these two limits is stable for the start, but may be unstable for other designs.
    let any = safe.any_design.expect("it vibrates");
    assert!(any < bound, "{any} {bound}");
    assert_eq!(check(0.002).of_other_designs(), None);
    let between = check(0.5 * (any + bound));
    assert_eq!(between.grade(), Grade::Safe);
    let said = between.of_other_designs().expect("it is longer");
    assert!(
        said.contains("to be safe for every design, set physics.dt below"),
        "{said}"
    );
    // If nothing vibrates, any step is safe.
    let mut scene = scene(1.0);
    scene.materials.stiffness = [0.0; 3];
    let check = case(&scene).step_check();
    assert_eq!((check.grade(), check.bound.dt), (Grade::Safe, None));
}

#[test]
fn an_unstable_step_is_refused_with_its_node_and_a_remedy_that_works() {
    let (scene, unstable) = (scene(0.05), check(0.05));
    let refused = unstable.accept(&scene.physics);
    let refused = refused.expect_err("50 ms are too long");
    assert_eq!(refused.exit_code(), 2);
    let said = refused.to_string();
    let node = unstable.exact.expect("it is beyond the bound").node;
    let node = format!("node {node}");
    for word in [
        "0.05 s",
        "physics.dt",
        "unstable_step = \"warn\"",
        "1/s",
        &node,
    ] {
        assert!(said.contains(word), "{said}");
    }
    let mut patient = scene.physics;
    patient.unstable_step = UnstableStep::Warn;
    assert!(unstable.accept(&patient).is_ok());
    // If the scene only asks for a warning, the message does not say how to continue.
    let warned = said.split_once("; to continue").map(|(warned, _)| warned);
    assert_eq!(warned, Some(&*unstable.to_string()));
    let (_, rest) = said.split_once("physics.dt to ").expect("a remedy");
    let dt = rest
        .split(' ')
        .next()
        .and_then(|number| number.parse().ok());
    assert_eq!(check(dt.expect("a number")).grade(), Grade::Safe);
}

/// The shares of a test design with the number `design`. In design 0, all edges except the first are void. The other
/// even numbers are layouts, and the odd numbers are mixtures.
fn design(design: usize, edges: usize) -> Vec<[f64; 3]> {
    let one_hot = |chosen: usize| std::array::from_fn(|k| f64::from(u8::from(k == chosen)));
    let share = |e: usize| {
        if design == 0 {
            return one_hot(usize::from(e == 0));
        }
        if design.is_multiple_of(2) {
            return one_hot((e * e + design * e + e / 3) % 3);
        }
        let wave = |w: f64| (w * (e + design) as f64).sin().powi(2) + 1e-3;
        let shares = [1.0, 2.3, 3.1].map(wave);
        shares.map(|share| share / shares.iter().sum::<f64>())
    };
    (0..edges).map(share).collect()
}

/// The points, each moved along each axis by up to 0.02 m.
fn shaken(points: &[Vector<f64>]) -> Vec<Vector<f64>> {
    let off = |n: usize| 0.02 * (2.7 * n as f64).sin();
    let moved = |(i, &x): (usize, &Vector<f64>)| x + Vector::from([off(2 * i), off(2 * i + 1)]);
    points.iter().enumerate().map(moved).collect()
}

/// Bars of glass and actuators with a mass of their own.
const PARTS: &str = "parts = {skeleton = 'rod', material = 'glass', outer = 0.002, joint = 1e4, end_mass = 0.001, actuator = \
                     'device', stroke = 0.1}";

/// No layout or mixture vibrates faster than the bound that holds for every design, and none has a shorter stable step.
/// This is tested on small and large lattices with damped bars, with laws of example programs (springs that grow stiffer and
/// bars that resist bending), and parts whose stiffness depends on their length. A single stiff bar comes near the bound.
#[test]
fn no_design_vibrates_faster_than_the_bound_of_any() {
    let worlds = [
        "",
        PARTS,
        "bending.radius = 0.02",
        "bending.radius = 0.2",
        "stiffening.cubic = 200",
        "bending.radius = 0.1\nstiffening.cubic = 1e5",
    ];
    let mut nearest: f64 = 0.0;
    for (columns, rows) in [(2, 2), (1, 3), (6, 6), (4, 3)] {
        for world in worlds {
            let examples = ["bending", "stiffening"];
            let mut forces = vec!["damper"];
            forces.extend(examples.iter().filter(|law| world.contains(**law)));
            let mut scene = laws::scene(&format!("physics.forces = {forces:?}\n{world}"));
            (scene.lattice.columns, scene.lattice.rows) = (columns, rows);
            let case = case(&scene);
            let (lattice, physics) = (&case.lattice, &case.scene.physics);
            let any = AnyDesign::new(lattice, &case.scene.materials, physics);
            let (bound, stable) = (any.frequency(), any.stable_step(1.0));
            // The factor allows for rounding and for the softening, which adds 1e-12 to squared lengths of 1e-2.
            let slack = 1.0 + 1e-9;
            for k in 0..12 {
                let design = Design::of_shares(&design(k, lattice.edges.len()));
                let body = Body::new(&design, lattice, &case.scene.materials, physics);
                let vibration = |x: &[Vector<f64>]| {
                    let vibration = Vibration::new(lattice, &body, physics, x);
                    [vibration.edge_bound().0, vibration.fastest().0]
                };
                // Once the lattice is at rest, and once its nodes are moved by up to a fifth of the spacing.
                let [own, fastest] = vibration(&lattice.positions);
                let [own_off, fastest_off] = vibration(&shaken(&lattice.positions));
                assert!(
                    fastest <= own * slack,
                    "the frequency {fastest} is above its bound {own}"
                );
                assert!(
                    fastest_off <= own_off * slack,
                    "{fastest_off} above {own_off}"
                );
                assert!(
                    own <= bound * slack,
                    "the bound {own} of this design is above the bound {bound} of any design"
                );
                if forces.len() == 1 {
                    nearest = nearest.max(fastest / bound);
                    // The damper makes a vibration of frequency w decay at the rate `time w^2`.
                    let rate = Damper::default().time * fastest * fastest;
                    let limit = stable_step(physics, fastest, rate);
                    assert!(stable <= limit * slack, "{stable} above {limit}");
                    // Two nodes that vibrate against each other reach the bound. The frequencies of a chain of many
                    // nodes are about a third below the bound.
                    assert!(
                        own_off < 1.6 * fastest_off,
                        "{own_off} far from {fastest_off}"
                    );
                }
            }
        }
    }
    assert!(
        nearest > 0.9,
        "no design comes near the bound of any design: {nearest} of it"
    );
}

/// An optimisation refuses an unstable start, unless the scene allows it. If a later design becomes unstable because
/// its edges become stiff, the record of the iteration shows it.
#[test]
fn unstable_starts_are_refused_and_unstable_designs_are_in_the_record() {
    let mut scene = scene(0.05);
    scene.physics.steps = 16;
    scene.schedule.horizon = [16, 16];
    (scene.loss.window, scene.loss.every) = (8, 4);
    let begin = |scene: &Scene| CoDesign::new(scene).and_then(|c| c.begin(0));
    let refused = begin(&scene).expect_err("50 ms are too long");
    assert_eq!(refused.exit_code(), 2);
    scene.physics.unstable_step = UnstableStep::Warn;
    assert!(begin(&scene).is_ok());

    scene.physics.unstable_step = UnstableStep::Error;
    scene.physics.dt = 0.002;
    scene.schedule.iterations = 4;
    (scene.schedule.attraction_from, scene.schedule.snap_at) = (2, 2);
    scene.volume.solid = [1.0, 1.0];
    scene.volume.actuator = [0.0, 0.0];
    let codesign = CoDesign::new(&scene).expect("a plan");
    let start = codesign.begin(0).expect("2 ms are stable");
    let frequency = codesign.step_check(&start).bound.frequency;
    // The snap turns mixtures of three equal shares into a layout of skeleton only. This raises the frequency by more
    // than the factor 1 / 0.7.
    scene.physics.dt = 0.7 * stable_step(&scene.physics, frequency, 0.0);
    let mut shares = Vec::new();
    let mut codesign = CoDesign::new(&scene).expect("a plan");
    let told = codesign.optimise(0, |record| {
        let check = record.time_step.expect("every iteration is checked");
        shares.push(check.bound.share(check.dt));
    });
    let said = told
        .expect_err("the snap makes it all skeleton")
        .to_string();
    assert!(said.contains("unstable"), "{said}");
    let [first, .., last] = shares[..] else {
        panic!("the first iteration changes little: {shares:?}")
    };
    assert!(first < 1.0 && last > 1.0, "{shares:?}");
}

/// An implicit step solves for the forces along bars only. So bars that resist bending limit the time step: in
/// free flight a robot keeps its speed below the limit, with one pass and with several, and not far beyond it.
#[test]
fn bending_limits_an_implicit_step() {
    let speed = |passes: usize, share: f64| {
        let mut scene = scene(0.002);
        scene.lattice.columns = 4;
        let physics = &mut scene.physics;
        (physics.integrator, physics.passes) = (Integrator::Implicit, passes);
        (physics.gravity, physics.damping, physics.contact) = (0.0, 0.0, ContactLaw::none());
        physics.forces = laws::forces("physics.forces = ['bending']\nbending.radius = 0.2");
        scene.materials.max_strain = [0.0; 3];
        let mut case = case(&scene);
        case.start.x = shaken(&case.start.x);
        let limit = case.step_check().bound.dt.expect("its bars bend");
        case.scene.physics.dt = share * limit;
        let safe = case.step_check().grade() == Grade::Safe;
        assert_eq!(safe, share < 1.0);
        let span = Span::from_start((0..=400).collect());
        let run = walk::guarded(&case.world(), &case.robot(), &span);
        let speeds = run.trajectory.states.iter().flat_map(|state| &state.v);
        speeds.map(|v| v.norm()).fold(0.0, f64::max)
    };
    for passes in [1, 2, 3] {
        // The bound is above the largest frequency, by less than the factor of the longer step. Bent bars are softer, so the
        // speed does not grow without limit.
        let [below, beyond] = [0.95, 3.6].map(|share| speed(passes, share));
        assert!(
            beyond > 4.0 * below,
            "{passes} passes: {below} {beyond} m/s"
        );
    }
}
