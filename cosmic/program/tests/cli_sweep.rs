//! `cosmic sweep`: processes that share the runs, and merged results.
#![cfg(unix)]

use crate::background::signal;
use crate::common::{Bench, scene};
use crate::program::{Told, command, has};
use serde_json::{Value, json};
use std::ffi::OsStr;
use std::fs;

/// The command that does three runs of `tiny.toml` in the folder `s`.
const RUN: &str = "sweep run tiny.toml --seeds 3 --out s";

/// A test folder whose scene takes half a second, so that other processes can come in between.
fn slow() -> Bench {
    Bench::with(&scene(40, 384, ""))
}

/// Returns the states of the runs in the order of their numbers.
fn states(bench: &Bench) -> Vec<String> {
    bench.ok("sweep merge s --quiet");
    let table = bench.read("s/results.csv");
    let mut rows = table.lines().map(|line| line.split(','));
    let column = rows.next().unwrap().position(|name| name == "state");
    let state = |mut row: std::str::Split<char>| row.nth(column.unwrap()).unwrap().to_owned();
    rows.map(state).collect()
}

/// Asserts that the runs of the sweep `s` have the results of undisturbed runs.
fn has_undisturbed_results(bench: &Bench) {
    assert_eq!(states(bench), ["done"; 3]);
    for seed in ["0", "1", "2"] {
        bench.run(seed, &format!("--seed {seed}"));
        assert_eq!(
            bench.results(&format!("s/runs/tiny-{seed}")),
            bench.results(seed)
        );
    }
}

#[test]
fn the_runs_of_a_sweep_equal_those_of_optimize() {
    let bench = Bench::default();
    let said = bench.ok(&format!("{RUN} --index 1 --threads 2"));
    has(&said.error, &["run 1, tiny seed 1: "]);
    assert_eq!(
        (said.out, states(&bench)[1..].to_vec()),
        (
            String::new(),
            vec!["done".to_owned(), "unfinished".to_owned()]
        )
    );
    let said = bench.ok(&format!("{RUN} --threads 2"));
    // Only two runs are reported, because run 1 was already finished.
    assert_eq!(said.error.lines().count(), 2, "{said:?}");
    assert!(said.error.starts_with("2/3  tiny seed "), "{said:?}");
    // When all runs are done, they are merged.
    assert_eq!(said.out, bench.ok("sweep merge s").out);
    has(&said.out, &["trial  ", "\ntiny   ", "\ns/results.csv\n"]);
    has_undisturbed_results(&bench);
}

/// If the scene of one run is refused, the sweep still does the other runs. In this scene, the snap makes all edges
/// skeleton, which is too stiff for the time step.
#[test]
fn a_refused_scene_does_not_stop_the_other_runs() {
    let bench = Bench::default();
    let stiff = scene(24, 64, "dt = 0.0045")
        .replace("columns = 3\nrows = 3", "columns = 2\nrows = 2")
        .replace(
            "[volume]\n",
            "[volume]\nsolid = [1.0, 1.0]\nactuator = [0.0, 0.0]\n",
        );
    bench.write("stiff.toml", stiff);
    let says = [
        "run 0, stiff-0: after iteration ",
        "\n1 more run of this sweep failed",
    ];
    let line = "sweep run stiff.toml tiny.toml --seeds 2 --out s";
    bench.fails(line, 2, &says);
    assert_eq!(states(&bench), ["unfinished", "unfinished", "done", "done"]);
    bench.fails(&format!("{line} --index 0"), 2, &["after iteration "]);
    bench.ok(&format!("{line} --index 3"));
}

/// If one run has damaged files, or another process is doing it, the sweep still does the other runs.
#[test]
fn a_faulty_or_locked_run_does_not_stop_the_other_runs() {
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
    fs::remove_dir_all(run(0, "")).unwrap();
    fs::create_dir_all(run(0, "")).unwrap();
    fs::write(run(0, "stray"), "").unwrap();
    let said = bench.cosmic(RUN);
    let says = "error: run 0, tiny-0: s/runs/tiny-0: the folder is not empty, but it does not contain a run";
    said.fails(2, &[says]);
    assert!(!said.error.contains("of this sweep failed"), "{said:?}");
    assert_eq!(states(&bench), ["unfinished", "done", "done"]);
    fs::write(run(2, "summary.json"), "{").unwrap();
    bench.fails("sweep merge s", 2, &["tiny-2/summary.json"]);
}

