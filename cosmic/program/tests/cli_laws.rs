//! Programs with laws, losses and scenes of their author's: the examples.

#[cfg(unix)]
use crate::background::signal;
use crate::common::Bench;
use std::path::Path;
use std::process::Command;

/// The folder of the programs that were built for this test.
fn built() -> &'static Path {
    let cosmic = Path::new(env!("CARGO_BIN_EXE_cosmic"));
    cosmic.parent().expect("a folder")
}

/// The output of a program for a line of arguments, which must succeed.
#[track_caller]
fn run_of(program: &Path, bench: &Bench, line: &str) -> String {
    let mut command = Command::new(program);
    command.current_dir(bench.path("")).args(line.split(' '));
    let done = command
        .output()
        .unwrap_or_else(|error| panic!("{program:?}: {error}"));
    let [out, err] = [done.stdout, done.stderr].map(|text| String::from_utf8(text).unwrap());
    assert!(done.status.success(), "{program:?} {line}\n{out}\n{err}");
    out
}

/// Settings that make a run of the example's scene short.
const SHORT: &str = "--set physics.steps=64 --set schedule.horizon=[32,32] --set loss.window=16 \
                     --set schedule.attraction_from=3 --set schedule.snap_at=5 --set lattice.rows=3 \
                     --set lattice.columns=3";

/// Optimises, goes on, reports and checks with an example, whose scene sets a key.
fn works(name: &str, sets: &str) {
    let program = built().join("examples").join(name);
    let bench = Bench::default();
    let run = |line: &str| run_of(&program, &bench, line);
    assert!(
        run("scene list").starts_with(name),
        "{name} is the default scene"
    );
    assert!(run("scene default").contains("[physics]"));
    run(&format!("optimize --iterations 6 --out a --quiet {SHORT}"));
    let scene = bench.read("a/scene.toml");
    assert!(scene.contains(sets), "{scene}");
    run(&format!("optimize --iterations 3 --out b --quiet {SHORT}"));
    let check = run(&format!("gradcheck {SHORT}"));
    assert!(check.contains("negative control"), "{check}");
    assert!(run("explain a").contains("computed in every step"));
    run("report a");
    let page = bench.read("a/report.html");
    assert!(page.contains("id=\"stage\""));
    run("evaluate a/design.json --gradient --out results.json");
    run(&format!(
        "sweep plan --seeds 2 --iterations 2 --out s {SHORT}"
    ));
    run("sweep run s");
    run("sweep merge s");
    let results = bench.json("s/results.json");
    assert_eq!(
        results["runs"].as_array().map(Vec::len),
        Some(2),
        "{results}"
    );
    // A program without the law says which one the scene needs.
    let law = sets.split('"').nth(1).expect("a name in quotes");
    for line in ["evaluate a/design.json", "scene check a/scene.toml"] {
        bench.cosmic(line).fails(2, &[law, "of this program"]);
    }
}

#[test]
fn mud_is_a_contact_law() {
    works("mud", "contact = \"mud\"");
}

#[test]
fn wind_is_a_force_in_place_and_time() {
    works("wind", "forces = [\"wind\"]");
}

#[test]
fn magnet_pulls_nodes_of_its_choice() {
    works("magnet", "forces = [\"magnet\"]");
}

#[test]
fn lift_is_an_objective() {
    works("lift", "own_loss = \"lift\"");
}

/// A run with a law that is interrupted goes on to the bytes of one that was not; a program without the
/// law says that it needs it.
#[cfg(unix)]
#[test]
fn a_run_with_a_law_is_resumed() {
    let (program, bench) = (built().join("examples/wind"), Bench::default());
    let steps = SHORT.replace("physics.steps=64", "physics.steps=1024");
    let optimize = |out: &str| format!("optimize --out {out} --quiet {steps}");
    run_of(&program, &bench, &optimize("whole"));
    let mut command = Command::new(&program);
    command
        .current_dir(bench.path(""))
        .args(optimize("part").split_ascii_whitespace());
    let mut child = command.spawn().unwrap();
    bench.await_lines("part/history.jsonl", 20);
    signal(&child, "INT");
    assert_eq!(
        child.wait().unwrap().code(),
        Some(75),
        "it was to be caught on its way"
    );
    bench
        .cosmic("resume part")
        .fails(2, &["\"wind\"", "of this program"]);
    run_of(&program, &bench, "resume part");
    for file in ["design.json", "trajectory.json"] {
        let [part, whole] = ["part", "whole"].map(|run| bench.read(&format!("{run}/{file}")));
        assert_eq!(part, whole, "{file}");
    }
}
