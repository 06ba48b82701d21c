use crate::small::{MOBILE_ROBOT, after, begun, tiny};
use autodiff::Real;
use cosmic::case::Case;
use cosmic::design::{Design, Material};
use cosmic::judge::{Candidate, Delivery, Evaluator, Measurements, Measuring, Quantiles, VARIED};
use cosmic::objective::{Loss, of_scene};
use cosmic::random::{Purpose, stream};
use cosmic::scene::{Integrator, LossKind, PhysicsSettings, Scene, SelectionSettings, TaskKind};
use cosmic::search::{CoDesign, Progress, Schedule};
use cosmic::walk::{self, BarLoad, EdgeMoments};
use cosmic::world::{Span, Trajectory, Variation, draw};
use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

#[test]
fn a_delivery_stops_between_its_parts() {
    let (codesign, progress) = begun(&tiny());
    let asked = Cell::new(0);
    let stops_at = |question: usize| {
        asked.set(0);
        let known = Measurements::default();
        delivered(&codesign, &progress, known, question, &asked).0
    };
    assert_eq!(stops_at(usize::MAX), Some(codesign.deliver(&progress)));
    let questions = asked.get();
    assert!(questions > 3);
    for question in 1..=questions {
        assert_eq!(stops_at(question), None);
        // The last answer may concern a measurement, which ends before the delivery does.
        assert!(asked.get() <= question + 1);
    }
}

/// A delivery that is stopped at a question and at all later ones, and the measurements that it has done.
fn delivered(
    codesign: &CoDesign,
    progress: &Progress,
    known: Measurements,
    question: usize,
    asked: &Cell<usize>,
) -> (Option<Delivery>, Measurements) {
    let is_stopped = || {
        asked.set(asked.get() + 1);
        asked.get() >= question
    };
    let mut measuring = Measuring {
        rollouts: SelectionSettings::FINAL_ROLLOUTS,
        known,
        is_stopped: &is_stopped,
        keep: None,
    };
    let delivery = codesign.deliver_unless(progress, &mut measuring);
    (delivery, measuring.known)
}

/// Counts the rollouts whose losses are computed.
struct Counted(Arc<AtomicUsize>);

impl Loss for Counted {
    fn observed(&self, steps: usize) -> Vec<usize> {
        vec![steps]
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        self.0.fetch_add(1, Ordering::Relaxed);
        -trajectory.states[0].x[0].up()
    }
}

/// A delivery that is stopped anywhere and called again repeats no measurement that was done, and has the same result, also
/// if the measurements went through a file.
#[test]
fn a_stopped_delivery_goes_on_where_it_stopped() {
    let count = Arc::new(AtomicUsize::new(0));
    let codesign = CoDesign::with_loss(&tiny(), Counted(Arc::clone(&count))).unwrap();
    let progress = codesign.begin(1).unwrap();
    let asked = Cell::new(0);
    let counted = |known: Measurements, question: usize| {
        asked.set(0);
        let before = count.load(Ordering::Relaxed);
        let (delivery, known) = delivered(&codesign, &progress, known, question, &asked);
        (delivery, known, count.load(Ordering::Relaxed) - before)
    };
    let (whole, _, all) = counted(Measurements::default(), usize::MAX);
    let questions = asked.get();
    let mut least = all;
    for question in 1..=questions {
        let (none, known, first) = counted(Measurements::default(), question);
        assert!(none.is_none());
        let text = serde_json::to_string(&known).unwrap();
        let (resumed, _, then) = counted(serde_json::from_str(&text).unwrap(), usize::MAX);
        assert_eq!(resumed, whole);
        // Of the quantiles, the largest measurement, all rollouts may be repeated, and the unperturbed one.
        let repeated = first + then - all;
        let most = SelectionSettings::FINAL_ROLLOUTS + 1;
        assert!(repeated <= most, "{repeated} of {all} at {question}");
        least = least.min(then);
    }
    assert_eq!(
        least, 1,
        "only the unperturbed rollout is repeated at the end"
    );
}

/// Rollouts with other time steps stop like all others.
#[test]
fn rollouts_with_other_time_steps_see_the_stop() {
    let (mut codesign, progress) = after(&tiny(), 0, 1);
    codesign.stop_by(Some(Arc::new(AtomicBool::new(true))));
    let other = codesign.deliver(&progress).other_steps;
    // A rollout that was stopped has no result, which counts as minus infinity.
    assert_eq!(other.half.displacement, f64::NEG_INFINITY);
    let (_, medians) = other.integrator.unwrap();
    assert_eq!(medians.displacement, f64::NEG_INFINITY);
}

