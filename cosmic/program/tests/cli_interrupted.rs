//! Runs that are stopped, killed or damaged, and `cosmic resume`.
#![cfg(unix)]

use crate::background::start;
use crate::common::{Bench, scene};
use crate::program::Told;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output};
use std::thread;
use std::time::{Duration, Instant};

/// Iterations of a run that is long enough to be caught on its way.
const ITERATIONS: usize = 100;

fn slow() -> Bench {
    Bench::new(ITERATIONS, 1024)
}

fn rows(history: &Path) -> usize {
    let bytes = fs::read(history).unwrap_or_default();
    bytes.iter().filter(|&&byte| byte == b'\n').count()
}

/// Waits until a history has so many rows.
fn await_rows(bench: &Bench, run: &str, wanted: usize) {
    let (history, began) = (bench.path(run).join("history.jsonl"), Instant::now());
    while !history.exists() || rows(&history) < wanted {
        // No machine is so slow: something is wrong.
        assert!(
            began.elapsed() < Duration::from_secs(300),
            "{} rows",
            rows(&history)
        );
        thread::sleep(Duration::from_millis(1));
    }
}

fn signal(child: &Child, name: &str) {
    let id = child.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-s", name, &id])
            .status()
            .unwrap()
            .success()
    );
}

/// Begins a run and sends it a signal once it has so many rows; what it said. A run that was
/// finished before it heard is begun again: it is to be caught.
fn caught(bench: &Bench, run: &str, wanted: usize, name: &str) -> Output {
    for _ in 0..20 {
        let child = start(bench, &["optimize", &bench.scene, "--out", run]);
        await_rows(bench, run, wanted);
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        if !bench.path(run).join("summary.json").exists() {
            return output;
        }
        fs::remove_dir_all(bench.path(run)).unwrap();
    }
    panic!("{run} was always finished before it could be stopped");
}

fn resume(bench: &Bench, run: &str) -> Told {
    bench.cosmic(&["resume", run, "--threads", "2"])
}

#[test]
fn a_run_told_to_stop_saves_and_goes_on_to_the_same_bytes() {
    let bench = slow();
    bench.run("whole", &[]);
    for name in ["TERM", "INT"] {
        let output = caught(&bench, name, 20, name);
        assert_eq!((output.status.code(), output.stdout.len()), (Some(75), 0));
        let snapshot = bench.json(&format!("{name}/snapshot.json"));
        let done = snapshot["progress"]["iteration"].as_u64().unwrap();
        // It ends with the iteration that it was at, and loses none.
        assert!((20..=ITERATIONS as u64).contains(&done));
        assert_eq!(rows(&bench.path(name).join("history.jsonl")) as u64, done);
        let error = String::from_utf8(output.stderr).unwrap();
        let how = format!("interrupted after iteration {done}; go on with: cosmic resume {name}\n");
        assert!(error.ends_with(&how), "{error}");
        assert_eq!(resume(&bench, name).code, 0);
        assert_eq!(bench.results(name), bench.results("whole"));
    }
}

#[test]
fn killed_at_any_moment_it_ends_with_the_same_bytes() {
    let bench = slow();
    bench.run("whole", &[]);
    // Before and between snapshots, on one, in the last phase, and around the delivery.
    for wanted in [0, 13, 60, 87, ITERATIONS] {
        let run = wanted.to_string();
        if wanted < ITERATIONS {
            let output = caught(&bench, &run, wanted, "KILL");
            assert_eq!(output.status.code(), None);
        } else {
            let mut child = start(&bench, &["optimize", &bench.scene, "--out", &run]);
            await_rows(&bench, &run, wanted);
            child.kill().unwrap();
            child.wait().unwrap();
        }
        let said = resume(&bench, &run);
        assert_eq!(said.code, 0, "{wanted}: {said:?}");
        assert_eq!(bench.results(&run), bench.results("whole"), "{wanted}");
    }
}

