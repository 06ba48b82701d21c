//! `cosmic sweep`: frozen plans, processes that share the runs, and merged results.
#![cfg(unix)]

use crate::common::{Bench, scene};
use crate::program::{Told, command, has};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;

/// Makes a test folder with a planned sweep `s` of one scene with three seeds. `more` has further options of `sweep
/// plan`.
fn planned(scene: &str, more: &str) -> Bench {
    let bench = Bench::with(scene);
    let said = bench.cosmic(&format!("sweep plan tiny.toml --seeds 3 --out s {more}"));
    assert_eq!(said.ok().out, "s: 3 runs\n");
    bench
}

/// The scene of most tests in this file.
fn small() -> String {
    scene(24, 64, "")
}

/// Returns the counts of waiting, begun, done and diverged runs that `cosmic sweep status` prints.
fn counts(bench: &Bench) -> [u64; 4] {
    let told = bench.ok("sweep status s").out;
    let numbers = told.lines().last().unwrap().split(", ");
    let numbers: Vec<u64> = numbers
        .zip(["waiting", "begun", "done", "diverged"])
        .map(|(count, name)| count.strip_suffix(name).unwrap().trim().parse().unwrap())
        .collect();
    numbers.try_into().unwrap()
}

#[test]
fn sweep_plan_obeys_quiet_and_json() {
    let bench = Bench::default();
    let plan = |how: &str| bench.cosmic(&format!("sweep plan tiny.toml --out {how}"));
    assert_eq!(plan("quiet --seeds 3 --quiet").ok().out, "");
    assert_eq!(plan("one --seeds 1").ok().out, "one: 1 run\n");
    let told = plan("told --seeds 3 --json").json();
    assert_eq!(told, json!({ "sweep": "told", "runs": 3 }));
    for name in ["quiet/plan.json", "told/plan.json"] {
        assert!(bench.path(name).exists());
    }
}

#[test]
fn the_runs_of_a_sweep_equal_those_of_optimize() {
    let bench = planned(&small(), "");
    let said = bench.ok("sweep run s --index 1 --threads 2");
    assert!(said.out.starts_with("run 1, tiny seed 1: "), "{said:?}");
    let said = bench.cosmic("sweep run s --threads 2");
    // Only two runs are reported, because run 1 was already finished.
    assert_eq!((said.code, said.error.lines().count()), (0, 2), "{said:?}");
    assert!(said.error.starts_with("2/3  tiny seed "), "{said:?}");
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
    let sweep = |line: &str| bench.cosmic(&format!("sweep {line}"));
    sweep("plan stiff.toml tiny.toml --seeds 2 --out s").ok();
    let json = sweep("run s --index auto --json").json();
    assert_eq!(json["index"], 2);
    for index in ["all", "auto"] {
        let says = [
            "run 0, stiff-0: after iteration ",
            "\n1 more run of this sweep failed",
        ];
        sweep(&format!("run s --index {index}")).fails(2, &says);
    }
    assert_eq!(counts(&bench), [0, 2, 2, 0]);
}

/// If one run has damaged files, or another process is doing it, the sweep still does the other runs.
#[test]
fn a_faulty_or_locked_run_does_not_stop_the_other_runs() {
    let bench = planned(&small(), "--iterations 4");
    let sweep = |line: &str| bench.cosmic(&format!("sweep {line}"));
    let run = |index: usize, file: &str| bench.path(&format!("s/runs/tiny-{index}/{file}"));
    fs::create_dir_all(run(1, "")).unwrap();
    let lock = fs::File::create(run(1, ".cosmic-lock")).unwrap();
    lock.try_lock().unwrap();
    let said = sweep("run s --index all").ok();
    let says = "other processes are doing 1 of 3 runs\n";
    assert!(said.error.ends_with(says), "{said:?}");
    fs::remove_dir_all(run(0, "")).unwrap();
    fs::create_dir_all(run(0, "")).unwrap();
    fs::write(run(0, "stray"), "").unwrap();
    let said = sweep("run s --index all");
    let says = "error: run 0, tiny-0: s/runs/tiny-0: the folder is not empty, but it does not contain a run";
    said.fails(2, &[says]);
    assert!(!said.error.contains("of this sweep failed"), "{said:?}");
    assert_eq!(counts(&bench), [2, 0, 1, 0]);
    drop(lock);
    sweep("run s --index auto").ok();
    // Run 1 was finished. Now it loses its summary and one of its histories.
    fs::remove_file(run(1, "summary.json")).unwrap();
    fs::remove_file(run(1, "designs.jsonl")).unwrap();
    sweep("run s --index 1").fails(4, &["designs.jsonl"]);
    fs::remove_file(run(0, "stray")).unwrap();
    sweep("run s --index all").fails(4, &["run 1, tiny-1: "]);
    assert_eq!(counts(&bench), [0, 1, 2, 0]);
    // `status` does not read summaries, so it does not notice the damage; `merge` does.
    fs::write(run(2, "summary.json"), "{").unwrap();
    assert_eq!(counts(&bench), [0, 1, 2, 0]);
    sweep("merge s").fails(2, &["tiny-2/summary.json"]);
}

