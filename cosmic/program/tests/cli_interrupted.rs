//! Runs that are stopped, killed or damaged, and `cosmic resume`.
#![cfg(unix)]

use crate::background::signal;
use crate::common::{Bench, scene};
use crate::program::Told;
use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::Output;
use std::sync::LazyLock;

/// The number of iterations of a run that is long enough to be interrupted.
const ITERATIONS: usize = 100;

fn slow() -> Bench {
    Bench::new(ITERATIONS, 512)
}

/// The results of the run of [`slow`] without an interruption.
static WHOLE: LazyLock<BTreeMap<String, String>> = LazyLock::new(|| {
    let bench = slow();
    bench.run("whole", "");
    bench.results("whole")
});

/// Waits until a history has the wanted number of rows.
fn await_rows(bench: &Bench, run: &str, wanted: usize) {
    bench.await_lines(&format!("{run}/history.jsonl"), wanted);
}

/// Starts a run and sends it a signal once its history has `wanted` rows. Returns the output of the stopped run. Tries
/// again if the run finishes before the signal.
fn caught(bench: &Bench, run: &str, wanted: usize, name: &str) -> Output {
    for _ in 0..20 {
        let child = bench.start(&format!("optimize tiny.toml --out {run}"));
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
    bench.cosmic(&format!("resume {run} --threads 2"))
}

#[test]
fn an_interrupted_run_saves_and_resumes_to_the_same_bytes() {
    let bench = slow();
    for name in ["TERM", "INT", "USR1"] {
        let output = caught(&bench, name, 20, name);
        assert_eq!((output.status.code(), output.stdout.len()), (Some(75), 0));
        let snapshot = bench.json(&format!("{name}/snapshot.json"));
        let done = snapshot["progress"]["iteration"].as_u64().unwrap();
        // The run finishes its current iteration and loses nothing.
        assert!((20..=ITERATIONS as u64).contains(&done));
        let rows = bench.lines(&format!("{name}/history.jsonl")) as u64;
        assert_eq!(rows, done);
        let error = Told::of(output).error;
        let how =
            format!("interrupted after iteration {done}; continue with: cosmic resume {name}\n");
        assert!(error.ends_with(&how), "{error}");
        resume(&bench, name).ok();
        assert_eq!(bench.results(name), *WHOLE);
    }
}

/// A signal acts inside an iteration, which may take hours. The first signal is answered at once.
#[test]
fn a_signal_acts_inside_a_long_iteration() {
    let bench = Bench::new(4, 200_000);
    let child = bench.start("optimize tiny.toml --out a");
    // The run has begun when its first snapshot is there.
    bench.await_lines("a/snapshot.json", 1);
    signal(&child, "INT");
    let told = Told::of(child.wait_with_output().unwrap());
    let says = "interrupted after iteration 0; continue with: cosmic resume a\n";
    told.fails(75, &["press Ctrl-C again to end now\n", says]);
    assert_eq!(bench.lines("a/history.jsonl"), 0);
    let snapshot = bench.json("a/snapshot.json");
    assert_eq!(snapshot["progress"]["iteration"], 0);
}

/// Before the first result, the user of a large lattice reads what the program does, and can stop it.
#[test]
fn a_large_lattice_is_announced_and_can_be_stopped() {
    let bench = slow();
    let large = "stability --set lattice.columns=40 --set lattice.rows=40";
    for command in ["scene check", "check", "optimize --out a"] {
        let mut child = bench.start(&format!("{command} {large}"));
        let mut line = String::new();
        let mut error = BufReader::new(child.stderr.take().unwrap());
        error.read_line(&mut line).unwrap();
        assert!(
            line.contains("large lattice") && line.ends_with("...\n"),
            "{command}: {line}"
        );
        signal(&child, "INT");
        // A command that went on would end with success, after minutes.
        assert!(!child.wait().unwrap().success(), "{command}");
    }
}

/// The results of a check appear part by part, before the parts that take long.
#[test]
fn a_check_prints_its_parts_when_they_are_done() {
    let bench = slow();
    let mut child = bench.start("check tiny.toml --steps 8 --set physics.steps=64 --stability");
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let lines: Vec<String> = lines
        .map(Result::unwrap)
        .take_while(|line| line != "STABILITY")
        .collect();
    // A hundred robots take longer than the line.
    assert!(child.try_wait().unwrap().is_none());
    for heading in ["PLAN", "GRADIENT", "DISTANCE"] {
        assert!(lines.iter().any(|line| line == heading), "{lines:?}");
    }
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn a_run_killed_at_any_moment_resumes_to_the_same_bytes() {
    let bench = slow();
    // The run is killed before its first snapshot, between two snapshots, at a snapshot, in the last phase, and around
    // the delivery.
    for wanted in [0, 13, 60, 87, ITERATIONS] {
        let run = wanted.to_string();
        if wanted < ITERATIONS {
            let output = caught(&bench, &run, wanted, "KILL");
            assert_eq!(output.status.code(), None);
        } else {
            let mut child = bench.start(&format!("optimize tiny.toml --out {run}"));
            await_rows(&bench, &run, wanted);
            child.kill().unwrap();
            child.wait().unwrap();
        }
        // A process that is killed while it writes leaves a file of this name.
        if !bench.path(&run).join("summary.json").exists() {
            bench.write(&format!("{run}/.cosmic-half"), "{");
        }
        resume(&bench, &run).ok();
        assert_eq!(bench.results(&run), *WHOLE, "{wanted}");
    }
}

/// The default scene optimises in `f32`.
#[test]
fn a_run_with_gradients_in_f32_resumes_to_the_same_bytes() {
    let more = "[gradient]\nprecision = \"f32\"\n";
    let bench = Bench::with(&(scene(ITERATIONS, 512, "") + more));
    bench.run("whole", "");
    caught(&bench, "a", 60, "KILL");
    resume(&bench, "a").ok();
    assert_eq!(bench.results("a"), bench.results("whole"));
    let history = "history.jsonl";
    assert_ne!(bench.results("whole")[history], WHOLE[history]);
}

#[test]
fn several_starts_resume_where_they_were() {
    let bench = slow();
    bench.run("whole", "--starts 2");
    for (name, code) in [("KILL", None), ("TERM", Some(75))] {
        let child = bench.start(&format!("optimize tiny.toml --out {name} --starts 2"));
        await_rows(&bench, &format!("{name}/starts/1"), 40);
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), code);
        if code.is_some() {
            // The message names the folder of the search, not that of a start.
            let error = Told::of(output).error;
            let how = format!("; continue with: cosmic resume {name}\n");
            assert!(error.ends_with(&how), "{error}");
            assert!(!bench.path(name).join("summary.json").exists());
        }
        resume(&bench, name).ok();
        assert_eq!(bench.results(name), bench.results("whole"));
    }
}

