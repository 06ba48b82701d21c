//! `cosmic optimize` where it is refused, where its time step is unstable, and where numbers are lost.

use crate::common::{Bench, scene};
use serde_json::Value;
use std::fs;

#[test]
fn folders_that_will_not_do_are_refused() {
    let bench = Bench::default();
    fs::create_dir(bench.path("empty")).unwrap();
    // A run killed in its very first write leaves no more than this.
    fs::write(bench.path("empty/.cosmic-half"), "{").unwrap();
    bench.run("empty", &[]);
    let before = bench.results("empty");
    assert!(!before.contains_key(".cosmic-half"));
    let said = bench.optimize("empty", &[]);
    assert_eq!(said.code, 2);
    assert!(
        said.error.contains("empty: the folder is not empty"),
        "{}",
        said.error
    );
    assert_eq!(bench.results("empty"), before);
    // Root may write anywhere; no one can make a folder under a file.
    for out in ["tiny.toml", "tiny.toml/run"] {
        let said = bench.optimize(out, &[]);
        assert_eq!(said.code, 4);
        assert!(
            said.error.contains(&format!("cannot write {out}: ")),
            "{}",
            said.error
        );
    }
    assert_eq!(bench.cosmic(&["optimize", "no_such_scene"]).code, 4);
    fs::write(bench.path("bad.toml"), "[physics]\ndt = \"fast\"\n").unwrap();
    let said = bench.cosmic(&["optimize", "bad.toml"]);
    assert!(
        said.code == 2 && said.error.contains("bad.toml:2:6"),
        "{}",
        said.error
    );
    assert!(!bench.path("runs").exists());
}

#[test]
fn numbers_out_of_range_say_which_are_allowed() {
    let bench = Bench::default();
    let seeds = "expected a whole number from 0 to 18446744073709551615";
    let threads = "expected a whole number from 1 to 1024";
    let counts = "expected a whole number, 1 or more";
    let refused = |command: &[&str], option: &str, value: &str, allowed: &str| {
        let said = bench.cosmic(&[command, &[option, value]].concat());
        assert_eq!((said.code, &said.out[..]), (2, ""), "{said:?}");
        let place = format!("invalid value '{value}' for '{option} <");
        assert!(said.error.contains(&place), "{}", said.error);
        assert!(said.error.contains(allowed), "{}", said.error);
    };
    let optimize = ["optimize", &bench.scene];
    refused(&optimize, "--starts", "0", counts);
    refused(&optimize, "--starts", "-3", counts);
    refused(&optimize, "--iterations", "0", counts);
    refused(&optimize, "--iterations", "1.5", counts);
    refused(&optimize, "--threads", "0", threads);
    refused(&optimize, "--threads", "1025", threads);
    refused(&optimize, "--seed", "-1", seeds);
    refused(&["resume", "a"], "--threads", "-1", threads);
    refused(&["gradcheck"], "--seed", "-1", seeds);
    let directions = "expected a whole number from 1 to 65535";
    refused(&["gradcheck"], "--directions", "0", directions);
    refused(&["robustness", "a"], "--seed", "-1", seeds);
    refused(
        &["robustness", "a"],
        "--start",
        "-1",
        "expected a number from 0 to 1",
    );
    refused(&["study", "paper"], "--first-seed", "-1", seeds);
    refused(&["study", "paper"], "--seeds", "0", counts);
    refused(&["sweep", "plan", "--out", "s"], "--seeds", "0", counts);
    assert!(!bench.path("runs").exists());
}

/// A controller that answers the slightest velocity: the robot moves, and the derivative of its
/// motion grows beyond all numbers.
#[test]
fn gradients_that_are_not_finite_are_counted_and_skipped() {
    let chaos = "[controller]\nvelocity_scale = 1000.0\noffset_scale = 100.0\n\
                 [gradient]\ncotangent_bound = \"off\"\n";
    let bench = Bench::with(&(scene(24, 8192, "damping = 1.0") + chaos));
    let said = bench.run("a", &[]);
    let summary = bench.json("a/summary.json");
    let skipped = summary["skipped_gradients"].as_u64().unwrap();
    let lines = fs::read_to_string(bench.path("a/history.jsonl")).unwrap();
    let rows: Vec<Value> = lines
        .lines()
        .map(|l| serde_json::from_str(l).unwrap())
        .collect();
    assert_eq!(rows.len(), 24);
    assert_eq!(
        skipped,
        rows.iter()
            .map(|row| row["skipped"].as_u64().unwrap())
            .sum::<u64>()
    );
    assert!(skipped > 0 && summary["displacement_p50"].is_number());
    assert!(
        said.error.contains(&format!("{skipped} gradients skipped")),
        "{}",
        said.error
    );
    let table = fs::read_to_string(bench.path("a/history.csv")).unwrap();
    assert!(table.contains("NaN") || table.contains("inf"));
}

