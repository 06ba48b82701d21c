//! Two processes use the folder of one run. One of them does the run. The other is refused and changes nothing.
#![cfg(unix)]

use crate::common::Bench;
use crate::program::Told;
use std::fs;

/// Asserts that other processes cannot resume a run while its owner works, and that their attempts do not change it.
fn besieged(options: &str) {
    let bench = Bench::new(100, 256);
    let whole = bench.run("whole", options);
    assert!(whole.out.starts_with("run: whole\n"), "{whole:?}");
    let mut owner = bench.start(&format!("optimize tiny.toml --out a {options}"));
    let (mut refused, mut looked) = (0, 0);
    while owner.try_wait().unwrap().is_none() {
        if !bench.path("a/snapshot.json").exists() {
            continue;
        }
        for intruder in ["resume a", "resume a --allow-unstable"] {
            let said = bench.cosmic(intruder);
            if bench.path("a/summary.json").exists() {
                break;
            }
            let says = "error: a: another process is running this run\n";
            assert_eq!((said.code, &said.error[..]), (2, says));
            refused += 1;
        }
        let said = bench.cosmic("report a a");
        if !bench.path("a/summary.json").exists() {
            said.fails(4, &["the run is not finished: a process is doing it"]);
            looked += 1;
        }
    }
    Told::of(owner.wait_with_output().unwrap()).ok();
    assert!(refused > 0 && looked > 0);
    assert!(!bench.path("a/.cosmic-lock").exists());
    assert_eq!(bench.results("a"), bench.results("whole"));
}

#[test]
fn a_run_belongs_to_one_process() {
    besieged("");
}

#[test]
fn several_starts_belong_to_one_process() {
    besieged("--starts 4");
}

#[test]
fn of_two_simultaneous_runs_one_gets_the_folder() {
    let bench = Bench::new(3, 32);
    for options in ["", "--starts 2"] {
        for _ in 0..4 {
            let both = [0, 7].map(|seed| {
                let line = format!("optimize tiny.toml --out a --seed {seed} {options}");
                bench.start(&line)
            });
            let both = both.map(|child| Told::of(child.wait_with_output().unwrap()));
            let (winner, loser) = match both.each_ref().map(|told| told.code) {
                [0, 2] => (0, &both[1]),
                [2, 0] => (7, &both[0]),
                _ => panic!("{both:?}"),
            };
            let snapshot = bench.json("a/snapshot.json");
            assert_eq!(snapshot["plan"]["seed"], winner);
            let known = [
                "a: another process is running this run",
                "a: the folder is not empty",
            ];
            let is_known = known.iter().any(|words| loser.error.contains(words));
            assert!(is_known, "{loser:?}");
            fs::remove_dir_all(bench.path("a")).unwrap();
        }
    }
}