#[test]
fn snapshots_are_never_far_behind() {
    let bench = slow();
    let mut child = bench.start("optimize tiny.toml --out a");
    let mut checked = 0;
    while child.try_wait().unwrap().is_none() {
        // The history is read before the snapshot. Otherwise a newer snapshot and a longer history could appear in
        // between.
        let rows = bench.lines("a/history.jsonl") as u64;
        if rows > 0 {
            let snapshot = bench.json("a/snapshot.json");
            let saved = snapshot["progress"]["iteration"].as_u64().unwrap();
            // A snapshot is written at every tenth iteration, slightly later than the row of the history.
            assert!(saved + 10 >= rows, "{saved} saved, {rows} done");
            checked += 1;
        }
    }
    assert!(checked > 0);
}

#[test]
fn resume_does_not_change_a_finished_run() {
    let bench = Bench::finished();
    bench.run("several", "--starts 2");
    bench.run("limited", "--iterations 5");
    for run in ["a", "several", "limited"] {
        let state = || -> BTreeMap<_, _> {
            let entries = fs::read_dir(bench.path(run)).unwrap();
            let paths = entries.map(|entry| entry.unwrap().path());
            let files = paths.filter(|path| path.is_file());
            let state = |path: PathBuf| {
                let modified = fs::metadata(&path).unwrap().modified().unwrap();
                let content = fs::read(&path).unwrap();
                (path, (content, modified))
            };
            files.map(state).collect()
        };
        let before = state();
        let said = bench.ok(&format!("resume {run} --json"));
        assert_eq!(said.error, "");
        assert_eq!(said.out, bench.read(&format!("{run}/summary.json")));
        assert!(state() == before, "{run}");
    }
}
