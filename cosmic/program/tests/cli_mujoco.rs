//! `cosmic export --mujoco`: compares robots in MuJoCo with the same robots in this simulator.
#![cfg(unix)]

use crate::common::Bench;
use crate::common::python::python;
use crate::program::Told;
use cosmic::case::Case;
use cosmic::geometry::{Dimension, Ground, Row, Vector};
use cosmic::policy::Goals;
use cosmic::scene::Scene;
use cosmic::world::Span;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

/// The page that describes all files.
const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/files.md");

/// The number of steps of a flight. A flight lasts more than a second, in which the clock advances by ten radians.
const STEPS: usize = 512;

/// A walk of an exported robot in MuJoCo: the first and the last positions of its nodes, in the ground's frame.
struct Walk {
    first: Vec<Vector<f64>>,
    last: Vec<Vector<f64>>,
    said: String,
}

impl Walk {
    /// Runs `walk.py` in an export folder.
    #[track_caller]
    fn of(python: &Path, bench: &Bench, folder: &str, more: &str) -> Self {
        let (player, path) = (
            bench.path(&format!("{folder}/walk.py")),
            bench.path("path.csv"),
        );
        let mut walk = Command::new(python);
        let walk = walk.arg(player).args(more.split_whitespace()).arg("--path");
        // MuJoCo writes its warnings to a file in the current folder.
        let walk = walk.arg(path).current_dir(bench.path(""));
        let told = Told::of(walk.output().unwrap()).ok();
        let rows = bench.read("path.csv");
        let nodes = bench.json(&format!("{folder}/controller.json"))["nodes"].take();
        let nodes = nodes.as_array().unwrap().len();
        let row = |row: &str| {
            let numbers: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
            assert!(numbers.len().is_multiple_of(nodes));
            let dimension = Dimension::try_from(numbers.len() / nodes).unwrap();
            dimension.from_flat(&numbers)
        };
        Self {
            first: row(rows.lines().next().unwrap()),
            last: row(rows.lines().last().unwrap()),
            said: told.out,
        }
    }

    /// The payload's displacement along the ground, in metres.
    fn distance(&self) -> f64 {
        self.last[0].forward() - self.first[0].forward()
    }
}

/// Flies a robot in MuJoCo and in this simulator. Returns the largest difference of a coordinate at the end, in metres.
fn error_of_flight(python: &Path, bench: &Bench, source: &str, settings: &[&str]) -> f64 {
    let all = [
        &["physics.contact=none", "physics.void_edges=drop"],
        settings,
    ]
    .concat();
    let set: String = all
        .iter()
        .map(|setting| format!(" --set {setting}"))
        .collect();
    // MuJoCo makes as many mechanical steps as this simulator.
    let substeps = settings
        .iter()
        .find_map(|s| s.strip_prefix("physics.substeps="));
    let substeps = substeps.unwrap_or("1");
    let export = format!("export {source} --mujoco --out flight --substeps {substeps}{set}");
    bench.cosmic(&export).ok();
    let there = Walk::of(python, bench, "flight", &format!("--steps {STEPS}"));
    let ours = bench.cosmic(&format!("evaluate {source} --record {STEPS}{set}"));
    let ours = ours.json()["results"]["trajectory"][STEPS.to_string()]["x"].take();
    let ours: Vec<Row> = serde_json::from_value(ours).unwrap();
    let dimension = Dimension::of_rows(&ours).unwrap();
    let ours: Vec<Vector<f64>> = ours.iter().map(|row| dimension.vector(row)).collect();
    let ground = Ground::from(&Scene::paper().set(&all).unwrap().physics);
    apart(bench, &there, &ours, &ground)
}

/// The largest difference, in metres, between a coordinate at the end of a flight in MuJoCo and the same coordinate in
/// this simulator. `ours` has the positions of all nodes in the world's frame.
fn apart(bench: &Bench, there: &Walk, ours: &[Vector<f64>], ground: &Ground) -> f64 {
    let nodes = bench.json("flight/controller.json")["nodes"].take();
    let nodes: Vec<usize> = serde_json::from_value(nodes).unwrap();
    let ours: Vec<Vector<f64>> = nodes.iter().map(|&node| ours[node]).collect();
    assert_eq!(
        (there.first.len(), there.last.len()),
        (ours.len(), ours.len())
    );
    // The robot must move: resting robots would also agree.
    assert!(there.first != there.last);
    let errors =
        there.last.iter().zip(ours).flat_map(|(&point, ours)| {
            (ground.vector_to_world(point) - ours).map(f64::abs).array()
        });
    errors.fold(0.0, f64::max)
}

