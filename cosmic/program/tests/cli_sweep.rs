//! `cosmic sweep`: processes that share the runs.
#![cfg(unix)]

use crate::background::signal;
use crate::common::{Bench, scene};
use crate::program::{Told, command, has};
use std::ffi::OsStr;
use std::fs;

/// The command that does three runs of `tiny.toml` in the folder `s`.
const RUN: &str = "sweep run tiny.toml --seeds 3 --out s";

/// A test folder whose scene takes half a second, so that other processes can come in between.
fn slow() -> Bench {
    Bench::with(&scene(40, 384, ""))
}

/// Asserts that the runs of the sweep `s` have the results of undisturbed runs.
fn has_undisturbed_results(bench: &Bench) {
    bench.ok("sweep merge s --quiet");
    assert_eq!(bench.read("s/results.csv").matches(",done,").count(), 3);
    for seed in ["0", "1", "2"] {
        bench.run(seed, &format!("--seed {seed}"));
        assert_eq!(
            bench.results(&format!("s/runs/tiny-{seed}")),
            bench.results(seed)
        );
    }
}

/// If another process is doing one run, the sweep still does the other runs.
#[test]
fn a_locked_run_does_not_stop_the_other_runs() {
    let bench = Bench::default();
    let run = |index: usize, file: &str| bench.path(&format!("s/runs/tiny-{index}/{file}"));
    bench.ok(&format!("{RUN} --index 2"));
    fs::create_dir_all(run(1, "")).unwrap();
    let lock = fs::File::create(run(1, ".cosmic-lock")).unwrap();
    lock.try_lock().unwrap();
    let said = bench.ok(RUN);
    let says = "other processes are doing 1 of 3 runs\n";
    assert!(said.error.ends_with(says), "{said:?}");
    assert_eq!(said.out, "");
    let said = bench.ok(&format!("{RUN} --index 1"));
    has(
        &said.error,
        &["run 1, tiny seed 1: is being run by another process"],
    );
    drop(lock);
}

/// If the folder of the sweep disappears, the process ends without making it again.
#[test]
fn a_vanished_sweep_ends_the_process() {
    let bench = slow();
    let child = bench.start(&format!("{RUN} --threads 1"));
    bench.await_lines("s/runs/tiny-0/history.jsonl", 1);
    fs::rename(bench.path("s"), bench.path("moved")).unwrap();
    let said = Told::of(child.wait_with_output().unwrap());
    said.fails(4, &["cannot write s/"]);
    assert!(!said.error.contains("of this sweep"), "{said:?}");
    assert!(!bench.path("s").exists());
}

/// A limit on the size of files makes writes fail, as on a full disk.
#[test]
fn a_full_disk_ends_runs_and_loses_nothing() {
    let bench = slow();
    // The limit is 40 blocks of 512 bytes: enough for the scene and the first iterations.
    let full = format!("trap '' XFSZ; ulimit -f 40; exec \"$0\" {RUN} --threads 1");
    let program = command("").get_program().to_owned();
    let said = std::process::Command::new("sh")
        .args([OsStr::new("-c"), OsStr::new(&full), &program])
        .current_dir(bench.path(""))
        .output();
    let says = [
        "run 0, tiny-0: cannot write",
        "2 more runs of this sweep failed",
    ];
    Told::of(said.unwrap()).fails(4, &says);
    bench.ok(RUN);
    has_undisturbed_results(&bench);
}

/// Each run is done by one process, and by another one if the first is killed.
#[test]
fn processes_share_a_sweep_and_take_over_from_killed_ones() {
    let bench = slow();
    let line = format!("{RUN} --threads 1");
    let mut killed = bench.start(&format!("{line} --index 0"));
    bench.await_lines("s/runs/tiny-0/history.jsonl", 0);
    let others = [(); 2].map(|()| bench.start(&line));
    killed.kill().unwrap();
    killed.wait().unwrap();
    let others = others.map(|child| Told::of(child.wait_with_output().unwrap()).ok());
    bench.ok(&line);
    let reports: Vec<&str> = others.iter().flat_map(|told| told.error.lines()).collect();
    for seed in 1..3 {
        let title = format!("  tiny seed {seed}  ");
        let count = reports.iter().filter(|line| line.contains(&title)).count();
        assert_eq!(count, 1, "{reports:?}");
    }
    has_undisturbed_results(&bench);
}

#[test]
fn an_interrupted_sweep_continues() {
    let bench = slow();
    let child = bench.start(&format!("{RUN} --threads 2"));
    bench.await_lines("s/runs/tiny-0/history.jsonl", 1);
    signal(&child, "INT");
    let said = Told::of(child.wait_with_output().unwrap());
    said.fails(75, &["of 3 runs done; repeat the same command to continue"]);
    bench.ok(RUN);
    has_undisturbed_results(&bench);
}