/// The delivered strains and speeds are equal to those of a rollout that is observed at every step.
#[test]
fn delivered_loads_cover_every_step() {
    let scene = Scene::parse("lively", &[MOBILE_ROBOT, "iterations = 9"].concat()).unwrap();
    let (codesign, progress) = after(&scene, 9, 1);
    let delivery = codesign.deliver(&progress);
    let design = codesign.design(&progress);
    let (world, start) = (codesign.world(), &codesign.evaluator().start);
    let robot = world.robot(world.body(&design), delivery.controller.clone(), start);
    let moments = |every: usize| {
        let observed = (0..=scene.physics.steps).step_by(every).collect();
        walk::moments(
            world,
            &robot,
            &world.run_one(&robot, &Span::from_start(observed)),
        )
    };
    let [all, some] = [1, 16].map(moments);
    // The largest change of the length between two moments, divided by the time between them.
    let fastest = |edge: usize, moments: &[EdgeMoments], every: usize| {
        let change = |pair: &[EdgeMoments]| (pair[1].strain[edge] - pair[0].strain[edge]).abs();
        let most = moments.windows(2).map(change).fold(0.0, f64::max);
        most * world.lattice().rest_length[edge] / (every as f64 * scene.physics.dt)
    };
    for (edge, (bar, material)) in (delivery.seen.bars.iter().zip(&delivery.materials)).enumerate()
    {
        assert_eq!(bar.is_some(), material.is_solid());
        let Some(bar) = bar else { continue };
        let other = BarLoad::of(edge, &all);
        assert_eq!((bar.strains, bar.strain), (other.strains, other.strain));
        // The order of the factors differs, which changes the last bits.
        let expected = fastest(edge, &all, 1);
        assert!(
            (bar.speed.peak - expected).abs() < 1e-12 * expected,
            "{bar:?} {expected}"
        );
    }
    let actuators = delivery.materials.iter().enumerate();
    let actuators: Vec<usize> = actuators
        .filter(|(_, m)| **m == Material::Actuator)
        .map(|(edge, _)| edge)
        .collect();
    let most =
        |speed: &dyn Fn(usize) -> f64| actuators.iter().map(|&k| speed(k)).fold(0.0, f64::max);
    let told = delivery.seen.loads.unwrap().speed.peak;
    let of_bar = |edge: usize| delivery.seen.bars[edge].as_ref().unwrap().speed.peak;
    assert_eq!(told, most(&of_bar));
    // The steps that `trajectory` keeps do not include the peak.
    assert!(told > most(&|edge| fastest(edge, &some, 16)));
}

/// An unreliable candidate with the better median is chosen only if its 10 % quantile beats the median of the
/// reliable one.
#[test]
fn an_unreliable_candidate_is_delivered_only_for_its_lower_quantile() {
    let mut scene = tiny();
    scene.schedule.settle = 1.0;
    let (codesign, mut progress) = begun(&scene);
    let mut candidate = |bias: f64, merit: f64, [p10, p50]: [f64; 2]| {
        progress.controller.numbers_mut()[0] += bias;
        let spread = Quantiles { p10, p50, p90: p50 };
        Candidate {
            iteration: progress.iteration,
            merit,
            controller: progress.controller.clone(),
            spread: Some(spread),
        }
    };
    let last = candidate(0.0, 0.1, [0.1, 0.1]);
    let steady = candidate(0.1, 2.0, [1.9, 2.0]);
    let chosen = |rival: Candidate| {
        let mut progress = progress.clone();
        progress.controller = last.controller.clone();
        progress.candidates = vec![rival.clone(), steady.clone(), last.clone()];
        let delivered = codesign.deliver(&progress).controller;
        let is = |c: &Candidate| c.controller == delivered;
        assert!(is(&rival) || is(&steady));
        let mut settled = progress.clone();
        let now = Schedule::at(codesign.scene(), 12);
        assert!(codesign.settle(&mut settled, &now, 0.1));
        assert_eq!(settled.controller, delivered);
        is(&rival)
    };
    let rival = |merit, spread| {
        let spread = Some(Quantiles { p90: 9.0, ..spread });
        let mut controller = steady.controller.clone();
        controller.numbers_mut()[0] += 0.1;
        Candidate {
            merit,
            controller,
            spread,
            ..steady.clone()
        }
    };
    let of = |p10, p50| Quantiles { p10, p50, p90: 9.0 };
    assert!(chosen(rival(3.0, of(2.9, 3.0))));
    // Both rivals are unreliable: the first because its 10 % quantile is low, the second because its unperturbed
    // rollout differs from the median.
    assert!(!chosen(rival(3.0, of(1.4, 3.0))));
    assert!(!chosen(rival(-4.2, of(1.8, 3.0))));
    assert!(chosen(rival(5.0, of(2.4, 5.0))));
}