#[test]
fn a_flight_in_mujoco_agrees_with_this_simulator() {
    let Some(python) = python() else { return };
    let bench = Bench::default();
    for (source, settings) in [
        // Scenes with layouts, in which void edges do not pull in either program.
        ("baseline_short", &[][..]),
        (
            "baseline_tall",
            &["physics.incline_deg=15", "physics.payload_mass=0.1"],
        ),
        (
            "baseline_short",
            &["physics.incline_deg=-40", "physics.damping=0"],
        ),
        ("baseline_tall", &["physics.substeps=3"]),
        // A scene in which every actuator reaches its stops again and again.
        (
            "baseline_short",
            &[
                r#"physics.forces=["damper","stops"]"#,
                "stops.at=0.02",
                "stops.stiffness=10",
                "damper.time=5e-4",
                "physics.damping=0",
            ],
        ),
        // Actuators with limits of force and speed, which the player computes in every mechanical step.
        (
            "baseline_short",
            &[
                r#"physics.forces=["actuator"]"#,
                "actuator.force=0.2",
                "actuator.speed=0.5",
                "physics.substeps=2",
            ],
        ),
        // A scene with mixtures, in which every edge pulls and is actuated.
        ("stability", &[]),
        // A scene in which nodes without a bar fly along and are observed.
        ("baseline_short", &["design.one_piece=false"]),
        ("stability", &["physics.dt=0.001"]),
        (
            "five_by_five",
            &["lattice.kind=triangular", "lattice.drop=0.2"],
        ),
        // Robots in space: with stops and dampers, on an incline, and without gravity, where they drift across.
        // In a rollout of the scene's length they would fall faster than the speed bound.
        ("cube", &["physics.steps=512"]),
        (
            "cube",
            &[
                "physics.steps=512",
                "physics.incline_deg=15",
                "physics.payload_mass=0.1",
            ],
        ),
        (
            "cube",
            &[
                "physics.steps=512",
                "physics.gravity=0",
                "physics.forces=[]",
                "physics.substeps=2",
            ],
        ),
        (
            "stability",
            &["lattice.kind=cubic", "lattice.columns=3", "lattice.depth=2"],
        ),
    ] {
        let error = error_of_flight(python, &bench, source, settings);
        // MuJoCo matches the softening of lengths (D4) only at rest. At a strain e, lengths differ by 5e-12 e m and
        // directions by 1e-10. After 512 steps, positions differ by 1e-12 to 1e-10 m, and by up to 7e-10 m if the
        // motion is chaotic.
        assert!(error < 1e-9, "{source} {settings:?}: {error:e} m");
    }
}

/// With `--rigid`, skeleton bars keep their length while actuators change theirs. A robot with implicit steps needs it.
#[test]
fn rigid_bars_keep_their_length() {
    let Some(python) = python() else { return };
    let bench = Bench::default();
    let export = "export baseline_short --mujoco --out stiff --set physics.integrator=implicit \
                  --set physics.contact=none --set materials.stiffness=[1e-7,1e6,30]";
    bench.cosmic(export).fails(2, &["add --rigid"]);
    bench.cosmic(&format!("{export} --rigid")).ok();
    let walk = Walk::of(python, &bench, "stiff", &format!("--steps {STEPS}"));
    let numbers = |key: &str| -> Vec<usize> {
        let list = bench.json("stiff/controller.json")[key].take();
        serde_json::from_value(list).unwrap()
    };
    let (nodes, actuators) = (numbers("nodes"), numbers("actuators"));
    let case = Case::of_scene(&Scene::load("baseline_short").unwrap(), 0).unwrap();
    let layout = case.design.layout().unwrap();
    let bars = (0..layout.len()).filter(|&edge| layout[edge].is_solid());
    let [mut skeleton, mut driven] = [0.0_f64; 2];
    for edge in bars {
        let ends =
            case.lattice.edges[edge].map(|end| nodes.iter().position(|&n| n == end).unwrap());
        let length = (walk.last[ends[1]] - walk.last[ends[0]]).norm();
        let strain = (length / case.lattice.rest_length[edge] - 1.0).abs();
        let most = if actuators.contains(&edge) {
            &mut driven
        } else {
            &mut skeleton
        };
        *most = most.max(strain);
    }
    // MuJoCo's constraints are soft: they give way by some millionths here.
    assert!(skeleton < 1e-4 && driven > 1e-2, "{skeleton:e} {driven:e}");
}