/// Asserts that the runs of the sweep `s` have the results of undisturbed runs.
fn has_undisturbed_results(bench: &Bench) {
    assert_eq!(counts(bench), [0, 0, 3, 0]);
    for seed in ["0", "1", "2"] {
        bench.run(seed, &format!("--seed {seed}"));
        assert_eq!(
            bench.results(&format!("s/runs/tiny-{seed}")),
            bench.results(seed)
        );
    }
}

/// If the folder of a run disappears, this run ends with an error, and the sweep still does the other runs.
#[test]
fn a_vanished_run_folder_ends_only_its_run() {
    let bench = planned(&scene(40, 384, ""), "");
    let child = bench.start("sweep run s --threads 1");
    bench.await_lines("s/runs/tiny-0/history.jsonl", 1);
    fs::rename(bench.path("s/runs/tiny-0"), bench.path("gone")).unwrap();
    let said = Told::of(child.wait_with_output().unwrap());
    said.fails(4, &["run 0, tiny-0: cannot write s/runs/tiny-0"]);
    assert_eq!(counts(&bench), [1, 0, 2, 0]);
    bench.ok("sweep run s");
    has_undisturbed_results(&bench);
}

/// If the folder of the sweep disappears, the process ends without making it again.
#[test]
fn a_vanished_sweep_ends_the_process() {
    let bench = planned(&scene(40, 384, ""), "");
    let child = bench.start("sweep run s --threads 1");
    bench.await_lines("s/runs/tiny-0/history.jsonl", 1);
    fs::rename(bench.path("s"), bench.path("moved")).unwrap();
    let said = Told::of(child.wait_with_output().unwrap());
    said.fails(4, &["cannot write s/"]);
    assert!(!said.error.contains("of this sweep"), "{said:?}");
    assert!(!bench.path("s").exists());
    fs::rename(bench.path("moved"), bench.path("s")).unwrap();
    bench.ok("sweep run s");
    has_undisturbed_results(&bench);
}

/// A limit on the size of files makes writes fail, as on a full disk.
#[test]
fn a_full_disk_ends_runs_and_loses_nothing() {
    let bench = planned(&scene(40, 384, ""), "");
    // The limit is 40 blocks of 512 bytes: enough for the scene and the first iterations.
    let full = "trap '' XFSZ; ulimit -f 40; exec \"$0\" sweep run s --threads 1";
    let program = command("").get_program().to_owned();
    let said = std::process::Command::new("sh")
        .args([OsStr::new("-c"), OsStr::new(full), &program])
        .current_dir(bench.path(""))
        .output();
    let says = [
        "run 0, tiny-0: cannot write",
        "2 more runs of this sweep failed",
    ];
    Told::of(said.unwrap()).fails(4, &says);
    assert_eq!(counts(&bench)[2..], [0, 0]);
    bench.ok("sweep run s");
    has_undisturbed_results(&bench);
}

