//! `cosmic gradcheck`.

use crate::common::Bench;
use crate::program::has;
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

/// The actuators have no stroke, so the robot does not move. Therefore the loss depends on neither design nor
/// controller.
#[test]
fn groups_that_the_loss_does_not_depend_on_are_named() {
    let still = format!("{CHECK} --set materials.max_strain=[0,0,0]");
    let told = Bench::with(SMALL).cosmic(&still).ok().out;
    let zero = told.lines().filter(|line| line.ends_with("  both zero"));
    let names: Vec<_> = zero.map(|line| &line[..2]).collect();
    assert_eq!(names, ["z ", "w1", "b1", "w2", "b2", "v0"], "{told}");
    let says = "z, w1, b1, w2, b2, v0: the gradient is zero, and so are the differences";
    has(&told, &[says]);
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