/// A robot is told where to go while it flies. The player does not fold the goal into the controller, and says how far
/// away each goal was.
#[test]
fn a_flight_to_changing_goals_agrees_with_this_simulator() {
    const CHANGES: [usize; 2] = [128, 320];
    let Some(python) = python() else { return };
    let bench = Bench::default();
    for own in [
        "controller.policy=gaits",
        "controller.policy=mlp",
        "lattice.mirror=false lattice.payload=0 physics.incline_deg=15",
        "lattice.kind=cubic lattice.columns=3 lattice.rows=3 physics.incline_deg=15",
    ] {
        let weightless = "physics.contact=none physics.void_edges=drop physics.gravity=0";
        let settings = weightless.split(' ').chain(own.split(' '));
        let settings: Vec<&str> = settings.collect();
        let set: String = settings
            .iter()
            .map(|setting| format!(" --set {setting}"))
            .collect();
        let export = "export errand --mujoco --out flight --substeps 1";
        bench.cosmic(&format!("{export}{set}")).ok();
        let scene = Scene::load("errand").unwrap().set(&settings).unwrap();
        let case = Case::of_scene(&scene, 0).unwrap();
        let ([first, second], dt) = (CHANGES, scene.physics.dt);
        let dimension = case.lattice.dimension;
        let places = [[1.5, 0.6], [-1.5, -0.2], [0.4, 0.0]];
        let places =
            places.map(|[along, across]| dimension.onto(Vector::new([along, across, 0.0])));
        let shown = |place: Vector<f64>, digits: usize, between: &str| {
            let mut numbers = dimension.list(place);
            numbers.pop();
            let numbers = numbers.iter().map(|x| format!("{x:.digits$}"));
            numbers.collect::<Vec<_>>().join(between)
        };
        let ground = Ground::from(&scene.physics);
        let payload = case.start.x[case.lattice.payload[0].node];
        let start = ground.vector_to_ground(payload);
        let goal = scene.controller.goal;
        // As high as the payload at the start, like the goals of `cosmic walk`.
        let [a, b, c] = places.map(|place| start + place);
        let goals = Goals::at(a).then(first, b).then(second, c);
        let robot = case.robot().with_goals(goals.clone());
        let span = Span::from_start(vec![0, first, second, STEPS]);
        let ours = (case.world()).run_one(&robot, &span);
        let [begin, change] = CHANGES.map(|steps| steps as f64 * dt);
        let [x, y, z] = places.map(|place| shown(place, 1, ","));
        let told = format!("--goal {x} --goal {y}@{begin}s --goal {z}@{change}");
        let there = Walk::of(python, &bench, "flight", &format!("--steps {STEPS} {told}"));
        let last = &ours.states.last().unwrap().x;
        let error = apart(&bench, &there, last, &ground);
        // As in the test above.
        assert!(error < 1e-9, "{own}: {error:e} m");
        let legs = [0, first, second, STEPS];
        for (k, place) in places.into_iter().enumerate() {
            let [from, to] = [legs[k], legs[k + 1]];
            let away = |steps| {
                let there = ground.vector_to_ground(ours.position(steps));
                dimension.norm_along(start + place - there)
            };
            let says = format!(
                "goal {} m, {:.3} to {:.3} s: {:.4} m away at first, {:.4} m at the end\n",
                shown(place, 4, ", "),
                from as f64 * dt,
                to as f64 * dt,
                away(from),
                away(to)
            );
            assert!(there.said.contains(&says), "{own}: {says}{}", there.said);
        }
        // The goal matters: with its own goal, the robot flies elsewhere.
        let own_goal = Walk::of(python, &bench, "flight", &format!("--steps {STEPS}"));
        assert!(apart(&bench, &own_goal, last, &ground) > 1e-6, "{own}");
        let goal = format!("goal {} m, 0.000", shown(goal - start, 4, ", "));
        assert!(own_goal.said.contains(&goal), "{}", own_goal.said);
    }
    // The player refuses goals that do not follow each other, and goals for a robot that has one of its own.
    bench.cosmic("export stability --mujoco --out fixed").ok();
    for (folder, goals, says) in [
        ("flight", "--goal 1@2", "must begin at 0 s"),
        ("flight", "--goal 1,2,3", "at most 2 numbers"),
        (
            "flight",
            "--goal 1 --goal 2@3 --goal 1@3",
            "after the goal before it",
        ),
        ("flight", "--goal ahead", "invalid told value: 'ahead'"),
        ("fixed", "--goal 1", "is a number of its controller"),
    ] {
        let mut walk = Command::new(python);
        let player = bench.path(&format!("{folder}/walk.py"));
        let walk = walk.arg(player).args(goals.split_whitespace());
        Told::of(walk.output().unwrap()).fails(2, &[says]);
    }
    let page = fs::read_to_string(PAGE).unwrap();
    for key in bench
        .json("flight/controller.json")
        .as_object()
        .unwrap()
        .keys()
    {
        assert!(page.contains(&format!("`{key}`")), "{key}");
    }
}

