//! `cosmic check`.

use crate::common::Bench;
use crate::program::{cosmic, has};
use cosmic::Registry;
use cosmic::scene::{Named, Scene, TaskKind, VoidEdges};

const SMALL: &str = "base = \"stability\"\n[lattice]\ncolumns = 3\nrows = 2\n[controller]\nhidden = 4\n\
                     [physics]\nsteps = 96\n";
const CHECK: &str = "check tiny.toml --steps 64";

/// The text is short: the plan, a row for each group of the gradient, and four sentences about the distance.
#[test]
fn a_check_shows_plan_gradient_and_distance() {
    let told = Bench::with(SMALL).cosmic(CHECK).ok().out;
    has(
        &told,
        &[
            "tiny.toml: 3x2, 6 nodes, 11 edges, 96 steps of 0.002 s, symplectic euler\n",
            "\nPLAN\ncomputed in every step\n",
            "\nleft out\n",
            "  rotation of an incline     the ground is flat\n",
            "The time step of 0.002 s is ",
            "\nGRADIENT\nof the scene's loss over 64 steps\n",
            "x0: nodes start on the ground",
            "negative control: the gradient with respect to z, made wrong by 1 %, is called wrong",
            "\nDISTANCE\nThe robot moves by ",
            " the time step: ",
            " the integrator: ",
            " the precision: ",
            "\nPlan: 1 check, 0 failed\nGradient: 8 checks, 0 failed\nDistance: 1 check, 0 failed\n",
        ],
    );
    assert!(told.lines().count() < 50, "{told}");
    let groups = ["z", "w1", "b1", "w2", "b2", "x0", "v0"];
    for name in groups {
        // The robot starts on the ground, so the loss has a kink with respect to its positions.
        let verdict = if name == "x0" { "kink" } else { "smooth" };
        let mut lines = told.lines();
        let row = lines.find(|line| line.starts_with(&format!("{name} ")));
        assert!(row.unwrap().ends_with(&format!(" {verdict}")), "{told}");
    }
    assert!(!told.contains("ACCURACY") && !told.contains("STABILITY"));
}

#[test]
fn a_folder_has_a_page_that_draws_charts_and_a_file_for_each_table() {
    let bench = Bench::with(SMALL);
    let told = bench.ok(&format!("{CHECK} --accuracy --out new/sheet --json"));
    let json: serde_json::Value = serde_json::from_str(&told.out).unwrap();
    let sections = json["sections"].as_array().unwrap();
    let titles = ["Plan", "Gradient", "Distance", "Accuracy"];
    assert!(sections.iter().map(|s| &s["title"]).eq(&titles));
    let mut written: Vec<String> = vec!["new/sheet/check.html".to_owned()];
    for table in sections
        .iter()
        .flat_map(|s| s["tables"].as_array().unwrap())
    {
        let name = format!("new/sheet/{}.csv", table["name"].as_str().unwrap());
        let rows = table["rows"].as_array().unwrap().len();
        assert_eq!(bench.read(&name).lines().count(), rows + 1, "{name}");
        written.push(name);
    }
    assert!(told.error.lines().eq(&written), "{}", told.error);
    let page = bench.read("new/sheet/check.html");
    assert_eq!(page.matches("<canvas class=\"chart\"").count(), 3);
    has(&page, &["<table", "class Lines", "\"name\":\"median\""]);
    assert!(!page.contains("http://") && !page.contains("https://"));
}

/// The output folder is checked before anything else, because the checks take a while.
#[test]
fn an_impossible_folder_is_refused_before_any_work() {
    let told = Bench::with(SMALL).cosmic("check tiny.toml --out tiny.toml");
    told.fails(4, &["cannot write tiny.toml"]);
    assert_eq!(told.out, "");
}

/// Robots of every kind are tried. The time step of the scene itself is unstable, so its check fails.
#[test]
fn stiff_and_extreme_robots_are_tried_on_demand() {
    // Nothing moves this robot, so it does not diverge.
    let still = "contact = \"none\"\ngravity = 0.0\ndt = 0.01";
    let scene = SMALL.replace("steps = 96", &format!("steps = 64\n{still}"));
    let scene = scene + "[materials]\nmax_strain = [0.0, 0.0, 0.0]\n";
    let told = Bench::with(&scene).cosmic("check tiny.toml --stability --steps 4");
    let failure = "checks failed: the time step is above the largest stable one";
    told.fails(1, &[failure]);
    let kinds = told.out.split("\n  kind ").nth(1).unwrap();
    for kind in [
        "stiffness",
        "mass",
        "ratio",
        "damping",
        "integrator",
        "implicit",
        "time step",
        "friction",
        "layout",
        "controller",
        "coincidence",
        "lattice",
    ] {
        let mut lines = kinds.lines();
        let row = lines.find(|line| line.starts_with(&format!("  {kind} ")));
        assert!(
            row.is_some_and(|row| row.ends_with("  0")),
            "{kind}: {kinds}"
        );
    }
}

