//! The clock whose frequency is a design variable (`controller.clock = "learned"`).

use autodiff::{DoubleDouble, Dual, Real};
use cosmic::case::Case;
use cosmic::codesign::CoDesign;
use cosmic::domain::{Domain, rollouts};
use cosmic::inputs::{CONTROLLER, Inputs};
use cosmic::lattice::State;
use cosmic::objective::{Displacement, Loss};
use cosmic::policy::{Controller, TEMPO, frequency};
use cosmic::record::DesignFile;
use cosmic::scene::{ClockKind, Scene};
use cosmic::simulator::Span;
use std::path::Path;

/// A small robot that walks on the ground.
const SCENE: &str = "
base = 'stability'
[lattice]
columns = 3
rows = 2
[physics]
steps = 400
[controller]
hidden = 4
clock = 'learned'
[schedule]
iterations = 8
attraction_from = 4
snap_at = 6
horizon = [32, 64]
[loss]
window = 16
every = 4
";

/// The half-width of central differences in double-double.
const WIDTH: f64 = 1e-12;

fn scene(settings: &[&str]) -> Scene {
    let scene = Scene::parse("learned", SCENE).unwrap();
    scene.set(settings).unwrap()
}

/// The case of the small robot, with this `tempo`.
fn robot(settings: &[&str], tempo: f64) -> Case {
    let mut case = Case::of_scene(&scene(settings), 1).unwrap();
    if case.scene.controller.clock == ClockKind::Learned {
        case.controller.block_mut(TEMPO)[0] = tempo;
    }
    case
}

/// The starts of the robot: one on the ground, the others above it and moving.
fn starts(case: &Case) -> Vec<State<f64>> {
    let start = |k: usize| {
        let mut start = case.start.clone();
        let by = 0.002 * k as f64;
        start.x.iter_mut().for_each(|x| x[1] += by);
        start.v.iter_mut().for_each(|v| v[0] += by);
        start
    };
    (0..5).map(start).collect()
}

/// The displacement loss of the rollout from each start. A single start runs alone, several in SIMD lanes.
fn losses<R: Real>(case: &Case, inputs: &Inputs<R>, starts: &[State<f64>]) -> R {
    let task = case.task();
    let loss = Displacement::at_end(task.ground());
    let designs = [case.projected(case.projection, &inputs.z)];
    let domain = |start: &State<f64>| Domain::of(&task, start.clone());
    let domains: Vec<Domain> = starts.iter().map(domain).collect();
    let span = Span::from_start(loss.observed(case.scene.physics.steps));
    let seen = rollouts(&designs, &inputs.controller, &domains, &span);
    R::sum_of(&seen.iter().map(|seen| loss.loss(seen)).collect::<Vec<_>>())
}

/// The derivative of the loss by `tempo`, in reverse mode.
fn by_tempo(case: &Case, starts: &[State<f64>]) -> f64 {
    let (_, gradient) = case
        .inputs()
        .differentiate(CONTROLLER, |inputs| losses(case, inputs, starts));
    *gradient.last().unwrap()
}

/// The derivative by the tempo over 400 steps on the ground, alone and in lanes.
#[test]
fn forward_mode_reverse_mode_and_differences_agree() {
    let case = robot(&[], 0.2);
    let starts = starts(&case);
    let mut alone = Vec::new();
    for start in &starts {
        let starts = std::slice::from_ref(start);
        let reverse = by_tempo(&case, starts);
        let mut inputs = case.inputs().lift::<Dual<f64, 1>>();
        inputs.controller.block_mut(TEMPO)[0].tangent = [1.0];
        let [forward] = losses(&case, &inputs, starts).tangent;
        // Both modes round each step at 1e-16. The contacts of 400 steps magnify these errors by up to 1e6.
        assert!(
            (forward - reverse).abs() < 1e-9 * reverse.abs(),
            "{forward} {reverse}"
        );
        // The error of differences in double-double is the square of their width times the third derivative, and 1e-32
        // divided by the width. What is left is the rounding of the reverse mode.
        let [up, down] = [WIDTH, -WIDTH].map(|by| {
            let mut inputs = case.inputs().lift::<DoubleDouble>();
            inputs.controller.block_mut(TEMPO)[0] += DoubleDouble::lit(by);
            losses(&case, &inputs, starts)
        });
        let slope: f64 = ((up - down) / DoubleDouble::lit(2.0 * WIDTH)).into();
        assert!(
            (slope - reverse).abs() < 1e-9 * reverse.abs(),
            "{slope} {reverse}"
        );
        alone.push(reverse);
    }
    assert!(alone.iter().all(|slope| slope.abs() > 1e-3), "{alone:?}");
    let (together, sum) = (by_tempo(&case, &starts), alone.iter().sum::<f64>());
    // Sums over lanes have another order.
    assert!(
        (together - sum).abs() < 1e-11 * sum.abs(),
        "{together} {sum}"
    );
}