#[test]
fn warnings_name_their_runs() {
    let unstable = scene(24, 64, "dt = 0.05\nunstable_step = \"warn\"");
    let bench = planned(&unstable, "--iterations 2");
    let said = bench.cosmic("sweep run s --index all");
    let warning = "warning: tiny-1: the time step of 0.05 s is unstable";
    has(&said.error, &[warning]);
    fs::remove_dir_all(bench.path("s/runs")).unwrap();
    let quiet = bench.cosmic("sweep run s --index all --quiet");
    assert!(!quiet.error.contains("warning"), "{quiet:?}");
}

#[test]
fn processes_share_a_sweep_and_no_run_is_done_twice() {
    let bench = planned(&scene(40, 384, ""), "");
    let auto = "sweep run s --index auto --threads 1 --json";
    let children = [(); 2].map(|()| bench.start(auto));
    let both = children.map(|child| Told::of(child.wait_with_output().unwrap()).json());
    let third = bench.cosmic(auto).json();
    let taken = both.iter().chain([&third]);
    let indices: BTreeSet<u64> = taken.map(|said| said["index"].as_u64().unwrap()).collect();
    assert_eq!(indices, BTreeSet::from([0, 1, 2]));
    // Three calls have done all three runs, so a fourth call finds none.
    assert_eq!(bench.cosmic(auto).json()["index"], Value::Null);
}

/// If another process has claimed a run, `sweep run` waits for it. When the claim is given back, it does the run.
#[test]
fn a_sweep_continues_until_no_run_is_unfinished() {
    let bench = planned(&scene(40, 384, ""), "");
    // A claim without content looks as if another host had just made it.
    fs::create_dir_all(bench.path("s/claims/tiny-0")).unwrap();
    bench.write("s/claims/tiny-0/1", String::new());
    let child = bench.start("sweep run s --threads 1");
    bench.await_lines("s/runs/tiny-1/history.jsonl", 0);
    assert!(!bench.path("s/runs/tiny-0").exists());
    bench.write("s/claims/tiny-0/1", "free\n");
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{output:?}");
    assert_eq!(counts(&bench), [0, 0, 3, 0]);
}

#[test]
fn an_edited_plan_is_refused() {
    let bench = planned(&small(), "--iterations 4");
    let plan = bench.read("s/plan.json");
    let edits = [
        (
            "\"iterations\":4",
            "\"iterations\":5",
            "`iterations` is 5, but was 4",
        ),
        ("\"seeds\":3", "\"seeds\":4", "`seeds` is 4, but was 3"),
        (
            "steps = 64",
            "steps = 65",
            "`tiny: physics.steps` is 65, but was 64",
        ),
        (
            "\"cosmic_version\":\"",
            "\"cosmic_version\":\"9.",
            "`cosmic_version` is 9.",
        ),
    ];
    for (old, new, says) in edits {
        let edited = plan.replacen(old, new, 1);
        assert_ne!(edited, plan, "{old}");
        bench.write("s/plan.json", edited);
        for command in ["run", "status", "merge", "prune", "script --slurm"] {
            bench.fails(&format!("sweep {command} s"), 2, &[says, "s/plan.json"]);
        }
    }
    bench.write("s/plan.json", plan);
    let told = bench.cosmic("sweep run s --json").json();
    assert_eq!(told["counts"]["done"], 3);
}

