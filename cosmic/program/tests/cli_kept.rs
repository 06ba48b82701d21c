//! Tests that every command reads the scene in a run's folder in the same way.

use crate::common::Bench;
use std::fs;

/// The commands that need the scene of a finished run.
const READERS: [&str; 7] = [
    "report a",
    "report a a",
    "robustness a --samples 1",
    "evaluate a",
    "evaluate a/design.json",
    "export a --csv --out x",
    "optimize --from a --iterations 1 --out on",
];

/// Writes `scene` as the scene file of the run `a`. Asserts that each command then refuses the run with an error that
/// contains `says`.
#[track_caller]
fn refused(bench: &Bench, scene: &str, says: &str) {
    bench.write("a/scene.toml", scene);
    for line in READERS {
        bench.fails(line, 2, &["a/scene.toml", says]);
    }
    assert!(!bench.path("on").exists() && !bench.path("x").exists());
}

#[test]
fn every_command_refuses_a_scene_that_differs_from_the_run() {
    let bench = Bench::finished();
    let whole = bench.read("a/scene.toml");
    refused(&bench, "", "more keys are missing");
    refused(&bench, "base = \"stability\"\n", "more keys are missing");
    refused(
        &bench,
        &whole.replace("\nfriction = 2.5", "\n#"),
        "is missing",
    );
    let edited = whole.replace("gravity = 4.8", "gravity = 9.81");
    refused(&bench, &edited, "not the scene with which the run began");
    // If the scene file is missing, commands use the scene in the snapshot.
    bench.remove("a/scene.toml");
    for line in READERS.iter().filter(|line| !line.contains("--from")) {
        bench.ok(line);
    }
    // A design alone may be put beside any complete scene. In the scene file of a run, comments and the base may be
    // changed.
    fs::create_dir(bench.path("b")).unwrap();
    fs::copy(bench.path("a/design.json"), bench.path("b/design.json")).unwrap();
    bench.write("b/scene.toml", edited);
    bench.ok("evaluate b");
    let based = whole.replace("base = \"stability\"", "base = \"rough\" # mine");
    assert_ne!(based, whole);
    bench.write("a/scene.toml", based);
    bench.ok("evaluate a");
    bench.ok("scene check a/scene.toml");
}