/// A scene with a small robot on ground of friction 1. Its optimisation has all phases.
const WALKER: &str = "
base = 'stability'
[lattice]
columns = 4
rows = 4
[physics]
steps = 2048
contact = \"coulomb\"
friction = 1.0
[schedule]
iterations = 60
attraction_from = 34
snap_at = 48
horizon = [1024, 2048]
horizon_over = [16, 30]
[binarisation]
threshold_over = [4, 36]
[loss]
window = 512
";

#[test]
fn walks_in_mujoco_cover_a_similar_distance() {
    let Some(python) = python() else { return };
    let cubes = "kind = \"cubic\"\ncolumns = 3\ndepth = 2\nrows = 3\n";
    walk_alike(python, WALKER);
    walk_alike(python, &WALKER.replace("columns = 4\nrows = 4\n", cubes));
}

/// Asserts that robots of a scene with friction 1, of five seeds, walk about as far in MuJoCo as here.
fn walk_alike(python: &Path, scene: &str) {
    let bench = Bench::with(scene);
    let mut shares = Vec::new();
    for seed in 0..5 {
        let run = &format!("run-{seed}");
        bench.run(run, &format!("--seed {seed} --quiet"));
        bench.cosmic(&format!("export {run} --mujoco")).ok();
        let folder = &format!("{run}/export");
        let there = Walk::of(python, &bench, folder, "");
        let still = Walk::of(python, &bench, folder, "--steps 0");
        assert_eq!(still.first, still.last);
        let ours = bench.json(&format!("{run}/summary.json"));
        let ours = ours["displacement_along"].as_f64().unwrap();
        let distance = there.distance();
        let says = format!("{distance:.4} m along the ground in 4.096 s\n");
        assert_eq!(there.said, says);
        assert!(ours > 0.1, "the robot walks only {ours} m");
        shares.push(distance / ours);
        // On ice, the robot hardly moves forward.
        bench
            .cosmic(&format!("export {run} --mujoco --friction 0.01"))
            .ok();
        assert!(Walk::of(python, &bench, folder, "").distance() < 0.5 * ours);
    }
    // Contact differs between the two programs, and gaits are chaotic, so single robots may walk much less far, and another
    // build may find other robots. Over whole rollouts at equal friction, the medians are 0.97 to 1.00. The robots of these
    // short runs have 0.97 to 0.99 in the plane, and 0.64, 0.82, 0.95, 0.96 and 0.99 in space.
    shares.sort_by(f64::total_cmp);
    let median = shares[shares.len() / 2];
    assert!(
        shares[0] > 0.5 && median > 0.9 && shares[4] < 1.1,
        "{shares:?}"
    );
}

/// A Python program that checks whether the model and the controller have the same names, and prints the numbers of
/// bodies, tendons and actuators.
const LOOK: &str = "
import json, sys, mujoco
words = json.load(open(sys.argv[1] + '/controller.json'))
model = mujoco.MjModel.from_xml_path(sys.argv[1] + '/robot.xml')
assert [model.actuator(k).name for k in range(model.nu)] == [f'a{e}' for e in words['actuators']]
assert [model.body(k + 1).name for k in range(model.nbody - 1)] == [f'n{n}' for n in words['nodes']]
print(model.nbody - 1, model.ntendon, model.nu)
";

/// Void edges are left out. So are nodes that only void edges join, unless the controller observes them.
#[test]
fn a_model_has_the_parts_that_move_or_are_observed() {
    let Some(python) = python() else { return };
    let bench = Bench::default();
    for (settings, is_observed) in [
        ("", false),
        // In the last two cases, the layout leaves nodes without a bar. Only the first of their controllers observes
        // such nodes.
        (" --set design.one_piece=false", true),
        (
            " --set design.one_piece=false --set controller.offset_scale=0 --set \
             controller.velocity_scale=0",
            false,
        ),
    ] {
        let export = format!("export baseline_short --mujoco --out e{settings}");
        bench.cosmic(&export).ok();
        let model = bench.read("e/robot.xml");
        let ends = model.split("site site=\"n").skip(1);
        let joined: BTreeSet<_> = ends.filter_map(|end| end.split('"').next()).collect();
        assert!(joined.len() < 36 && joined.contains("0"));
        let nodes = if is_observed { 36 } else { joined.len() };
        let mut look = Command::new(python);
        let look = look.args(["-c", LOOK, "e"]).current_dir(bench.path(""));
        let told = Told::of(look.output().unwrap()).ok();
        assert_eq!(told.out, format!("{nodes} 55 22\n"));
    }
}
