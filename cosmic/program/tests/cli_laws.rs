//! Tests of the example programs, which add their own laws, losses and scenes.

#[cfg(unix)]
use crate::background::signal;
use crate::common::Bench;
use crate::program::has;
use std::path::Path;
use std::process::Command;

/// The folder with the example programs that were built for this test.
fn built() -> &'static Path {
    let cosmic = Path::new(env!("CARGO_BIN_EXE_cosmic"));
    cosmic.parent().expect("a folder")
}

/// Runs a program with the arguments of a line, which must succeed, and returns its output.
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

/// Settings for a short run of an example's scene.
const SHORT: &str = "--set physics.steps=64 --set schedule.horizon=[32,32] --set loss.window=16 \
                     --set schedule.attraction_from=3 --set schedule.snap_at=5 --set lattice.rows=3 \
                     --set lattice.columns=3";

/// The robot of an objective does what the objective asks for: it walks, and its loss is far below that at rest.
#[test]
fn an_optimisation_improves_an_objective() {
    let bench = Bench::default();
    let program = built().join("examples/ride");
    let settings = "--set lattice.rows=4 --set lattice.columns=4 --set physics.steps=2048 \
                    --set schedule.horizon=[512,1024] --set loss.window=64";
    let line = format!("optimize --iterations 80 --out a --quiet {settings}");
    run_of(&program, &bench, &line);
    let summary = bench.json("a/summary.json");
    let number = |key: &str| summary[key].as_f64().unwrap();
    let [loss, idle] = [number("loss_p50"), number("loss_idle_p50")];
    // Its feet stick, so at rest it covers no distance. It walks 0.56 m in 4 s; other machines may find another robot.
    assert!(idle.abs() < 0.05 && loss < -0.25, "{loss} {idle}");
    assert!(number("displacement_p50") > 0.25, "{summary}");
    let told = run_of(&program, &bench, "resume a");
    has(&told, &["with muscles at rest)"]);
}

/// A run that uses a law of a user's program is interrupted and resumed. It ends with the same bytes as an
/// uninterrupted run. A program without the law reports that the law is missing.
#[cfg(unix)]
#[test]
fn a_run_with_a_law_is_resumed() {
    let (program, bench) = (built().join("examples/wind"), Bench::default());
    let steps = SHORT.replace("physics.steps=64", "physics.steps=512");
    let optimize = |out: &str| format!("optimize --iterations 60 --out {out} --quiet {steps}");
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
        "the run was finished before the signal"
    );
    bench.fails("resume part", 2, &["\"wind\"", "names an unknown"]);
    run_of(&program, &bench, "resume part");
    for file in ["design.json", "trajectory.json"] {
        let [part, whole] = ["part", "whole"].map(|run| bench.read(&format!("{run}/{file}")));
        assert_eq!(part, whole, "{file}");
    }
}