#[test]
fn a_robot_that_flies_apart_is_told_with_its_last_states() {
    // Explicit steps of 10 ms are unstable for such springs.
    let text =
        scene(24, 256, "dt = 0.01\ndamping = 0.0") + "[materials]\nstiffness = [1e-7, 4e3, 30.0]\n";
    let bench = Bench::with(&text);
    let said = bench.optimize("a", &["--allow-unstable"]);
    assert_eq!(said.code, 3, "{said:?}");
    for what in [
        "diverged in step ",
        "node ",
        "velocity [",
        "a/diverged.json",
    ] {
        assert!(said.error.contains(what), "{}", said.error);
    }
    let history = fs::read_to_string(bench.path("a/history.jsonl")).unwrap();
    assert_eq!(history.lines().count(), 24);
    let again = bench.cosmic(&["evaluate", "a/diverged.json"]);
    let step = |text: &str| {
        text.split("in step ")
            .nth(1)
            .unwrap()
            .split(':')
            .next()
            .unwrap()
            .to_string()
    };
    assert_eq!((again.code, step(&again.error)), (3, step(&said.error)));
    assert!(!bench.path("a/summary.json").exists());
    assert_eq!(bench.cosmic(&["resume", "a"]).code, 3);
    // Nothing comes of several such starts either.
    let said = bench.optimize("b", &["--starts", "2", "--allow-unstable"]);
    assert!(
        said.code == 3 && said.error.contains("b/diverged.json"),
        "{said:?}"
    );
}

/// Without stiffness nothing that is designed moves the payload along the ground.
#[test]
fn a_task_without_any_slope_is_warned_of() {
    let slack = scene(24, 64, "") + "[materials]\nstiffness = [0.0, 0.0, 0.0]\n";
    let said = Bench::with(&slack).optimize("a", &["--iterations", "12"]);
    let warning = "warning: after iteration 10: all gradients of the last 10 iterations were zero";
    assert_eq!(said.error.matches(warning).count(), 1, "{said:?}");
    let said = Bench::default().run("a", &["--iterations", "12"]);
    assert!(!said.error.contains("were zero"), "{said:?}");
}

/// What a scene's file may not say, a scene from elsewhere may not either: its run could not be
/// resumed.
#[test]
fn a_scene_that_could_not_be_read_again_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = cosmic::scene::Scene::default();
    scene.schedule.horizon = [32, 32];
    let plan = cosmic::record::RunPlan {
        name: "short".to_owned(),
        scene,
        seed: 0,
        starts: std::num::NonZeroUsize::MIN,
        iterations: None,
        search: cosmic::record::Search::Full,
    };
    let run = folder.path().join("run");
    let refused = cosmic::record::optimise(&run, &plan, &mut ()).unwrap_err();
    assert_eq!(refused.exit_code(), 2);
    assert!(
        refused
            .to_string()
            .contains("the shortest horizon has (32)")
    );
    assert!(!run.exists());
}

/// A scene whose time step is far too long, said on a line of its own.
fn unstable() -> String {
    scene(4, 32, "dt = 0.05")
}

#[test]
fn an_unstable_time_step_is_refused_where_the_scene_sets_it() {
    let bench = Bench::with(&unstable());
    let line = unstable()
        .lines()
        .position(|l| l.starts_with("dt"))
        .unwrap()
        + 1;
    let said = bench.optimize("a", &[]);
    assert_eq!((said.code, said.out.as_str()), (2, ""), "{said:?}");
    for what in [
        &format!("tiny.toml:{line}:"),
        "the time step of 0.05 s is unstable",
        "node ",
        "set physics.dt to ",
        "--allow-unstable",
        "^",
    ] {
        assert!(said.error.contains(what), "no {what:?} in {}", said.error);
    }
    assert!(!bench.path("a").exists());
    // Where the scene sets none, there is no line to show.
    let bench = Bench::with("[materials]\nstiffness = [1e-7, 4e6, 30.0]\n");
    let said = bench.optimize("a", &[]);
    assert!(said.code == 2 && said.error.starts_with("error: the time step of 0.002 s is"));
}

