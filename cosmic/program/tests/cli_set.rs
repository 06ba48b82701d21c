//! `--set key=value` in all commands that take a scene.

use crate::common::{Bench, scene};
use crate::program::has;

/// If two settings change the same key, the later one counts. More about values is tested with the reader of scenes.
#[test]
fn settings_apply_in_order_and_all_wrong_ones_are_reported() {
    let bench = Bench::default();
    let show = "scene show stability --json";
    let scene = bench
        .cosmic(&format!(
            "{show} --set physics.gravity=9.81 --set physics.contact=coulomb --set physics.gravity=3.7"
        ))
        .json();
    assert_eq!(scene["physics"]["gravity"], 3.7);
    assert_eq!(scene["physics"]["contact"], "coulomb");
    // Keys that are not set keep their values.
    let whole = bench.cosmic(show).json();
    assert_eq!(scene["lattice"], whole["lattice"]);
    assert_ne!(scene["physics"], whole["physics"]);
    // All wrong settings are reported.
    let said = bench.cosmic("optimize tiny.toml --set physics.dt=-0.1 --set physics.steps=0");
    let shown = [
        "`physics.dt` is out of range: -0.1",
        "physics.steps",
        "allowed: ",
    ];
    said.fails(2, &shown);
    assert!(said.out.is_empty() && !bench.path("runs").exists());
}

#[test]
fn every_command_that_takes_a_scene_takes_settings() {
    let bench = Bench::default();
    let with = |line: &str, setting: &str| bench.cosmic(&format!("{line} --set {setting}"));
    let checked = with("check tiny.toml", "physics.steps=96");
    has(&checked.out, &[" 96 steps of ", "over 96 steps"]);
    for command in ["scene check", "check"] {
        let refused = with(&format!("{command} tiny.toml"), "physics.dt=-1");
        refused.fails(2, &["--set physics.dt=-1"]);
    }
    let on_earth_or_mars = |line: &str| {
        ["9.81", "3.7"].map(|gravity| with(line, &format!("physics.gravity={gravity}")).json())
    };
    let run = "--set physics.gravity=3.7 --iterations 2";
    bench.run("a", run);
    let kept = bench.read("a/scene.toml");
    has(&kept, &["gravity = 3.7"]);
    // A design is used with the scene beside it.
    for line in ["evaluate tiny.toml", "evaluate a"] {
        let [earth, mars] = on_earth_or_mars(line).map(|all| all["results"]["trajectory"].clone());
        assert_ne!(earth, mars);
    }
    let robust = "robustness a --samples 1 --json";
    let [earth, mars] = on_earth_or_mars(&format!("{robust} --scene tiny.toml"));
    assert_ne!(earth["runs"], mars["runs"]);
    // Without a scene, the settings change the scene of each run.
    let [earth, mars] = on_earth_or_mars(robust);
    assert_ne!(earth["runs"], mars["runs"]);
    assert_eq!(bench.ok("robustness a --samples 1 -q --threads 1").out, "");
    // A command that needs a run says so if it is given a scene.
    for line in [
        "walk earth",
        "report earth",
        "robustness earth",
        "resume earth",
        "export earth --csv",
        "report a earth",
    ] {
        let says = "`earth` is a scene, but this command needs a run; make one with: cosmic optimize earth";
        bench.fails(line, 2, &[says]);
    }
    // Only `optimize` reads the horizon, so a shorter rollout is not refused.
    let evaluated = with("evaluate stability", "physics.steps=64").json();
    assert!(
        evaluated["results"]["trajectory"].is_object(),
        "{evaluated}"
    );
    let warned = with("scene check stability", "physics.steps=1024");
    has(
        &warned.error,
        &["the horizon is longer than the rollout and ends with it"],
    );
    with("sweep run tiny.toml --out s", "physics.gravity=3.7").ok();
    has(&bench.read("s/sweep.json"), &["gravity = 3.7"]);
}

/// If `--set` makes the time step unstable, the error shows that option and not the line of the scene file that it
/// overrides.
#[test]
fn an_unstable_step_is_shown_where_it_was_set() {
    let bench = Bench::with(&scene(4, 32, "dt = 0.001"));
    let said = bench.optimize("a", "--set physics.dt=0.05");
    said.fails(2, &["--set physics.dt=0.05"]);
    assert!(!said.error.contains("tiny.toml"), "{said:?}");
    assert!(!bench.path("a").exists());
}

#[test]
fn a_reference_case_has_no_scene_to_change() {
    let bench = Bench::default();
    bench.write("case.json", "{}");
    let said = bench.cosmic("evaluate case.json --set physics.dt=0.001");
    said.fails(2, &["case.json is a reference case"]);
}