/// If the folder of a run disappears, this run ends with an error, and the sweep still does the other runs.
#[test]
fn a_vanished_run_folder_ends_only_its_run() {
    let bench = slow();
    let child = bench.start(&format!("{RUN} --threads 1"));
    bench.await_lines("s/runs/tiny-0/history.jsonl", 1);
    fs::rename(bench.path("s/runs/tiny-0"), bench.path("gone")).unwrap();
    let said = Told::of(child.wait_with_output().unwrap());
    said.fails(4, &["run 0, tiny-0: cannot write s/runs/tiny-0"]);
    assert_eq!(states(&bench), ["unfinished", "done", "done"]);
    bench.ok(RUN);
    has_undisturbed_results(&bench);
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

#[test]
fn warnings_name_their_runs() {
    let bench = Bench::with(&scene(24, 64, "dt = 0.05\nunstable_step = \"warn\""));
    let line = format!("{RUN} --iterations 2");
    let warning = "warning: tiny-1: the time step of 0.05 s is unstable";
    has(&bench.cosmic(&line).error, &[warning]);
    fs::remove_dir_all(bench.path("s/runs")).unwrap();
    let quiet = bench.cosmic(&format!("{line} --quiet"));
    assert!(!quiet.error.contains("warning"), "{quiet:?}");
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

#[test]
fn results_have_the_summaries_and_the_values_of_the_grid() {
    let bench = Bench::default();
    let grid = "--set physics.gravity=3.7,9.81 --set schedule.horizon=[16,32],[32,32] --set controller.hidden=3";
    let line =
        format!("sweep run tiny.toml {grid} --seeds 2 --first-seed 7 --iterations 2 --out s");
    for index in ["5", "0"] {
        bench.ok(&format!("{line} --index {index}"));
    }
    let told = bench.cosmic("sweep merge s --json").json();
    assert_eq!(
        (&told["missing"], &told["results"]),
        (&json!(6), &json!("s/results.csv"))
    );
    let run = "tiny+gravity=9.81+horizon=16,32";
    assert_eq!(told["trials"][2]["trial"], run);
    let summary = bench.json(&format!("s/runs/{run}-8/summary.json"));
    let median = &summary["displacement_robust_p50"];
    let trial = &told["trials"][2];
    assert_eq!((&trial["median"], &trial["runs"]), (median, &json!(1)));
    assert_eq!(told["trials"][1]["median"], Value::Null);
    let table = bench.read("s/results.csv");
    let mut rows = table.lines();
    let head =
        "index,trial,physics.gravity,schedule.horizon,seed,state,iterations,displacement_p50,";
    assert!(rows.next().unwrap().starts_with(head), "{table}");
    let (row, begins) = (
        rows.nth(5).unwrap(),
        format!("5,\"{run}\",9.81,\"[16,32]\",8,done,2,"),
    );
    let numbers = row.strip_prefix(&begins).expect(row);
    let first = numbers.split(',').next().unwrap().parse().ok();
    assert_eq!(first, summary["displacement_p50"].as_f64(), "{table}");
    let kept = bench.read(&format!("s/runs/{run}-8/scene.toml"));
    has(&kept, &["gravity = 9.81\n", "hidden = 3\n"]);
}

#[test]
fn merged_results_do_not_depend_on_the_order_of_the_runs() {
    let bench = Bench::default();
    let line = |out: &str| format!("sweep run tiny.toml --seeds 3 --iterations 3 --out {out}");
    for index in ["2", "0", "1"] {
        bench.ok(&format!("{} --index {index}", line("s")));
    }
    bench.ok(&line("t"));
    for out in ["s/runs", "t/runs"] {
        fs::remove_dir_all(bench.path(out)).unwrap();
    }
    assert_eq!(bench.results("s"), bench.results("t"));
}

#[test]
fn a_file_compares_with_published_numbers() {
    let bench = Bench::default();
    let trials = "[[trials]]\nscene = 'tiny.toml'\ntitle = 'a walker'\npublished = 0.5\n\
                  [[trials]]\nname = 'moon'\nscene = 'tiny.toml'\nsettings.physics.gravity = 1.62\n";
    bench.write("two.toml", format!("seeds = 2\niterations = 2\n{trials}"));
    let told = bench.ok("sweep run two.toml --out s").out;
    let heads = "trial     published  median     ±  median / published";
    has(
        &told,
        &[heads, "\na walker       0.50  ", "\nmoon              –  "],
    );
    bench.fails(
        "sweep run two.toml tiny.toml --out t",
        2,
        &["two.toml", "trials"],
    );
}

#[test]
fn a_diverged_run_counts_as_done() {
    let bench = Bench::with(&scene(8, 64, "dt = 1.0\nunstable_step = \"warn\""));
    let said = bench.ok("sweep run tiny.toml --out s");
    has(&said.error, &["diverged in step"]);
    assert_eq!(states(&bench), ["diverged"]);
    let said = bench.ok("sweep run tiny.toml --out s --index 0");
    has(&said.error, &["run 0, tiny seed 0: was done before"]);
}

#[test]
fn wrong_arguments_of_sweep_are_refused() {
    let bench = Bench::default();
    for (line, code, says) in [
        ("run tiny.toml", 2, "--out <S>"),
        (
            "run tiny.toml tiny.toml --out s",
            2,
            "two trials have the name `tiny`",
        ),
        (
            "run tiny.toml --out s --index 1",
            2,
            "there is no run 1; the runs of this sweep have the numbers 0 to 0",
        ),
        (
            "run tiny.toml --out s --index some",
            2,
            "invalid value 'some'",
        ),
        (
            "run tiny.toml --out s --set physics.dt=0.001,-1",
            2,
            "--set physics.dt=-1",
        ),
        (
            "run tiny.toml --out s --set physics.dt",
            2,
            "`=` is missing",
        ),
        ("run stabilty --out s", 4, "did you mean `stability`?"),
        ("merge nowhere", 4, "nowhere/sweep.json"),
    ] {
        bench.fails(&format!("sweep {line}"), code, &[says]);
    }
    assert!(!bench.path("s").exists());
}
