//! `cosmic sweep` as a user meets it: a frozen plan, runs shared by processes, merged results.
#![cfg(unix)]

use crate::background::start;
use crate::common::{Bench, scene};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::thread;
use std::time::{Duration, Instant};

/// A sweep of the bench's scene over three seeds, planned.
fn planned(bench: &Bench, more: &[&str]) {
    let scene = &bench.scene;
    let arguments = [
        &["sweep", "plan", scene, "--seeds", "3", "--out", "s"],
        more,
    ]
    .concat();
    let said = bench.cosmic(&arguments);
    assert_eq!((said.code, &said.out[..]), (0, "s: 3 runs\n"), "{said:?}");
}

#[test]
fn a_plan_speaks_as_it_is_asked_to() {
    let bench = Bench::default();
    let plan = |out: &str, how: &[&str]| {
        let plan = ["sweep", "plan", &bench.scene, "--out", out];
        bench.cosmic(&[&plan, how].concat())
    };
    let quiet = plan("quiet", &["--seeds", "3", "--quiet"]);
    assert_eq!((quiet.code, &quiet.out[..]), (0, ""), "{quiet:?}");
    let one = plan("one", &["--seeds", "1"]);
    assert_eq!((one.code, &one.out[..]), (0, "one: 1 run\n"), "{one:?}");
    let said = plan("told", &["--seeds", "3", "--json"]);
    let json: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(json, serde_json::json!({ "sweep": "told", "runs": 3 }));
    for name in ["quiet", "told"] {
        assert!(bench.path(name).join("plan.json").exists());
    }
}

