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

/// Tests an example whose own scene contains the setting `sets`. Asserts that the example can optimise, report and
/// check. Also asserts that the program `cosmic`, which lacks the law or loss, still shows the runs.
fn works(name: &str, sets: &str) {
    let bench = works_with_its_program(name, sets);
    without_it(&bench, sets);
}

/// Tests an example whose own scene contains the setting `sets`: asserts that the example can optimise, report and
/// check.
fn works_with_its_program(name: &str, sets: &str) -> Bench {
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
    has(&scene, &[sets]);
    run(&format!("optimize --iterations 3 --out b --quiet {SHORT}"));
    let check = run(&format!("check {SHORT}"));
    has(&check, &["computed in every step", "negative control"]);
    run("report a");
    let page = bench.read("a/report.html");
    assert!(page.contains("id=\"stage\""));
    run("evaluate a/design.json --gradient --out results.json");
    run(&format!(
        "sweep run --seeds 2 --iterations 2 --out s {SHORT}"
    ));
    let results = bench.read("s/results.csv");
    assert_eq!(results.lines().count(), 3, "{results}");
    bench
}

/// Asserts what the program `cosmic` does with the runs `a` and `b`, which use a law or loss that it lacks. Commands
/// that simulate fail with a single error about that. Other commands still show the runs.
fn without_it(bench: &Bench, sets: &str) {
    let name = sets.split('"').nth(1).expect("a name in quotes");
    for line in ["evaluate a/design.json", "scene check a/scene.toml"] {
        let told = bench.cosmic(line);
        told.fails(2, &[name, "names an unknown"]);
        assert_eq!(told.error.matches("error: ").count(), 1, "{}", told.error);
    }
    let is_law = !sets.starts_with("own_loss");
    let by_its_program = bench.read("a/report.html");
    let energies = "\"energies\":";
    assert!(by_its_program.contains(energies) && !by_its_program.contains("are left out"));
    bench.ok("report a");
    let page = bench.read("a/report.html");
    // The page shows the run's scene, which names the law.
    assert!(page.contains(&sets.replace('"', "&quot;")) || page.contains(sets));
    assert_eq!(page.contains(energies), !is_law);
    let says = format!("because this program does not have the law `{name}`");
    assert_eq!(page.contains(&says), is_law);
    bench.ok("report a/design.json --json");
    let told = bench.ok("report a b --out both.html");
    has(&told.out, &["distance, m"]);
    assert!(bench.read("both.html").contains("\"name\":\"b\""));
    let told = bench.ok("export a --csv --svg");
    assert_eq!(told.error.contains(&says), is_law, "{told:?}");
    let bars = bench.read("a/export/bars.csv");
    let column = bars
        .lines()
        .next()
        .unwrap()
        .split(',')
        .position(|key| key == "peak_force");
    let peak = bars
        .lines()
        .nth(1)
        .unwrap()
        .split(',')
        .nth(column.unwrap())
        .unwrap();
    assert_eq!(peak.is_empty(), is_law, "{bars}");
    if is_law {
        bench.fails("export a --mujoco", 2, &[name, "names an unknown"]);
    }
}

/// One mistake gives one error: if the choice of laws is wrong, there are no further errors about the sections of the
/// laws.
#[test]
fn a_wrong_choice_of_laws_gives_one_error() {
    let bench = Bench::default();
    for (choice, says) in [
        ("contact = 'mud'", "`physics.contact` names an unknown law"),
        (
            "forces = ['stops', 'mud', 'wool']",
            "`physics.forces` names an unknown law",
        ),
        ("forces = ['stops', 'stops']", "names a force twice"),
        ("forces = 'stops'", "is a string"),
    ] {
        let law = if choice.contains("mud") {
            "mud"
        } else {
            "stops"
        };
        let text = format!("[physics]\n{choice}\n[{law}]\nat = 0.3\n");
        bench.write("own.toml", &text);
        let told = bench.cosmic("scene check own.toml");
        told.fails(2, &[says]);
        assert_eq!(told.error.matches("error: ").count(), 1, "{}", told.error);
    }
    // If a section has a mistake of its own, there is a second error.
    bench.write("own.toml", "[physics]\ncontact = 'mud'\n[wool]\nat = 0.3\n");
    let told = bench.cosmic("scene check own.toml");
    assert_eq!(told.error.matches("error: ").count(), 2, "{}", told.error);
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
fn tendon_pulls_along_bars() {
    works("tendon", "forces = [\"tendon\"]");
}

/// The parameters of the policy are keys of the design file. A program without the policy refuses the policy's runs.
#[test]
fn rhythm_is_a_policy() {
    let bench = works_with_its_program("rhythm", "policy = \"rhythm\"");
    let design = bench.json("a/design.json");
    let edges = design["edges"].as_array().map(Vec::len);
    for name in ["sine", "cosine", "shift"] {
        assert_eq!(design["controller"][name].as_array().map(Vec::len), edges);
    }
    let program = built().join("examples/rhythm");
    let line = format!("check {SHORT} --set controller.policy=\"reflex\"");
    has(&run_of(&program, &bench, &line), &["stretch", "touch"]);
    for line in ["evaluate a/design.json", "report a"] {
        let told = bench.cosmic(line);
        told.fails(2, &["names an unknown policy", "rhythm"]);
    }
}

#[test]
fn ride_is_an_objective() {
    works("ride", "own_loss = \"ride\"");
}

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
