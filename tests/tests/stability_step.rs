//! The check of a time step: the bound first, then the largest frequency.

use cosmic::case::Case;
use cosmic::codesign::CoDesign;
use cosmic::design::{Design, Material};
use cosmic::lattice::Body;
use cosmic::scene::{Scene, UnstableStep};
use cosmic::simulator::stability::{Vibration, bound_of_any_design, step_limit};
use cosmic::simulator::{Grade, StepCheck};
use cosmic_lab::verify::stable_steps;

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
fn a_step_is_held_against_the_bound_and_beyond_it_against_the_frequency() {
    let loose = check(1.0);
    let exact = loose.exact.expect("a second is beyond any bound");
    let [limit, bound] = [exact, loose.bound].map(|l| step_limit(l.frequency, 20.0, 0.0));
    assert!(bound < limit && limit < 1.5 * bound, "{bound} {limit}");
    let grade = |dt: f64| check(dt).grade();
    assert_eq!(grade(0.99 * bound), Grade::Safe);
    assert_eq!(grade(0.5 * (bound + limit)), Grade::Close);
    assert_eq!(grade(1.01 * limit), Grade::Unstable);
    assert!(check(0.99 * bound).exact.is_none());
    assert_eq!(check(0.99 * bound).to_string(), "");
    let close = check(0.5 * (bound + limit)).to_string();
    let node = loose.bound.node;
    for word in ["safe bound", &format!("node {node}"), "physics.dt"] {
        assert!(close.contains(word), "{close}");
    }
}

#[test]
fn an_unstable_step_is_refused_with_node_number_and_remedy() {
    let scene = scene(0.05);
    let check = check(0.05);
    let said = check
        .accept(&scene.physics)
        .expect_err("50 ms are too long");
    let node = check.exact.expect("it is beyond the bound").node;
    assert_eq!(said.exit_code(), 2);
    let words = ["0.05 s", "physics.dt", "unstable_step = \"warn\"", "1/s"];
    for word in words.into_iter().chain([&*format!("node {node}")]) {
        assert!(said.to_string().contains(word), "{said}");
    }
    let mut patient = scene.physics;
    patient.unstable_step = UnstableStep::Warn;
    assert!(check.accept(&patient).is_ok());
    // A scene that only warns has this setting already.
    let warned = check.to_string();
    let (before, _) = said
        .to_string()
        .split_once("; to go on")
        .map(|(a, b)| (a.to_owned(), b.to_owned()))
        .expect("a way out");
    assert_eq!(warned, before);
}

/// Of lattices large and small, with all laws: no design, layout or mixture, vibrates faster than the
/// bound has it, and a lone stiff bar comes near.
#[test]
fn no_design_vibrates_faster_than_the_bound_of_any() {
    let mut nearest: f64 = 0.0;
    for (seed, (columns, rows)) in [(2, 2), (1, 3), (6, 6), (4, 3)].into_iter().enumerate() {
        for (radius, stiffening) in [
            (0.0, 0.0),
            (0.02, 0.0),
            (0.2, 0.0),
            (0.0, 200.0),
            (0.1, 1e5),
        ] {
            let mut scene = scene(0.002);
            (scene.lattice.columns, scene.lattice.rows) = (columns, rows);
            (scene.physics.bending_radius, scene.physics.stiffening) = (radius, stiffening);
            let case = Case::of_scene(&scene, seed as u64).expect("any lattice starts so");
            let bound = bound_of_any_design(&case.lattice, &case.materials, &case.physics);
            for design in 0..12_usize {
                // One-hot where it is even; void everywhere but on the first edge in the first.
                let shares: Vec<[f64; 3]> = (0..case.lattice.edges.len())
                    .map(|e| match design {
                        0 => [f64::from(u8::from(e > 0)), f64::from(u8::from(e == 0)), 0.0],
                        _ if design % 2 == 0 => {
                            Material::ALL[(e * e + design * e + e / 3) % 3].one_hot()
                        }
                        _ => {
                            let shares = [1.0, 2.3, 3.1]
                                .map(|w| (w * (e + design) as f64).sin().powi(2) + 1e-3);
                            let sum: f64 = shares.iter().sum();
                            shares.map(|share| share / sum)
                        }
                    })
                    .collect();
                let design = Design::of_shares(&shares);
                let body = Body::new(&design, &case.lattice, &case.materials, &case.physics);
                let at_rest = &case.lattice.positions;
                let vibration = Vibration::new(&case.lattice, &body, &case.physics, at_rest);
                let (own, fastest) = (vibration.edge_bound(), vibration.largest_frequency());
                // Up to rounding and the softening of lengths, 1e-12 of a length squared of 1e-2.
                assert!(
                    fastest <= own * (1.0 + 1e-9),
                    "{fastest} above its bound {own}"
                );
                assert!(
                    own <= bound * (1.0 + 1e-9),
                    "{own} above that of any design {bound}"
                );
                if radius == 0.0 && stiffening == 0.0 {
                    nearest = nearest.max(fastest / bound);
                }
            }
        }
    }
    assert!(
        nearest > 0.9,
        "a bound that is far from any design: {nearest}"
    );
}