#[test]
fn a_run_with_gradients_in_f32_goes_on_to_the_same_bytes() {
    let more = "[gradient]\nprecision = \"f32\"\n";
    let bench = Bench::with(&(scene(ITERATIONS, 1024, "") + more));
    bench.run("whole", &[]);
    let summary = bench.json("whole/summary.json");
    let departures = summary["departures"].to_string();
    assert!(departures.contains("gradient.precision"), "{departures}");
    // What is delivered is of a rollout in f64, the one of every other command.
    let said = bench.cosmic(&["evaluate", "whole/design.json"]);
    let evaluated: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(
        evaluated["results"]["displacement"],
        summary["displacement_along"]
    );
    caught(&bench, "a", 60, "KILL");
    assert_eq!(resume(&bench, "a").code, 0);
    assert_eq!(bench.results("a"), bench.results("whole"));
    let double = slow();
    double.run("whole", &[]);
    assert_ne!(
        bench.results("whole")["history.jsonl"],
        double.results("whole")["history.jsonl"]
    );
}

#[test]
fn killed_again_and_again_it_ends_with_the_same_bytes() {
    let bench = slow();
    bench.run("whole", &[]);
    let mut child = start(&bench, &["optimize", &bench.scene, "--out", "a"]);
    for wanted in [15, 40, 60] {
        await_rows(&bench, "a", wanted);
        child.kill().unwrap();
        child.wait().unwrap();
        // What a process killed within a write leaves behind.
        if !bench.path("a/summary.json").exists() {
            fs::write(bench.path("a/.cosmic-half"), "{").unwrap();
        }
        child = start(&bench, &["resume", "a", "--threads", "1"]);
    }
    assert!(child.wait().unwrap().success());
    assert_eq!(bench.results("a"), bench.results("whole"));
}

#[test]
fn several_starts_go_on_where_they_were() {
    let bench = slow();
    let all = ["--starts", "2"];
    bench.run("whole", &all);
    for (name, code) in [("KILL", None), ("TERM", Some(75))] {
        let child = start(
            &bench,
            &["optimize", &bench.scene, "--out", name, "--starts", "2"],
        );
        await_rows(&bench, &format!("{name}/starts/1"), 40);
        signal(&child, name);
        assert_eq!(child.wait_with_output().unwrap().status.code(), code);
        assert_eq!(resume(&bench, name).code, 0);
        assert_eq!(bench.results(name), bench.results("whole"));
    }
}

#[test]
fn snapshots_are_never_far_behind() {
    let bench = slow();
    let mut child = start(&bench, &["optimize", &bench.scene, "--out", "a"]);
    let mut checked = 0;
    while child.try_wait().unwrap().is_none() {
        // The history first: the snapshot may move on in between, and is never torn.
        let rows = rows(&bench.path("a/history.jsonl")) as u64;
        if rows > 0 {
            let saved = bench.json("a/snapshot.json")["progress"]["iteration"]
                .as_u64()
                .unwrap();
            // The tenth iteration is in the history just before it is in the snapshot.
            assert!(saved + 10 >= rows, "{saved} saved, {rows} done");
            checked += 1;
        }
    }
    assert!(checked > 0);
}

#[test]
fn a_finished_run_is_left_as_it_is() {
    let bench = Bench::default();
    bench.run("a", &[]);
    bench.run("several", &["--starts", "2"]);
    bench.run("limited", &["--iterations", "5"]);
    for run in ["a", "several", "limited"] {
        let state = || -> Vec<_> {
            let entries = fs::read_dir(bench.path(run))
                .unwrap()
                .map(|entry| entry.unwrap().path());
            let mut files: Vec<_> = entries.filter(|path| path.is_file()).collect();
            files.sort();
            let state = |path: &std::path::PathBuf| {
                (
                    fs::read(path).unwrap(),
                    fs::metadata(path).unwrap().modified().unwrap(),
                )
            };
            files
                .iter()
                .map(|path| (path.clone(), state(path)))
                .collect()
        };
        let before = state();
        let said = bench.cosmic(&["resume", run, "--json"]);
        assert_eq!((said.code, &said.error[..]), (0, ""));
        assert_eq!(
            said.out,
            fs::read_to_string(bench.path(run).join("summary.json")).unwrap()
        );
        assert!(state() == before, "{run}");
    }
}

/// A run that lacks nothing but its summary.
fn nearly_finished() -> Bench {
    let bench = Bench::default();
    bench.run("a", &[]);
    fs::remove_file(bench.path("a/summary.json")).unwrap();
    bench
}

