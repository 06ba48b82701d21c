//! `cosmic gradcheck`.

use crate::common::Bench;
use crate::program::{cosmic, has};
use cosmic::Registry;
use cosmic::scene::{Named, TaskKind};

const SMALL: &str =
    "base = \"stability\"\n[lattice]\ncolumns = 3\nrows = 2\n[controller]\nhidden = 4\n";
const CHECK: &str = "gradcheck tiny.toml --steps 64";

#[test]
fn gradcheck_prints_a_row_per_group_and_a_negative_control() {
    let told = Bench::with(SMALL).cosmic(CHECK).ok().out;
    let lines: Vec<_> = told.lines().collect();
    assert!(
        lines[0].starts_with("gradient of tiny.toml over 64 steps"),
        "{told}"
    );
    let groups = ["z", "w1", "b1", "w2", "b2", "x0", "v0"];
    for (line, name) in lines[2..9].iter().zip(groups) {
        // The robot starts on the ground, so the loss has a kink with respect to its positions.
        let verdict = if name == "x0" { "kink" } else { "smooth" };
        assert!(line.starts_with(&format!("{name} ")), "{told}");
        assert!(line.ends_with(&format!(" {verdict}")), "{told}");
    }
    assert!(lines[9].starts_with("x0: nodes start on the ground"));
    let control =
        "negative control: the gradient with respect to z, made wrong by 1 %, is called wrong";
    assert_eq!(lines[10..], [control]);
    assert!(!told.contains("zero"), "{told}");
}

/// Scenes in which the terrain begins below the lattice, so that the robot first falls onto the terrain.
#[test]
fn the_gradients_of_robots_on_terrain_are_checked() {
    let settings = [
        "lattice.columns=3",
        "lattice.rows=2",
        "lattice.drop=0.025",
        "controller.hidden=4",
        "physics.damping=5",
        "ground.from=0.05",
        "ground.spacing=0.1",
        "ground.rise=0.01",
    ];
    let settings = settings.map(|setting| format!(" --set {setting}")).concat();
    for scene in ["steps", "rough"] {
        let told = Bench::with(SMALL).cosmic(&format!("gradcheck {scene} --steps 64{settings}"));
        let told = told.ok().out;
        assert_eq!(
            told.lines()
                .filter(|line| line.ends_with("  smooth"))
                .count(),
            7,
            "{told}"
        );
        has(&told, &["made wrong by 1 %, is called wrong"]);
    }
}

/// Every built-in scene but `workshop`, whose implicit steps take a minute: every group has a gradient, and the negative control is found. The robots of some scenes
/// stand still at first, so they are thrown.
#[test]
fn a_bare_gradcheck_compares_every_group_of_every_scene() {
    let scenes = Registry::default();
    let mut thrown = 0;
    for scene in scenes.scenes().filter(|scene| scene.name != "workshop") {
        let line = format!(
            "gradcheck {} --steps 48 --directions 1 --set controller.hidden=4",
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

/// The actuators have no stroke, so the controller cannot move the robot. A check that compares nothing fails.
#[test]
fn a_check_that_compares_nothing_fails() {
    let still = format!("{CHECK} --set materials.max_strain=[0,0,0]");
    let told = Bench::with(SMALL).cosmic(&still);
    let empty = told
        .out
        .lines()
        .filter(|line| line.ends_with("  nothing compared"));
    let names: Vec<_> = empty.map(|line| &line[..2]).collect();
    assert_eq!(names, ["w1", "b1", "w2", "b2"], "{told:?}");
    has(&told.out, &["w1, b1, w2, b2: nothing could be compared"]);
    told.fails(1, &["w1 (nothing could be compared), b1"]);
}

/// The design of a finished robot is a layout, which has no variables.
#[test]
fn a_finished_robot_has_no_design_variables() {
    let told = Bench::finished().ok("gradcheck a --steps 64").out;
    has(&told, &["z: left out", "is called wrong"]);
    assert!(!told.contains("nothing"), "{told}");
}

/// `gradcheck` checks the gradient of the loss of the scene's task. So its output is different for every task.
#[test]
fn the_gradient_of_every_task_is_checked() {
    let table = |(task, _): &(&str, TaskKind)| {
        let scene = format!("{SMALL}[objective]\ntask = \"{task}\"\n");
        let told = Bench::with(&scene).cosmic(CHECK).ok().out;
        has(&told, &["of its scene's loss"]);
        told
    };
    let tables: Vec<String> = TaskKind::ALL.iter().map(table).collect();
    for (k, table) in tables.iter().enumerate() {
        assert!(!tables[..k].contains(table), "{table}");
    }
}

#[test]
fn a_divergence_is_reported_as_such_and_not_as_a_wrong_gradient() {
    let told = Bench::with("[physics]\ndt = 0.2\nsubsteps = 1\n").cosmic("gradcheck tiny.toml");
    told.fails(3, &["error: diverged in step "]);
    assert_eq!(told.out, "");
}