fn await_file(bench: &Bench, name: &str) {
    let began = Instant::now();
    while !bench.path(name).exists() {
        // No machine is so slow: something is wrong.
        assert!(began.elapsed() < Duration::from_secs(300), "no {name}");
        thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_sweep_s_runs_are_those_of_optimize() {
    let bench = Bench::default();
    planned(&bench, &[]);
    let said = bench.cosmic(&["sweep", "run", "s", "--index", "1", "--threads", "2"]);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.starts_with("run 1, tiny seed 1: "), "{said:?}");
    let said = bench.cosmic(&["sweep", "run", "s", "--threads", "2"]);
    // The one that is done is not done again.
    assert_eq!((said.code, said.error.lines().count()), (0, 2), "{said:?}");
    assert!(said.error.starts_with("2/3  tiny seed "), "{said:?}");
    for seed in ["0", "1", "2"] {
        bench.run(seed, &["--seed", seed]);
        assert_eq!(
            bench.results(&format!("s/runs/tiny-{seed}")),
            bench.results(seed)
        );
    }
}

/// What is wrong with one scene is no reason not to do the others. All edges of this one become
/// skeleton at the snap, too stiff for its time step.
#[test]
fn runs_that_cannot_be_done_are_passed_over() {
    let bench = Bench::default();
    let stiff = scene(24, 64, "dt = 0.0045")
        .replace("columns = 3\nrows = 3", "columns = 2\nrows = 2")
        .replace(
            "[volume]\n",
            "[volume]\nsolid = [1.0, 1.0]\nactuator = [0.0, 0.0]\n",
        );
    fs::write(bench.path("stiff.toml"), stiff).unwrap();
    let sweep = |arguments: &str| {
        let arguments: Vec<&str> = ["sweep"].into_iter().chain(arguments.split(' ')).collect();
        bench.cosmic(&arguments)
    };
    let said = sweep("plan stiff.toml tiny.toml --seeds 2 --out s");
    assert_eq!(said.code, 0, "{said:?}");
    let said = sweep("run s --index auto --json");
    let json: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(
        (said.code, &json["index"]),
        (0, &Value::from(2)),
        "{said:?}"
    );
    for index in ["all", "auto"] {
        let said = sweep(&format!("run s --index {index}"));
        assert_eq!(said.code, 2, "{said:?}");
        let says = "run 0, stiff-0: after iteration ";
        assert!(said.error.contains(says), "{said:?}");
        assert!(
            said.error.contains("\n1 more of this sweep cannot"),
            "{said:?}"
        );
    }
    let status = sweep("status s").out;
    assert!(
        status.ends_with("0 waiting, 2 begun, 2 done, 0 diverged\n"),
        "{status}"
    );
}

/// Nor is what has become of one run's files, or who works on it.
#[test]
fn troubles_of_one_run_do_not_keep_from_the_others() {
    let bench = Bench::default();
    planned(&bench, &["--iterations", "4"]);
    let sweep = |arguments: &str| {
        let arguments: Vec<&str> = ["sweep"].into_iter().chain(arguments.split(' ')).collect();
        bench.cosmic(&arguments)
    };
    let run = |index: usize, file: &str| bench.path(&format!("s/runs/tiny-{index}/{file}"));
    fs::create_dir_all(run(1, "")).unwrap();
    let lock = fs::File::create(run(1, ".cosmic-lock")).unwrap();
    lock.try_lock().unwrap();
    let said = sweep("run s --index all");
    let says = "1 of 3 runs are at work in other processes\n";
    assert!(said.code == 0 && said.error.ends_with(says), "{said:?}");
    fs::remove_dir_all(run(0, "")).unwrap();
    fs::create_dir_all(run(0, "")).unwrap();
    fs::write(run(0, "stray"), "").unwrap();
    let said = sweep("run s --index all");
    assert_eq!(said.code, 2, "{said:?}");
    let says = "error: run 0, tiny-0: s/runs/tiny-0: the folder is not empty, and no run is in it";
    assert!(said.error.contains(says), "{said:?}");
    assert!(!said.error.contains("more of this sweep"), "{said:?}");
    let ends = |said: &str, counts: &str| assert!(said.ends_with(counts), "{said}");
    ends(
        &sweep("status s").out,
        "2 waiting, 0 begun, 1 done, 0 diverged\n",
    );
    drop(lock);
    assert_eq!(sweep("run s --index auto").code, 0);
    // One that went on to its end and lost it again, with a row that it needs.
    fs::remove_file(run(1, "summary.json")).unwrap();
    fs::remove_file(run(1, "history.csv")).unwrap();
    let said = sweep("run s --index 1");
    assert!(
        said.code == 4 && said.error.contains("history.csv"),
        "{said:?}"
    );
    fs::remove_file(run(0, "stray")).unwrap();
    let said = sweep("run s --index all");
    assert!(
        said.code == 4 && said.error.contains("run 1, tiny-1: "),
        "{said:?}"
    );
    ends(
        &sweep("status s").out,
        "0 waiting, 1 begun, 2 done, 0 diverged\n",
    );
    // What nobody reads harms nobody.
    fs::write(run(2, "summary.json"), "{").unwrap();
    ends(
        &sweep("status s").out,
        "0 waiting, 1 begun, 2 done, 0 diverged\n",
    );
    let said = sweep("merge s");
    assert!(
        said.code == 2 && said.error.contains("tiny-2/summary.json"),
        "{said:?}"
    );
}

#[test]
fn warnings_name_their_runs() {
    let bench = Bench::with(&scene(24, 64, "dt = 0.05\nunstable_step = \"warn\""));
    planned(&bench, &["--iterations", "2"]);
    let all = ["sweep", "run", "s", "--index", "all"];
    let said = bench.cosmic(&all);
    let warning = "warning: tiny-1: the time step of 0.05 s is unstable";
    assert!(said.error.contains(warning), "{said:?}");
    fs::remove_dir_all(bench.path("s/runs")).unwrap();
    let quiet = bench.cosmic(&[&all[..], &["--quiet"]].concat());
    assert!(!quiet.error.contains("warning"), "{quiet:?}");
}

#[test]
fn json_is_written_of_all_runs_too() {
    let bench = Bench::default();
    planned(&bench, &[]);
    let said = bench.cosmic(&["sweep", "run", "s", "--index", "all", "--json"]);
    let json: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!((said.code, &json["counts"]["done"]), (0, &Value::from(3)));
}

#[test]
fn processes_share_a_sweep_and_no_run_is_done_twice() {
    let bench = Bench::new(40, 512);
    planned(&bench, &[]);
    let auto = [
        "sweep",
        "run",
        "s",
        "--index",
        "auto",
        "--threads",
        "1",
        "--json",
    ];
    let children = [(); 2].map(|()| start(&bench, &auto));
    let mut taken: Vec<Value> = children
        .into_iter()
        .map(|child| {
            let output = child.wait_with_output().unwrap();
            assert!(output.status.success(), "{output:?}");
            serde_json::from_slice(&output.stdout).unwrap()
        })
        .collect();
    for _ in 0..2 {
        let said = bench.cosmic(&auto);
        taken.push(serde_json::from_str(&said.out).unwrap());
    }
    // The fourth finds nothing left.
    assert_eq!(taken[3]["index"], Value::Null);
    let indices: BTreeSet<u64> = (taken[..3].iter())
        .map(|said| said["index"].as_u64().unwrap())
        .collect();
    assert_eq!(indices, BTreeSet::from([0, 1, 2]));
}

/// A run that is taken at first, and given back while the others are at work.
#[test]
fn a_sweep_goes_on_until_nothing_is_left() {
    let bench = Bench::new(40, 512);
    planned(&bench, &[]);
    fs::create_dir_all(bench.path("s/claims")).unwrap();
    let claim = fs::File::create(bench.path("s/claims/tiny-0")).unwrap();
    claim.try_lock().unwrap();
    let child = start(&bench, &["sweep", "run", "s", "--threads", "1"]);
    await_file(&bench, "s/runs/tiny-1/history.jsonl");
    assert!(!bench.path("s/runs/tiny-0").exists());
    drop(claim);
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let said = bench.cosmic(&["sweep", "status", "s"]).out;
    assert!(
        said.ends_with("0 waiting, 0 begun, 3 done, 0 diverged\n"),
        "{said}"
    );
}

#[test]
fn an_edited_plan_is_refused() {
    let bench = Bench::default();
    planned(&bench, &["--iterations", "4"]);
    assert_eq!(bench.cosmic(&["sweep", "run", "s", "--index", "0"]).code, 0);
    let plan = fs::read_to_string(bench.path("s/plan.json")).unwrap();
    let edits = [
        (
            "\"iterations\":4",
            "\"iterations\":5",
            "`iterations` is 5, where it was 4",
        ),
        ("\"seeds\":3", "\"seeds\":4", "`seeds` is 4, where it was 3"),
        (
            "steps = 64",
            "steps = 65",
            "`tiny: physics.steps` is 65, where it was 64",
        ),
    ];
    for (old, new, says) in edits {
        let edited = plan.replacen(old, new, 1);
        assert_ne!(edited, plan, "{old}");
        fs::write(bench.path("s/plan.json"), edited).unwrap();
        for command in ["run", "status", "merge"] {
            let said = bench.cosmic(&["sweep", command, "s"]);
            assert!(
                said.code == 2 && said.error.contains(says) && said.error.contains("s/plan.json"),
                "{said:?}"
            );
        }
    }
    fs::write(bench.path("s/plan.json"), plan).unwrap();
    assert_eq!(bench.cosmic(&["sweep", "run", "s"]).code, 0);
}

#[test]
fn a_killed_process_gives_its_run_back() {
    let bench = Bench::new(100, 1024);
    planned(&bench, &[]);
    let mut child = start(&bench, &["sweep", "run", "s", "--index", "0", "--quiet"]);
    await_file(&bench, "s/runs/tiny-0/history.jsonl");
    let taken = bench.cosmic(&["sweep", "run", "s", "--index", "0"]);
    let is_running = child.try_wait().unwrap().is_none();
    // Unless it ended meanwhile, the run is not to be had.
    assert!(!is_running || taken.code == 2, "{taken:?}");
    if is_running {
        assert!(
            taken.error.contains("at work in another process"),
            "{taken:?}"
        );
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let said = bench.cosmic(&["sweep", "run", "s", "--index", "auto", "--threads", "2"]);
    assert!(
        said.code == 0 && said.out.starts_with("run 0, "),
        "{said:?}"
    );
    bench.run("whole", &[]);
    assert_eq!(bench.results("s/runs/tiny-0"), bench.results("whole"));
}

#[test]
fn status_and_merge_read_what_is_there() {
    let bench = Bench::default();
    planned(&bench, &["--iterations", "20", "--first-seed", "7"]);
    let last = |out: &str| out.lines().last().unwrap().to_owned();
    let status = || bench.cosmic(&["sweep", "status", "s"]).out;
    assert_eq!(last(&status()), "3 waiting, 0 begun, 0 done, 0 diverged");
    assert_eq!(bench.cosmic(&["sweep", "run", "s", "--index", "2"]).code, 0);
    assert_eq!(last(&status()), "2 waiting, 0 begun, 1 done, 0 diverged");
    let said = bench.cosmic(&["sweep", "merge", "s"]);
    assert_eq!(said.out, "s/results.json\ns/results.csv\n");
    assert_eq!(said.error, "2 of 3 runs are not done\n");
    let results = bench.json("s/results.json");
    assert_eq!(results["format"], "cosmic-sweep-results");
    let run = &results["runs"][2];
    let summary = bench.json("s/runs/tiny-9/summary.json");
    assert_eq!(
        run["summary"]["displacement_p50"],
        summary["displacement_p50"]
    );
    assert_eq!((&run["seed"], &run["iterations"]), (&9.into(), &20.into()));
    assert_eq!(results["runs"][0]["summary"], Value::Null);
    let table = fs::read_to_string(bench.path("s/results.csv")).unwrap();
    let cells: Vec<usize> = table.lines().map(|line| line.split(',').count()).collect();
    assert_eq!(cells, [cells[0]; 4]);
    assert!(
        table
            .lines()
            .nth(3)
            .unwrap()
            .starts_with("2,tiny,9,done,20,")
    );
}

#[test]
fn a_diverged_run_is_over() {
    let bench = Bench::with(&scene(8, 64, "dt = 1.0\nunstable_step = \"warn\""));
    let said = bench.cosmic(&["sweep", "plan", &bench.scene, "--seeds", "1", "--out", "s"]);
    assert_eq!(said.code, 0, "{said:?}");
    let said = bench.cosmic(&["sweep", "run", "s", "--index", "all"]);
    assert!(
        said.code == 0 && said.error.contains("diverged in step"),
        "{said:?}"
    );
    let said = bench.cosmic(&["sweep", "status", "s"]);
    assert!(
        said.out
            .ends_with("0 waiting, 0 begun, 0 done, 1 diverged\n"),
        "{said:?}"
    );
    let said = bench.cosmic(&["sweep", "run", "s", "--index", "auto"]);
    assert_eq!(said.out, "nothing is left to take\n");
}

#[test]
fn what_cannot_be_is_refused() {
    let bench = Bench::default();
    planned(&bench, &[]);
    let refusal = |arguments: &[&str], code: i32| {
        let said = bench.cosmic(&[&["sweep"], arguments].concat());
        assert_eq!(said.code, code, "{said:?}");
        said.error
    };
    let scene = &bench.scene[..];
    let again = refusal(&["plan", scene, "--seeds", "1", "--out", "s"], 2);
    assert!(again.contains("s: the folder is not empty"), "{again}");
    let twice = refusal(&["plan", scene, scene, "--seeds", "1", "--out", "t"], 2);
    assert!(twice.contains("two scenes are called `tiny`"), "{twice}");
    let beyond = refusal(&["run", "s", "--index", "3"], 2);
    assert!(
        beyond.contains("there is no run 3: the plan has 3"),
        "{beyond}"
    );
    let word = refusal(&["run", "s", "--index", "some"], 2);
    assert!(word.contains("a run's number, `auto` or `all`"), "{word}");
    let many = refusal(&["plan", scene, "--seeds", "99999999999", "--out", "u"], 2);
    let says = "99999999999 runs (scenes x seeds: 1 x 99999999999), where at most 1000000 are";
    assert!(many.contains(says) && !bench.path("u").exists(), "{many}");
    let nowhere = refusal(&["status", "nowhere"], 4);
    assert!(nowhere.contains("nowhere/plan.json"), "{nowhere}");
}