/// A delivered robot must cover about the same distance at half the time step and with another integrator.
#[test]
fn a_finished_robot_is_checked_for_its_distance_too() {
    let bench = Bench::finished();
    let told = bench.ok("check a --steps 64").out;
    has(
        &told,
        &[
            "z: left out",
            "is called wrong",
            "Distance: 3 checks, 0 failed",
        ],
    );
    assert!(!told.contains("nothing"), "{told}");
    let design = bench.ok("check a/design.json --steps 64 --quiet --threads 1");
    assert_eq!(design.out, "");
}

/// Every built-in scene but `workshop`, whose implicit steps take a minute: every group has a gradient, and the negative
/// control is found. The robots of some scenes stand still at first, so they are thrown.
#[test]
fn the_gradients_of_every_scene_are_compared() {
    let scenes = Registry::default();
    let mut thrown = 0;
    for scene in scenes.scenes().filter(|scene| scene.name != "workshop") {
        let line = format!(
            "check {} --steps 48 --set controller.hidden=4 --set physics.steps=64",
            scene.name
        );
        let told = cosmic(&line).ok().out;
        assert!(!told.contains("nothing"), "{told}");
        has(&told, &["made wrong by 1 %, is called wrong"]);
        let smooth = told.lines().filter(|line| line.ends_with("  smooth"));
        assert!(smooth.count() >= 3, "{told}");
        thrown += usize::from(told.contains("thrown up and forward"));
    }
    assert!(thrown > 0);
}

/// Scenes in which the terrain begins below the lattice, so that the robot first falls onto the terrain.
#[test]
fn the_gradients_of_robots_on_terrain_are_checked() {
    let settings = [
        "lattice.drop=0.025",
        "lattice.columns=3",
        "lattice.rows=2",
        "controller.hidden=4",
        "physics.damping=5",
        "physics.steps=64",
        "ground.from=0.05",
        "ground.spacing=0.1",
        "ground.rise=0.01",
    ];
    let settings = settings.map(|setting| format!(" --set {setting}")).concat();
    for scene in ["steps", "rough"] {
        let told = cosmic(&format!("check {scene} --steps 64{settings}"))
            .ok()
            .out;
        let smooth = told.lines().filter(|line| line.ends_with("  smooth"));
        assert_eq!(smooth.count(), 7, "{told}");
        has(&told, &["made wrong by 1 %, is called wrong"]);
    }
}

/// The actuators have no stroke, so the controller cannot move the robot. A check that compares nothing fails.
#[test]
fn a_check_that_compares_nothing_fails() {
    let told = Bench::with(SMALL).cosmic(&format!("{CHECK} --set materials.max_strain=[0,0,0]"));
    let empty = told.out.lines();
    let empty = empty.filter(|line| line.ends_with("  nothing compared"));
    let names: Vec<_> = empty.map(|line| &line[..2]).collect();
    assert_eq!(names, ["w1", "b1", "w2", "b2"], "{told:?}");
    has(&told.out, &["w1, b1, w2, b2: nothing could be compared"]);
    told.fails(1, &["w1 (nothing could be compared); b1"]);
}

/// The gradient is that of the loss of the scene's task. So its output is different for every task.
#[test]
fn the_gradient_of_every_task_is_checked() {
    let gradient = |(task, _): &(&str, TaskKind)| {
        let scene = format!("{SMALL}[objective]\ntask = \"{task}\"\n");
        let told = Bench::with(&scene).cosmic(CHECK).ok().out;
        told.split("GRADIENT").nth(1).unwrap().to_owned()
    };
    let gradients: Vec<String> = TaskKind::ALL.iter().map(gradient).collect();
    for (k, gradient) in gradients.iter().enumerate() {
        assert!(!gradients[..k].contains(gradient), "{gradient}");
    }
}

#[test]
fn a_divergence_is_reported_as_such_and_not_as_a_wrong_gradient() {
    let told = Bench::with("[physics]\ndt = 0.2\nsubsteps = 1\n").cosmic("check tiny.toml");
    told.fails(3, &["error: diverged in step "]);
    assert_eq!(told.out, "");
}

#[test]
fn the_plan_says_whether_void_edges_are_kept() {
    let bench = Bench::default();
    let mut scene = Scene::load("baseline_tall").unwrap();
    scene.physics.void_edges = VoidEdges::Drop;
    bench.write("dropped.toml", scene.to_toml());
    for (source, setting) in [("baseline_tall", "keep"), ("dropped.toml", "drop")] {
        let short = "--steps 48 --set physics.steps=64 --set controller.hidden=4";
        let told = bench.ok(&format!("check {source} {short}")).out;
        let (computed, left_out) = told.split_once("left out").unwrap();
        let text = if setting == "keep" {
            computed
        } else {
            left_out
        };
        has(
            text,
            &["void edges", &format!("physics.void_edges is {setting:?}")],
        );
    }
}