/// The median of a robot in its scene with other physics, from the first eight starts of the delivery.
fn median(scene: &Scene, progress: &Progress, change: impl Fn(&mut PhysicsSettings)) -> f64 {
    let mut scene = scene.clone();
    change(&mut scene.physics);
    let codesign = CoDesign::new(&scene).unwrap();
    // No other controller can be delivered.
    let progress = Progress {
        candidates: Vec::new(),
        ..progress.clone()
    };
    of_eight(&codesign, &progress).spread.p50
}

/// The delivery of a robot that is measured in eight rollouts, like all its medians with other physics.
fn of_eight(codesign: &CoDesign, progress: &Progress) -> Delivery {
    (codesign.deliver_unless(progress, &mut Measuring::over(8))).unwrap()
}

/// A robot's other medians are those of scenes with half the step and with another integrator. A robot is unreliable if one
/// of them differs by more than a fifth.
#[test]
fn a_delivery_tells_whether_the_robot_depends_on_the_time_step() {
    let mut unsteady = 0;
    for seed in 1..=6 {
        let mut scene = Scene::parse("lively", &[MOBILE_ROBOT, "iterations = 9"].concat()).unwrap();
        scene.physics.steps = 768;
        let (codesign, progress) = after(&scene, 9, seed);
        let delivery = codesign.deliver(&progress);
        let progress = Progress {
            controller: delivery.controller.clone(),
            ..progress
        };
        let half = median(&scene, &progress, |physics| {
            physics.dt *= 0.5;
            physics.steps *= 2;
        });
        let leapfrog = median(&scene, &progress, |physics| {
            physics.integrator = Integrator::Leapfrog;
        });
        let mut finer = scene.clone();
        finer.physics.dt *= 0.5;
        finer.physics.steps *= 2;
        let finer = Evaluator::new(&finer, of_scene(&finer)).unwrap();
        let design = codesign.design(&progress);
        let seen = finer.observe(&design, &delivery.controller);
        let half_step = delivery.half_step.unwrap();
        assert_eq!(half_step.bars, seen.bars);
        assert_eq!(Some(half_step.energy), seen.energy);
        // The states in which crossing bars are counted are those of the same times.
        assert_eq!(half_step.loads.force, seen.loads.unwrap().force);
        let (integrator, medians) = delivery.other_steps.integrator.unwrap();
        assert_eq!(integrator, Integrator::Leapfrog);
        assert_eq!(delivery.other_steps.half.displacement, half);
        assert_eq!(medians.displacement, leapfrog);
        let own = of_eight(&codesign, &progress).spread.p50;
        // In this lattice of 0.1 m, 5 cm is the shortest distance that counts.
        let differs = |other: f64| (other - own).abs() > 0.2 * own.abs().max(0.05);
        let reason = delivery.reliability.reason().unwrap_or_default();
        assert_eq!(reason.contains("half the time step"), differs(half));
        assert_eq!(reason.contains("with leapfrog"), differs(leapfrog));
        unsteady += usize::from(differs(half) || differs(leapfrog));
    }
    assert!(unsteady > 0, "no robot of this test depends on its step");
}