/// A learned clock with a `tempo` of 0 gives the bits of a fixed clock, alone, in lanes, and in single precision. With
/// another `tempo`, the motion is that of a fixed clock of the learned frequency.
#[test]
fn a_learned_clock_is_a_clock_of_its_frequency() {
    fn end<R: Real>(case: &Case, starts: &[State<f64>]) -> Vec<f64> {
        let inputs = case.inputs().lift::<R>();
        let design = case.projected(case.projection, &inputs.z);
        let task = case.task();
        let domain = |start: &State<f64>| Domain::of(&task, start.clone());
        let domains: Vec<Domain> = starts.iter().map(domain).collect();
        let span = Span::from_start(vec![case.scene.physics.steps]);
        let seen = rollouts(&[design], &inputs.controller, &domains, &span);
        let states = seen.iter().flat_map(|seen| &seen.states[0].x);
        states.flatten().map(|x| x.primal()).collect()
    }
    let fixed = robot(&["controller.clock=fixed"], 0.0);
    let starts = starts(&fixed);
    let learned = robot(&[], 0.0);
    assert_eq!(end::<f64>(&learned, &starts), end::<f64>(&fixed, &starts));
    assert_eq!(end::<f32>(&learned, &starts), end::<f32>(&fixed, &starts));
    assert_eq!(
        end::<f64>(&learned, &starts[..1]),
        end::<f64>(&fixed, &starts[..1])
    );

    let air = ["physics.contact=none", "physics.gravity=0"];
    let learned = robot(&air, 0.3);
    let omega = frequency(&learned.scene.controller, &learned.controller);
    assert!(omega > 13.4 && omega < 13.6, "{omega}");
    let omega = format!("controller.omega={omega}");
    let fixed = robot(
        &[&air[..], &["controller.clock=fixed", &omega]].concat(),
        0.0,
    );
    // The phases reach 11 rad and are rounded differently.
    let pairs = end::<f64>(&learned, &starts)
        .into_iter()
        .zip(end::<f64>(&fixed, &starts));
    let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-12, "{off:e}");
    assert!(end::<f64>(&learned, &starts) != end::<f64>(&robot(&air, 0.0), &starts));

    // A rollout that continues another one has the phase of its first step.
    let (simulator, body) = (learned.task().simulator, learned.body());
    let run = |start: &State<f64>, span: &Span| {
        let seen = simulator.rollout(&body, &learned.controller, start, span);
        seen.states.last().unwrap().clone()
    };
    let half = run(&learned.start, &Span::from_start(vec![200]));
    let span = Span {
        first: 200,
        ..Span::from_start(vec![200])
    };
    let whole = run(&learned.start, &Span::from_start(vec![400]));
    let pairs = run(&half, &span)
        .to_columns()
        .into_iter()
        .zip(whole.to_columns());
    // Between the two, the state is converted to the world's frame and back.
    let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-12, "{off:e}");

    // The activations that reports show are those of the rollout.
    let activations = |case: &Case| {
        let span = Span::from_start(vec![0, 100, 400]);
        let (simulator, body) = (case.task().simulator, case.body());
        let seen = simulator.rollout(&body, &case.controller, &case.start, &span);
        let moments = simulator
            .moments(&body, &case.controller, &seen)
            .into_iter();
        moments
            .flat_map(|moment| moment.activation)
            .collect::<Vec<_>>()
    };
    let pairs = activations(&learned).into_iter().zip(activations(&fixed));
    let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-11, "{off:e}");
}

/// A case, a snapshot and a design keep the clock and its `tempo`. A robot is refused by a scene with the other kind of clock.
#[test]
fn files_keep_the_tempo() {
    let case = robot(&[], 0.25);
    let read = Case::parse("case", &case.to_json()).unwrap();
    assert_eq!(
        (&read.controller, read.scene.controller.clock),
        (&case.controller, ClockKind::Learned)
    );

    let text = serde_json::to_string(&case.controller).unwrap();
    let of_snapshot: Controller<f64> = serde_json::from_str(&text).unwrap();
    assert_eq!(of_snapshot, case.controller);

    let design = case.design.clone();
    let materials = case.own_design().materials();
    let file = DesignFile::new(&case.lattice, &design, &materials, &case.controller);
    let file = DesignFile::parse(Path::new("design.json"), file.to_json().as_bytes()).unwrap();
    let of_file = file.case(&scene(&[]), "design.json").unwrap();
    let displacement = |case: &Case| case.evaluate(false, &[]).unwrap().displacement;
    assert_eq!(displacement(&of_file), displacement(&case));
    assert_ne!(displacement(&of_file), displacement(&robot(&[], 0.0)));

    let refused = file
        .robot(&scene(&["controller.clock=fixed"]), "design.json")
        .unwrap_err()
        .to_string();
    for words in ["`controller.tempo`", "`controller.clock`", "\"learned\""] {
        assert!(refused.contains(words), "{refused}");
    }
    let fixed = robot(&["controller.clock=fixed"], 0.0);
    let file = DesignFile::new(&case.lattice, &design, &materials, &fixed.controller);
    let refused = file
        .robot(&scene(&[]), "design.json")
        .unwrap_err()
        .to_string();
    for words in [
        "`controller.tempo` is missing",
        "`controller.clock`",
        "\"fixed\"",
    ] {
        assert!(refused.contains(words), "{refused}");
    }
}

/// The weights that a seed draws do not depend on the clock. A run changes the frequency.
#[test]
fn a_run_learns_the_frequency() {
    let settings = ["physics.steps=64"];
    let mut codesign = CoDesign::new(&scene(&settings)).unwrap();
    let begun = codesign.begin(2).unwrap().controller;
    let mut fixed = scene(&settings);
    fixed.controller.clock = ClockKind::Fixed;
    let of_fixed = Controller::xavier(&fixed.controller, &codesign.task().lattice, 2);
    assert_eq!(begun.numbers(), [of_fixed.numbers(), &[0.0]].concat());
    let delivered = codesign.optimise(2, |_| ()).unwrap().controller;
    let tempo = delivered.block(TEMPO)[0];
    assert!(tempo != 0.0 && tempo.abs() < 0.1, "{tempo}");
}
