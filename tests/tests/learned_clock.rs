//! The clock whose frequency is a design variable (`controller.clock = "learned"`).

use autodiff::{Parameters, Real};
use cosmic::case::Case;
use cosmic::lattice::State;
use cosmic::outcome::DesignFile;
use cosmic::policy::{Controller, TEMPO, frequency};
use cosmic::scene::{ClockKind, Scene};
use cosmic::search::CoDesign;
use cosmic::walk;
use cosmic::world::Span;
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
        start.x.iter_mut().for_each(|x| *x = x.with_up(x.up() + by));
        start
            .v
            .iter_mut()
            .for_each(|v| *v = v.with_forward(v.forward() + by));
        start
    };
    (0..5).map(start).collect()
}

/// A learned clock with a `tempo` of 0 gives the bits of a fixed clock, alone, in lanes, and in single precision. With
/// another `tempo`, the motion is that of a fixed clock of the learned frequency.
#[test]
fn a_learned_clock_is_a_clock_of_its_frequency() {
    fn end<R: Real>(case: &Case, starts: &[State<f64>]) -> Vec<f64> {
        let inputs = case.inputs().lift::<R>();
        let design = case.projected(case.projection, &inputs.z);
        let world = case.world();
        let robot = inputs.robot(&world, &design);
        let from = |start: &State<f64>| robot.from(&start.map(R::lit));
        let robots: Vec<_> = starts.iter().map(from).collect();
        let seen = world.run(&robots, &Span::of_steps(case.scene.physics.steps));
        let states = seen.iter().flat_map(|seen| &seen.states[0].x);
        states.flat_map(|x| x.array()).map(|x| x.primal()).collect()
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
    let (world, own) = (learned.world(), learned.robot());
    let run = |start: &State<f64>, span: &Span| {
        let seen = world.run_one(&own.from(start), span);
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
        let (world, robot) = (case.world(), case.robot());
        let moments = walk::moments(&world, &robot, &world.run_one(&robot, &span));
        moments
            .into_iter()
            .flat_map(|moment| moment.activation)
            .collect::<Vec<_>>()
    };
    let pairs = activations(&learned).into_iter().zip(activations(&fixed));
    let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-11, "{off:e}");
}

/// A case, a snapshot and a design keep the clock and its `tempo`.
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
}

/// The weights that a seed draws do not depend on the clock. A run changes the frequency.
#[test]
fn a_run_learns_the_frequency() {
    let settings = ["physics.steps=64"];
    let mut codesign = CoDesign::new(&scene(&settings)).unwrap();
    let begun = codesign.begin(2).unwrap().controller;
    let mut fixed = scene(&settings);
    fixed.controller.clock = ClockKind::Fixed;
    let of_fixed = Controller::xavier(&fixed.controller, codesign.world().lattice(), 2);
    assert_eq!(begun.numbers(), [of_fixed.numbers(), &[0.0]].concat());
    let delivered = codesign.optimise(2, |_| ()).unwrap().controller;
    let tempo = delivered.block(TEMPO)[0];
    assert!(tempo != 0.0 && tempo.abs() < 0.1, "{tempo}");
}