/// `evaluate` measures the loads and the energy of a layout as a delivery does.
#[test]
fn an_evaluated_layout_has_the_loads_of_a_delivery() {
    let scene = Scene::load("workshop").unwrap();
    let scene = scene.set(&["physics.steps=100"]).unwrap();
    let mut case = Case::of_scene(&scene, 3).unwrap();
    let material = |edge| match edge % 3 {
        0 => Material::Actuator,
        _ => Material::Skeleton,
    };
    case.design = Design::Layout((0..case.lattice.edges.len()).map(material).collect());
    let results = case.evaluate(false, &[3, 50]).unwrap();
    let evaluator = Evaluator::new(&scene, of_scene(&scene)).unwrap();
    let seen = evaluator.observe(&case.own_design(), &case.controller);
    assert!(seen.energy.unwrap().air_power.unwrap() > 0.0);
    assert_eq!((&results.loads, results.energy), (&seen.loads, seen.energy));
    let printed = serde_json::from_str::<serde_json::Value>(&results.to_json()).unwrap();
    assert_eq!(
        printed["results"]["loads"],
        serde_json::to_value(&seen.loads).unwrap()
    );
    // A number that does not exist, such as an energy per metre in place, is finite enough.
    assert_eq!(results.not_finite(), [""; 0]);
    let undecided = Case::of_scene(&tiny(), 1)
        .unwrap()
        .evaluate(false, &[])
        .unwrap();
    assert_eq!((undecided.loads, undecided.energy), (None, None));
}

/// Stiff robots are compared with explicit steps only where these need few substeps.
#[test]
fn implicit_scenes_are_compared_with_explicit_steps_if_these_are_affordable() {
    let found = |stiffness: &str| {
        let text = format!("{stiffness}\n[physics]\nintegrator = 'implicit'\n");
        let scene = tiny().with("implicit", &text).unwrap();
        let (codesign, progress) = begun(&scene);
        let other = codesign.deliver(&progress).other_steps.integrator;
        (scene, progress, other)
    };
    let (scene, progress, other) = found("");
    let (integrator, medians) = other.unwrap();
    assert_eq!(integrator, Integrator::SymplecticEuler);
    let explicit = median(&scene, &progress, |physics| physics.integrator = integrator);
    assert_eq!(medians.displacement, explicit);
    // A bar that is a million times as stiff needs a thousand substeps.
    let stiff = "materials.stiffness = [1.0, 4e8, 3e1]";
    assert_eq!(found(stiff).2, None);
}

/// A loss counts in steps of the scene; the rollouts at half the step have twice as many.
#[test]
fn a_loss_sees_the_same_times_at_half_the_step() {
    let mut scene = tiny();
    scene.objective.task = TaskKind::Climb;
    scene.loss.kind = LossKind::Mean;
    (scene.loss.window, scene.loss.every) = (12, 4);
    let (codesign, progress) = begun(&scene);
    let half = codesign.deliver(&progress).other_steps.half;
    let mut finer = scene.clone();
    finer.physics.dt *= 0.5;
    finer.physics.steps *= 2;
    finer.loss.window *= 2;
    finer.loss.every *= 2;
    let (finer, progress) = begun(&finer);
    let merit = of_eight(&finer, &progress).merit.unwrap();
    assert_eq!(half.merit, merit.p50);
}

/// A final summary has quantiles of 24 rollouts. The page asks for eight: the first eight of the same draws. The robot, its
/// score and the medians with other steps do not depend on the number.
#[test]
fn final_quantiles_are_over_24_rollouts() {
    let scene = Scene::parse("lively", &[MOBILE_ROBOT, "iterations = 9"].concat()).unwrap();
    let (codesign, progress) = after(&scene, 9, 1);
    let evaluator = codesign.evaluator();
    let (own, eight) = (codesign.deliver(&progress), of_eight(&codesign, &progress));
    let over_24 = codesign.deliver_unless(&progress, &mut Measuring::over(24));
    assert_eq!(Some(&own), over_24.as_ref());
    assert_ne!(own.robust, eight.robust);
    assert_ne!(own.spread, eight.spread);
    let robust = |delivery: &Delivery, variations: &[Variation]| {
        let design = codesign.design(&progress);
        let along = |variation: &Variation| {
            evaluator
                .reach(&design, &delivery.controller, variation)
                .along()
        };
        Quantiles::of(&variations.iter().map(along).collect::<Vec<_>>())
    };
    let mut stream = stream(progress.seed, Purpose::Variation);
    let variations: Vec<_> = (0..24)
        .map(|_| draw(codesign.world(), &VARIED, &mut stream))
        .collect();
    assert_eq!(own.robust, robust(&own, &variations));
    assert_eq!(eight.robust, robust(&eight, &variations[..8]));
    let same = |d: &Delivery| {
        (
            d.controller.clone(),
            d.selection,
            d.selection_score,
            d.other_steps,
        )
    };
    assert_eq!(same(&own), same(&eight));
    assert_eq!(
        (&own.sensitivities, &own.seen),
        (&eight.sensitivities, &eight.seen)
    );
}