#[test]
fn the_run_of_a_killed_process_is_free() {
    let bench = planned(&scene(100, 256, ""), "");
    let mut child = bench.start("sweep run s --index 0 --quiet");
    bench.await_lines("s/runs/tiny-0/history.jsonl", 0);
    let taken = bench.cosmic("sweep run s --index 0");
    let is_running = child.try_wait().unwrap().is_none();
    // The run is still claimed, unless it has ended in the meantime.
    if is_running {
        taken.fails(2, &["being run by another process"]);
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let said = bench.ok("sweep run s --index auto --threads 2");
    assert!(said.out.starts_with("run 0, "), "{said:?}");
    bench.run("whole", "");
    assert_eq!(bench.results("s/runs/tiny-0"), bench.results("whole"));
}

#[test]
fn status_and_merge_read_the_files_of_the_runs() {
    let bench = planned(&small(), "--iterations 20 --first-seed 7");
    assert_eq!(counts(&bench), [3, 0, 0, 0]);
    bench.ok("sweep run s --index 2");
    assert_eq!(counts(&bench), [2, 0, 1, 0]);
    let said = bench.cosmic("sweep merge s");
    assert_eq!(said.out, "s/results.json\ns/results.csv\n");
    assert_eq!(said.error, "2 of 3 runs are not done\n");
    let results = bench.json("s/results.json");
    assert_eq!(results["format"], "cosmic-sweep-results");
    let run = &results["runs"][2];
    let summary = bench.json("s/runs/tiny-9/summary.json");
    let median = "displacement_p50";
    assert_eq!(run["summary"][median], summary[median]);
    assert_eq!((&run["seed"], &run["iterations"]), (&9.into(), &20.into()));
    assert_eq!(results["runs"][0]["summary"], Value::Null);
    let table = bench.read("s/results.csv");
    let cells: Vec<usize> = table.lines().map(|line| line.split(',').count()).collect();
    assert_eq!(cells, [cells[0]; 4]);
    let last = table.lines().last().unwrap();
    assert!(last.starts_with("2,tiny,9,done,20,"), "{last}");
}

#[test]
fn a_grid_plans_every_combination() {
    let bench = Bench::default();
    let plan = |how: &str| bench.cosmic(&format!("sweep plan tiny.toml {how}"));
    let grid = "--grid physics.gravity=3.7,9.81 --grid schedule.horizon=[16,32],[32,32]";
    let said = plan(&format!("{grid} --seeds 2 --iterations 2 --out s")).ok();
    assert_eq!(said.out, "s: 8 runs\n");
    let planned = bench.json("s/plan.json");
    let scenes = planned["scenes"].as_array().unwrap();
    let names: Vec<_> = scenes.iter().map(|s| s["name"].as_str().unwrap()).collect();
    let expected = [
        "3.7+horizon=16,32",
        "3.7+horizon=32,32",
        "9.81+horizon=16,32",
        "9.81+horizon=32,32",
    ];
    assert_eq!(names, expected.map(|end| format!("tiny+gravity={end}")));
    let text = scenes[1]["scene"].as_str().unwrap();
    assert!(
        text.contains("gravity = 3.7\n") && text.contains("horizon = [32, 32]\n"),
        "{text}"
    );
    assert!(!text.contains('#'), "{text}");
    let said = bench.ok("sweep run s --index 5,0-1 --threads 2");
    assert_eq!(said.error.lines().count(), 3, "{said:?}");
    let told = bench.cosmic("sweep status s --json").json();
    assert_eq!(told["left"], "2-4,6-7");
    assert_eq!(told["runs"][5]["scene"], "tiny+gravity=9.81+horizon=16,32");
    let kept = bench.read("s/runs/tiny+gravity=9.81+horizon=16,32-1/scene.toml");
    has(&kept, &["gravity = 9.81\n"]);
    let text = bench.ok("sweep status s").out;
    has(&text, &["\nleft: 2-4,6-7\n"]);
    has_columns_of_the_grid(&bench, &text);
    for (how, says) in [
        ("--grid physics.dt=0.001,-1", "--set physics.dt=-1"),
        ("--grid physics.gravity", "`=` is missing"),
    ] {
        plan(&format!("{how} --seeds 1 --out t")).fails(2, &[says]);
    }
    assert!(!bench.path("t").exists());
}

/// Asserts that the results have the values of the grid as columns and as keys, so that other programs can plot or fit
/// them.
fn has_columns_of_the_grid(bench: &Bench, status: &str) {
    let row = status.lines().nth(5).unwrap();
    has(
        row,
        &["  physics.gravity = 9.81  schedule.horizon = [16,32]"],
    );
    bench.ok("sweep merge s");
    let swept = &bench.json("s/results.json")["runs"][5]["swept"];
    assert_eq!(
        *swept,
        json!({ "physics.gravity": 9.81, "schedule.horizon": [16, 32] })
    );
    let table = bench.read("s/results.csv");
    let mut rows = table.lines();
    let head = "index,scene,physics.gravity,schedule.horizon,seed,state,iterations,";
    assert!(rows.next().unwrap().starts_with(head), "{table}");
    let row = "5,\"tiny+gravity=9.81+horizon=16,32\",9.81,\"[16,32]\",1,done,2,";
    assert!(rows.nth(5).unwrap().starts_with(row), "{table}");
}

#[test]
fn merged_results_do_not_depend_on_the_order_of_the_runs() {
    let bench = planned(&small(), "--iterations 3");
    bench.ok("sweep plan tiny.toml --seeds 3 --iterations 3 --out t");
    for (sweep, order) in [("s", ["2", "0", "1"]), ("t", ["0", "1", "2"])] {
        for index in order {
            bench.ok(&format!("sweep run {sweep} --index {index}"));
        }
        bench.ok(&format!("sweep merge {sweep}"));
        fs::create_dir(bench.path(&format!("{sweep}-merged"))).unwrap();
        for name in ["results.json", "results.csv"] {
            let [from, to] =
                [sweep.to_owned(), format!("{sweep}-merged")].map(|f| bench.path(&f).join(name));
            fs::rename(from, to).unwrap();
        }
    }
    assert_eq!(bench.results("s-merged"), bench.results("t-merged"));
}

#[test]
fn a_pruned_sweep_has_the_same_results() {
    let bench = planned(&small(), "--iterations 3");
    bench.ok("sweep run s --index 0-1");
    let merged = || {
        bench.ok("sweep merge s");
        ["s/results.json", "s/results.csv"].map(|name| bench.read(name))
    };
    let before = (merged(), bench.cosmic("sweep status s").out);
    let names = [
        "trajectory.json",
        "history.jsonl",
        "designs.jsonl",
        "snapshot.json",
    ];
    let size = |run: &str, name: &str| {
        fs::metadata(bench.path(&format!("s/runs/{run}/{name}"))).map(|m| m.len())
    };
    let bytes: u64 = names
        .iter()
        .map(|name| size("tiny-0", name).unwrap() + size("tiny-1", name).unwrap())
        .sum();
    let told = bench.cosmic("sweep prune s --json").json();
    assert_eq!(told, json!({ "runs": 2, "bytes": bytes }));
    assert!(names.iter().all(|name| size("tiny-0", name).is_err()));
    assert!(size("tiny-1", "design.json").is_ok());
    assert_eq!((merged(), bench.cosmic("sweep status s").out), before);
    assert_eq!(bench.cosmic("sweep prune s").out, "0 runs, 0 bytes\n");
    // No run is repeated.
    let said = bench.ok("sweep run s");
    assert_eq!(said.error.lines().count(), 1, "{said:?}");
}

#[test]
fn a_diverged_run_counts_as_done() {
    let bench = Bench::with(&scene(8, 64, "dt = 1.0\nunstable_step = \"warn\""));
    bench.ok("sweep plan tiny.toml --seeds 1 --out s");
    let said = bench.ok("sweep run s --index all");
    has(&said.error, &["diverged in step"]);
    assert_eq!(counts(&bench), [0, 0, 0, 1]);
    let said = bench.cosmic("sweep run s --index auto");
    assert_eq!(
        said.out,
        "each run is finished or is being done by another process\n"
    );
}

#[test]
fn wrong_arguments_of_sweep_are_refused() {
    let bench = planned(&small(), "");
    for (line, code, says) in [
        (
            "plan tiny.toml --seeds 1 --out s",
            2,
            "s: the folder is not empty",
        ),
        (
            "plan tiny.toml tiny.toml --seeds 1 --out t",
            2,
            "two scenes have the name `tiny`",
        ),
        (
            "run s --index 3",
            2,
            "there is no run 3: the plan has 3 runs",
        ),
        (
            "run s --index 0-1,3",
            2,
            "there is no run 3: the plan has 3 runs",
        ),
        ("run s --index some", 2, "expected the number of a run"),
        (
            "plan tiny.toml --seeds 99999999999 --out u",
            2,
            "99999999999 runs (scenes x seeds: 1 x 99999999999) are too many; at most 1000000 are",
        ),
        ("status nowhere", 4, "nowhere/plan.json"),
    ] {
        bench.fails(&format!("sweep {line}"), code, &[says]);
    }
    assert!(!bench.path("u").exists());
}
