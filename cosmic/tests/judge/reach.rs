use crate::small::{MOBILE_ROBOT, begun, tiny};
use cosmic::judge::{Quantiles, VARIED, first_best};
use cosmic::lattice::State;
use cosmic::laws::ContactLaw;
use cosmic::random::{Purpose, stream};
use cosmic::scene::{GradientPrecision, Scene, SelectionKind, SelectionSettings, TaskKind};
use cosmic::search::{CoDesign, Schedule};
use cosmic::world::draw;

/// A robot that moves very far, but not so far that a state is absurd, has not diverged. It falls along a steep
/// slope for 40 s, so far that the cheap check during the rollout fails and the guard decides.
#[test]
fn a_nearly_absurd_state_has_not_diverged() {
    let mut scene = tiny();
    scene.physics.contact = ContactLaw::coulomb();
    scene.physics.friction = 0.0;
    scene.physics.incline_deg = 60.0;
    scene.physics.gravity = 1000.0;
    (scene.physics.damping, scene.physics.steps) = (0.0, 20_000);
    scene.physics.speed_bound = None;
    scene.lattice.spacing = 0.001;
    scene.materials.stiffness = [1e-7, 1.0, 1.0];
    let (codesign, progress) = begun(&scene);
    let reached = codesign.evaluate(&progress);
    assert!((5e5..1e6).contains(&reached.along().abs()), "{reached:?}");
    let delivery = codesign.deliver(&progress);
    assert_eq!(delivery.seen.divergence, None);
    assert_eq!(delivery.seen.moved.forward(), reached.along());
    assert!(delivery.spread.p10.is_finite(), "{delivery:?}");
}

/// A speed bound just below the largest speed of a node makes the rollout diverge; a bound just above it changes
/// nothing.
#[test]
fn a_robot_with_a_node_beyond_the_bound_has_diverged() {
    let mut scene = Scene::parse("fast", &[MOBILE_ROBOT, "iterations = 8"].concat()).unwrap();
    scene.physics.speed_bound = None;
    let free = CoDesign::new(&scene).unwrap();
    let progress = free.begin(1).unwrap();
    let all = free.watch(&progress, (0..=scene.physics.steps).collect());
    let states = all.unwrap().states;
    let speed = |state: &State<f64>| state.speeds().fold(0.0, f64::max);
    let fastest = states.iter().map(speed).fold(0.0, f64::max);
    // The node is fastest between the observed states, not at the end.
    assert!(speed(&states[scene.physics.steps]) < 0.9 * fastest);
    let first = |bound: f64| states.iter().position(|state| speed(state) > bound);
    let mut moves = |bound| {
        scene.physics.speed_bound = bound;
        let codesign = CoDesign::new(&scene).unwrap();
        let at = codesign.point(&progress, &Schedule::at(&scene, 1));
        let walk = codesign.watch(&progress, vec![0, scene.physics.steps]);
        assert_eq!(
            walk.is_none(),
            codesign.evaluate(&progress).along().is_nan()
        );
        let slopes = codesign.evaluator().design_slopes(&at);
        (
            codesign.evaluate(&progress),
            slopes,
            codesign.deliver(&progress),
        )
    };
    let (reached, slopes, delivery) = moves(None);
    // The delivery also simulates varied robots, whose nodes are up to a few per cent faster.
    for bound in [1.5 * fastest, 1e4] {
        assert_eq!(
            moves(Some(bound)),
            (reached, slopes.clone(), delivery.clone())
        );
    }
    for bound in [0.999, 0.8] {
        let bound = bound * fastest;
        let (beyond, same, flown) = moves(Some(bound));
        assert!(beyond.along().is_nan() && beyond.merit.is_nan());
        assert_eq!(same, slopes);
        let found = flown.seen.divergence.unwrap();
        assert_eq!(Some(found.step + 1), first(bound));
        let says = cosmic::Error::from(&found).to_string();
        let node = format!("node {} at", found.node);
        let allowed = format!("`physics.speed_bound` allows {bound} m/s");
        for words in [node, allowed] {
            assert!(says.contains(&words), "{says}");
        }
        assert!(flown.seen.moved.forward().is_nan() && flown.seen.loads.is_none());
    }
}

/// Rollouts of the optimisation are computed in the precision of the scene; the figures to quote are computed in
/// f64.
#[test]
fn rollouts_of_the_optimisation_have_the_precision_of_gradients() {
    let check = |mut scene: Scene| {
        scene.start.tilt = 0.2;
        let double = CoDesign::new(&scene).unwrap();
        scene.gradient.precision = GradientPrecision::F32;
        let single = CoDesign::new(&scene).unwrap();
        let progress = double.begin(1).unwrap();
        let [a, b] = [&double, &single].map(|codesign| codesign.evaluate(&progress));
        // The expected rounding error is 0.3 * 24 * 100^(1/2) * 6e-8: lengths of 0.3 m, 24 steps, and in each
        // about 100 operations that round at 6e-8 with random signs.
        for (a, b) in [(a.along(), b.along()), (a.merit, b.merit)] {
            assert!(a != b && (a - b).abs() < 5e-6, "{a} {b}");
        }
        assert_eq!(double.deliver(&progress), single.deliver(&progress));
    };
    check(tiny());
    let mut scene = tiny();
    scene.objective.task = TaskKind::Climb;
    check(scene);
}

#[test]
fn the_first_of_equals_is_the_best_and_diverged_rollouts_are_last() {
    let least = f64::NEG_INFINITY;
    assert_eq!(first_best([1.0, 3.0, f64::NAN, 3.0, 2.0].map(|m| [m])), 1);
    assert_eq!(first_best([[f64::NAN], [least], [-5.0]]), 2);
    assert_eq!(first_best([[f64::NAN], [least]]), 0);
    assert_eq!(first_best([[least, 1.0], [least, 2.0], [least, 2.0]]), 1);
}

/// In a scene that selects by robust displacements, the rank of a robot is the 10 % quantile over robots that vary a
/// little, or the result of the robot as designed if that is worse. The rollouts run side by side, with the bits of
/// single rollouts.
#[test]
fn a_robust_rank_is_a_quantile_over_varied_robots() {
    let mut scene = Scene::parse("lively", &format!("{MOBILE_ROBOT}iterations = 9\n")).unwrap();
    (scene.physics.contact, scene.physics.friction) = (ContactLaw::coulomb(), 0.6);
    scene.selection.kind = SelectionKind::Robust;
    let (codesign, progress) = begun(&scene);
    let (evaluator, reached) = (codesign.evaluator(), codesign.evaluate(&progress));
    let mut stream = stream(progress.seed, Purpose::Ranking);
    let mut variations: Vec<_> = (0..SelectionSettings::PERTURBED_ROLLOUTS)
        .map(|_| draw(&evaluator.world, &VARIED, &mut stream))
        .collect();
    variations[0] = evaluator.world.nominal(&evaluator.start);
    let design = codesign.design(&progress);
    let alone = |variation| evaluator.reach(&design, &progress.controller, variation);
    let merits: Vec<f64> = variations
        .iter()
        .map(|variation| alone(variation).merit)
        .collect();
    let of_varied = Quantiles::of(&merits);
    assert!(of_varied.p10 < of_varied.p90, "{merits:?}");
    assert_eq!(reached.merit, of_varied.p10.min(merits[0]));
    assert_eq!(reached.along(), merits[0]);
}