/// The distance with less friction is the median of eight robots in a scene with this friction.
#[test]
fn slippery_ground_is_a_scene_with_less_friction() {
    let scene = |friction: f64, contact: &str| {
        let slides = format!("[physics]\ncontact = '{contact}'\nfriction = {friction}");
        let text = MOBILE_ROBOT.replace("[physics]", &slides) + "iterations = 9";
        Scene::parse("lively", &text).unwrap()
    };
    let own = scene(0.5, "coulomb");
    let (codesign, progress) = after(&own, 9, 1);
    let delivery = codesign.deliver(&progress);
    let progress = Progress {
        controller: delivery.controller.clone(),
        candidates: Vec::new(),
        ..progress
    };
    let slippery = scene(0.3, "coulomb");
    let there = CoDesign::new(&slippery).unwrap();
    let there = of_eight(&there, &progress);
    let found = delivery.low_friction.unwrap();
    // The products of the factors round differently, by 1e-16, and the robot is not chaotic.
    assert!(
        (found - there.robust.p50).abs() < 1e-9,
        "{found} {:?}",
        there.robust
    );
    assert!(
        (found - delivery.robust.p50).abs() > 1e-5,
        "friction has no effect"
    );
    // Feet that never slip, and robots with another task.
    let sticks = scene(0.5, "infinite");
    let mut climbs = own.clone();
    climbs.objective.task = TaskKind::Climb;
    for other in [sticks, climbs] {
        let codesign = CoDesign::new(&other).unwrap();
        assert_eq!(codesign.deliver(&progress).low_friction, None);
    }
}

/// A robot that should walk far but stays in place is unreliable; one with another task may stay.
#[test]
fn a_robot_that_stays_in_place_is_not_reliable() {
    let mut scene = tiny();
    let (codesign, progress) = begun(&scene);
    let delivery = codesign.deliver(&progress);
    // The robot is 0.2 m long.
    assert!(delivery.robust.p50.abs() < 0.01, "{:?}", delivery.robust);
    assert!(delivery.reliability.stays_in_place());
    scene.objective.task = TaskKind::Climb;
    let (codesign, progress) = begun(&scene);
    let delivery = codesign.deliver(&progress);
    assert!(delivery.robust.p50.abs() < 0.01, "{:?}", delivery.robust);
    assert!(!delivery.reliability.stays_in_place());
}

/// The sensitivities of a robot are the differences of its medians in scenes with other physics.
#[test]
fn sensitivities_are_differences_of_medians_in_other_scenes() {
    let slides = "[physics]\ncontact = 'coulomb'\nfriction = 0.5";
    let text = MOBILE_ROBOT.replace("[physics]", slides) + "iterations = 9";
    let scene = Scene::parse("lively", &text).unwrap();
    let (codesign, progress) = after(&scene, 9, 1);
    let delivery = codesign.deliver(&progress);
    let progress = Progress {
        controller: delivery.controller.clone(),
        ..progress
    };
    let own = median(&scene, &progress, |_| {});
    let of = |name: &str| {
        let found = delivery.sensitivities.iter().find(|of| of.name == name);
        let found = found.unwrap_or_else(|| panic!("no {name} in {:?}", delivery.sensitivities));
        // These starts differ by about a nanometre, and the robot is not chaotic.
        assert!(found.error.unwrap() < 1e-6, "{name}: {:?}", found.error);
        [found.smaller, found.larger].map(Option::unwrap)
    };
    for name in ["gravity", "friction", "damping"] {
        let told = of(&format!("physics.{name}"));
        for (told, factor) in told.into_iter().zip([0.9, 1.1]) {
            let change = |physics: &mut PhysicsSettings| {
                let number = match name {
                    "gravity" => &mut physics.gravity,
                    "friction" => &mut physics.friction,
                    _ => &mut physics.damping,
                };
                *number *= factor;
            };
            let other = median(&scene, &progress, change) - own;
            // The same starts, but the numbers of the scene round differently.
            assert!(
                (told - other).abs() < 1e-6,
                "{name} {factor}: {told} {other}"
            );
            assert!(other.abs() > 1e-5, "{name} has no effect");
        }
    }
    assert!(of("nodes.mass") != of("bars.stiffness"));
}