/// A step that the start bears, and a lone bar would not.
#[test]
fn of_a_step_that_other_designs_do_not_bear_it_is_said() {
    let check = check(0.002);
    assert_eq!(check.of_other_designs(), None);
    let start = check.bound.dt.expect("it vibrates");
    let any = check.any_design.expect("it vibrates");
    assert!(any < start, "{any} {start}");
    let between = self::check(0.5 * (any + start));
    assert_eq!(between.grade(), Grade::Safe);
    let said = between.of_other_designs().expect("it is longer");
    assert!(said.contains("may not bear what comes of it"), "{said}");
}

#[test]
fn nothing_that_vibrates_is_safe_with_any_step() {
    let mut scene = scene(1.0);
    scene.materials.stiffness = [0.0; 3];
    let check = case(&scene).step_check();
    assert_eq!((check.grade(), check.bound.dt), (Grade::Safe, None));
}

/// The remedy helps: what it says is safe.
#[test]
fn the_step_that_a_refusal_asks_for_is_safe() {
    let said = check(0.05).to_string();
    let (_, rest) = said.split_once("physics.dt to ").expect("a remedy");
    let dt: f64 = rest
        .split(' ')
        .next()
        .and_then(|number| number.parse().ok())
        .expect("a number");
    assert_eq!(check(dt).grade(), Grade::Safe);
}

#[test]
fn an_optimisation_refuses_an_unstable_start_unless_told_otherwise() {
    let mut scene = scene(0.05);
    scene.physics.steps = 8;
    scene.schedule.horizon = [8, 8];
    (scene.loss.window, scene.loss.every) = (8, 4);
    let begin = |scene: &Scene| CoDesign::new(scene).and_then(|c| c.begin(0));
    let refused = begin(&scene).expect_err("50 ms are too long");
    assert_eq!(refused.exit_code(), 2);
    scene.physics.unstable_step = UnstableStep::Warn;
    assert!(begin(&scene).is_ok());
}

/// Light nodes: as edges turn to stiff material the frequency grows past what the start allowed.
#[test]
fn a_design_that_becomes_unstable_is_in_the_record() {
    let mut scene = scene(0.002);
    scene.physics.steps = 16;
    scene.schedule.horizon = [16, 16];
    (scene.loss.window, scene.loss.every) = (8, 4);
    scene.schedule.iterations = 4;
    (scene.schedule.attraction_from, scene.schedule.snap_at) = (2, 2);
    scene.volume.solid = [1.0, 1.0];
    scene.volume.actuator = [0.0, 0.0];
    let limit = |scene: &Scene| {
        let vibration = CoDesign::new(scene).and_then(|c| {
            let progress = c.begin(0)?;
            Ok(c.step_check(&progress).bound.frequency)
        });
        step_limit(
            vibration.expect("2 ms are stable"),
            scene.physics.damping,
            0.0,
        )
    };
    // All skeleton in place of a third of it: stiffer by more than the third left here.
    scene.physics.dt = 0.7 * limit(&scene);
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

/// A scene's own time step is a row like the others: verify refuses nothing, and fails.
#[test]
fn an_unstable_scene_fails_the_verification() {
    let failures = |dt: f64| stable_steps(&case(&scene(dt))).failures;
    assert_eq!((failures(0.002).len(), failures(0.05).len()), (0, 1));
}