#[test]
fn an_unstable_time_step_is_let_pass_with_a_warning() {
    let warning = "warning: the time step of 0.05 s is unstable";
    let bench = Bench::with(&unstable());
    let said = bench.optimize("a", &["--allow-unstable", "--iterations", "2"]);
    assert_eq!(said.error.matches(warning).count(), 1, "{said:?}");
    // Of several starts each has its own.
    let several = ["--allow-unstable", "--iterations", "2", "--starts", "2"];
    let said = bench.optimize("several", &several);
    for seed in 0..2 {
        let warning = warning.replace("warning: ", &format!("warning: seed {seed}: "));
        assert_eq!(said.error.matches(&warning).count(), 1, "{said:?}");
    }
    let text = fs::read_to_string(bench.path("a/scene.toml")).unwrap();
    assert!(text.contains("unstable_step = \"warn\""));
    let history = fs::read_to_string(bench.path("a/history.jsonl")).unwrap();
    let row: Value = serde_json::from_str(history.lines().next().unwrap()).unwrap();
    let check = &row["time_step"];
    let limit = check["exact"]["dt"].as_f64().unwrap();
    assert!(check["dt"] == 0.05 && limit < 0.05 && check["exact"]["node"].is_u64());
    let table = fs::read_to_string(bench.path("a/history.csv")).unwrap();
    assert!(
        table
            .lines()
            .next()
            .unwrap()
            .contains(",dt_over_bound,dt_over_limit,")
    );
    let quiet = bench.optimize("b", &["--allow-unstable", "--quiet", "--iterations", "2"]);
    assert!(!quiet.error.contains("warning"), "{quiet:?}");
    // A patient scene says so itself.
    let bench =
        Bench::with(&unstable().replace("dt = 0.05", "dt = 0.05\nunstable_step = \"warn\""));
    let said = bench.optimize("a", &["--iterations", "2"]);
    assert!(said.code != 2 && said.error.contains(warning), "{said:?}");
}

/// The snap makes every edge skeleton, and that is too stiff for the time step.
#[test]
fn a_design_that_becomes_unstable_stops_the_run_which_can_go_on() {
    let text = "[lattice]\ncolumns = 2\nrows = 2\n[physics]\nsteps = 32\ndt = 0.0045\n\
                [volume]\nsolid = [1.0, 1.0]\nactuator = [0.0, 0.0]\n\
                [schedule]\niterations = 6\nattraction_from = 4\nsnap_at = 4\n\
                horizon = [32, 32]\n[loss]\nwindow = 16\nevery = 4\n";
    let bench = Bench::with(text);
    let said = bench.optimize("a", &[]);
    assert_eq!(said.code, 2, "{said:?}");
    let says = |error: &str| {
        let ways = ["set physics.dt to ", "cosmic resume a --allow-unstable"];
        error.contains("after iteration 4: the time step") && ways.iter().all(|w| error.contains(w))
    };
    assert!(said.error.contains("tiny.toml:6:"), "{}", said.error);
    assert!(says(&said.error), "{}", said.error);
    let done = fs::read_to_string(bench.path("a/history.jsonl")).unwrap();
    assert!((1..6).contains(&done.lines().count()), "{done}");
    // It is not forgotten.
    let said = bench.cosmic(&["resume", "a"]);
    assert!(said.code == 2 && says(&said.error), "{said:?}");
    // Of several starts it is the search that can be gone on with.
    let several = bench.optimize("several", &["--starts", "2"]).error;
    assert!(
        several.contains("cosmic resume several --allow-unstable"),
        "{several}"
    );
    // Nor does a search take steps that are refused, however often it is asked to.
    let search = "[search]\nrungs = [5, 6, 6]\nkeep = [0.5, 0.5, 0.5]\nwindow = 2\n";
    fs::write(bench.path("search.toml"), text.to_owned() + search).unwrap();
    let halving = ["--starts", "2", "--search", "halving", "--threads", "1"];
    let refused = [
        &["optimize", "search.toml", "--out", "halved"],
        &halving[..],
    ]
    .concat();
    let said = bench.cosmic(&refused);
    assert!(
        said.code == 2 && says(&said.error.replace("halved", "a")),
        "{said:?}"
    );
    for _ in 0..2 {
        assert_eq!(
            bench.cosmic(&["resume", "halved", "--threads", "1"]).code,
            2
        );
        let rows = fs::read_to_string(bench.path("halved/starts/0/history.jsonl")).unwrap();
        assert_eq!(rows.lines().count(), 4);
    }
    let said = bench.cosmic(&["resume", "a", "--allow-unstable"]);
    assert!(said.error.contains("warning: "), "{said:?}");
    let all = fs::read_to_string(bench.path("a/history.jsonl")).unwrap();
    assert!(all.lines().count() == 6 && all.starts_with(&done));
    let scene = fs::read_to_string(bench.path("a/scene.toml")).unwrap();
    assert!(scene.contains("unstable_step = \"warn\""));
    let same = bench.optimize("b", &["--allow-unstable"]);
    assert_eq!(same.code, said.code);
    let design = |run: &str| fs::read(bench.path(run).join("design.json")).unwrap();
    assert_eq!(design("a"), design("b"));
}
