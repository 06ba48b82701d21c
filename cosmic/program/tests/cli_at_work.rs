//! Two processes and one run's folder: one works, the other is refused and does no harm.
#![cfg(unix)]

use crate::background::start;
use crate::common::Bench;
use std::fs;
use std::process::Output;

/// Has intruders come for as long as the owner of a run is at work; both leave it unharmed.
fn besieged(options: &[&str]) {
    let bench = Bench::new(100, 512);
    let whole = bench.run("whole", options);
    assert!(whole.out.starts_with("run: whole\n"), "{whole:?}");
    let arguments = [&["optimize", &bench.scene, "--out", "a"], options].concat();
    let mut owner = start(&bench, &arguments);
    let mut refused = 0;
    while owner.try_wait().unwrap().is_none() {
        if !bench.path("a/snapshot.json").exists() {
            continue;
        }
        for intruder in [&["resume", "a"][..], &["resume", "a", "--allow-unstable"]] {
            let said = bench.cosmic(intruder);
            if bench.path("a/summary.json").exists() {
                break;
            }
            assert_eq!(said.code, 2, "{said:?}");
            let says = "error: a: another process is at work on this run\n";
            assert_eq!(said.error, says);
            refused += 1;
        }
    }
    let output = owner.wait_with_output().unwrap();
    assert!(output.status.success(), "{output:?}");
    assert!(refused > 0);
    assert!(!bench.path("a/.cosmic-lock").exists());
    assert_eq!(bench.results("a"), bench.results("whole"));
}

#[test]
fn a_run_is_one_process_s() {
    besieged(&[]);
}

#[test]
fn several_starts_are_one_process_s() {
    besieged(&["--starts", "4"]);
}

#[test]
fn of_two_that_begin_at_once_one_has_the_folder() {
    let bench = Bench::new(3, 32);
    for options in [&[][..], &["--starts", "2"]] {
        for _ in 0..20 {
            let begin = |seed| {
                let fixed = ["optimize", &bench.scene, "--out", "a", "--seed", seed];
                start(&bench, &[&fixed[..], options].concat())
            };
            let both = ["0", "7"]
                .map(begin)
                .map(|child| child.wait_with_output().unwrap());
            let code = |output: &Output| output.status.code().unwrap();
            let mut codes = both.each_ref().map(code);
            let winner = codes
                .iter()
                .position(|&code| code == 0)
                .unwrap_or_else(|| panic!("nobody went on: {both:?}"));
            codes.sort_unstable();
            assert_eq!(codes, [0, 2], "{both:?}");
            let seed = bench.json("a/snapshot.json")["plan"]["seed"]
                .as_u64()
                .unwrap();
            assert_eq!(seed, [0, 7][winner]);
            let says = String::from_utf8_lossy(&both[1 - winner].stderr);
            let known = [
                "a: another process is at work",
                "a: the folder is not empty",
            ];
            assert!(known.iter().any(|words| says.contains(words)), "{says}");
            fs::remove_dir_all(bench.path("a")).unwrap();
        }
    }
}