#[test]
fn a_run_killed_before_its_summary_is_delivered_again() {
    let bench = nearly_finished();
    bench.run("whole", &[]);
    fs::remove_file(bench.path("a/scene.toml")).unwrap();
    fs::remove_file(bench.path("a/trajectory.json")).unwrap();
    assert_eq!(resume(&bench, "a").code, 0);
    assert_eq!(bench.results("a"), bench.results("whole"));
}

#[test]
fn a_damaged_snapshot_is_refused_where_it_is_damaged() {
    let bench = nearly_finished();
    let file = bench.path("a/snapshot.json");
    let whole = fs::read_to_string(&file).unwrap();
    let refusal = |text: &str| {
        fs::write(&file, text).unwrap();
        let said = resume(&bench, "a");
        assert_eq!(said.code, 2, "{said:?}");
        said.error
    };
    let position = |column: usize| format!("a/snapshot.json:1:{column}");
    let half = whole.len() / 2;
    assert!(refusal(&whole[..half]).contains(&position(half)));
    assert!(refusal("").contains("a/snapshot.json:1:1"));
    let newer = whole.replacen("\"version\":1", "\"version\":2", 1);
    let error = refusal(&newer);
    assert!(
        error.contains("version 2, not \"cosmic-snapshot\" version 1"),
        "{error}"
    );
    let other = whole.replacen("cosmic-snapshot", "cosmic-summary", 1);
    assert!(refusal(&other).contains("the format is \"cosmic-summary\""));
    let larger = whole.replacen("columns = 3", "columns = 4", 1);
    let error = refusal(&larger);
    assert!(
        error.contains("a/snapshot.json: expected 29 entries in `z`, found 20"),
        "{error}"
    );
    let wrong = whole.replacen("columns = 3", "columns = 1", 1);
    assert!(refusal(&wrong).contains("`lattice.columns` is out of range: 1"));
    fs::remove_file(&file).unwrap();
    let said = resume(&bench, "a");
    assert!(
        said.code == 4 && said.error.contains("a/snapshot.json"),
        "{said:?}"
    );
    assert_eq!(resume(&bench, "no_such_run").code, 4);
}

#[test]
fn a_history_that_lacks_rows_and_another_scene_are_refused() {
    let bench = nearly_finished();
    let history = fs::read_to_string(bench.path("a/history.jsonl")).unwrap();
    let (short, _) = history.trim_end().rsplit_once('\n').unwrap();
    fs::write(bench.path("a/history.jsonl"), short).unwrap();
    let said = resume(&bench, "a");
    assert_eq!(said.code, 2);
    assert!(
        said.error
            .contains("history.jsonl: expected 24 lines up to the snapshot, found 22"),
        "{said:?}"
    );
    fs::write(bench.path("a/history.jsonl"), history).unwrap();
    fs::write(bench.path("a/scene.toml"), "").unwrap();
    let said = resume(&bench, "a");
    assert!(
        said.code == 2 && said.error.contains("not the scene that the run began with"),
        "{said:?}"
    );
}

#[test]
fn a_history_that_is_missing_is_not_made_anew() {
    let bench = nearly_finished();
    // What a run has that is not finished.
    fs::write(bench.path("a/.cosmic-lock"), "").unwrap();
    for name in ["history.jsonl", "history.csv", "designs.jsonl"] {
        let file = bench.path("a").join(name);
        let history = fs::read(&file).unwrap();
        fs::remove_file(&file).unwrap();
        let before = bench.results("a");
        let said = resume(&bench, "a");
        assert_eq!(said.code, 4, "{said:?}");
        assert!(
            said.error.contains(&format!("cannot read a/{name}")),
            "{said:?}"
        );
        assert_eq!(bench.results("a"), before);
        fs::write(&file, history).unwrap();
    }
    assert_eq!(resume(&bench, "a").code, 0);
}

#[test]
fn a_broken_scene_in_a_snapshot_is_told_once_and_by_its_place() {
    let bench = nearly_finished();
    let file = bench.path("a/snapshot.json");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, text.replacen("columns = 3", "columns = = 3", 1)).unwrap();
    let said = resume(&bench, "a");
    assert_eq!(said.code, 2);
    let line = "error: `plan.scene`: the scene, line 4, column 11: not TOML: ";
    assert!(said.error.starts_with(line), "{said:?}");
    assert_eq!(said.error.matches("error:").count(), 1, "{said:?}");
    assert!(said.error.contains(" --> a/snapshot.json:1:"), "{said:?}");
}
