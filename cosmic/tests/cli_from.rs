//! `cosmic optimize --from`: runs that begin with the robot of another.

mod common;

use common::{Bench, scene};
use cosmic::codesign::Record;
use cosmic::record::{DesignFile, Observer, Plan, Run, Search, optimise_from};
use cosmic::scene::Scene;
use std::fs;
use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::path::Path;

/// 24 iterations, the 19th of them the snap.
fn bench() -> Bench {
    Bench::new(24, 64)
}

/// The numbers of the iterations of a run's history.
fn iterations(bench: &Bench, run: &str) -> Vec<u64> {
    let text = fs::read_to_string(bench.path(run).join("history.jsonl")).unwrap();
    let row = |line| serde_json::from_str::<serde_json::Value>(line).unwrap();
    let rows = text.lines().map(row);
    rows.map(|row| row["iteration"].as_u64().unwrap()).collect()
}

fn is_the_start(bench: &Bench, [from, run]: [&str; 2]) -> bool {
    let read = |run, name| fs::read(bench.path(run).join(name)).unwrap();
    read(from, "design.json") == read(run, "start.json")
}

#[test]
fn a_decided_robot_enters_after_the_snap() {
    let bench = bench();
    bench.run("a", &[]);
    let said = bench.run("b", &["--from", "a", "--seed", "7"]);
    assert!(
        said.out.contains("began after iteration 19"),
        "{}",
        said.out
    );
    assert_eq!(iterations(&bench, "b"), [20, 21, 22, 23, 24]);
    assert!(is_the_start(&bench, ["a", "b"]));
    let summary = bench.json("b/summary.json");
    assert_eq!(
        (&summary["entered"], &summary["iterations"]),
        (&19.into(), &5.into())
    );
    let materials = |run: &str| bench.json(&format!("{run}/design.json"))["materials"].clone();
    assert_eq!(materials("a").as_array().unwrap().len(), 20);
    // What is made of it can be looked at as every run.
    let said = bench.cosmic(&["report", "b"]);
    assert_eq!(said.code, 0, "{said:?}");
    // As many iterations as are asked for are done.
    bench.run("c", &["--from", "b/design.json", "--iterations", "2"]);
    assert_eq!(iterations(&bench, "c"), [20, 21]);
    // It was made by its start and its scene.
    let again = [
        "optimize",
        "b/scene.toml",
        "--from",
        "b/start.json",
        "--seed",
        "7",
    ];
    bench.cosmic(&[&again[..], &["--out", "d"]].concat());
    let [b, d] = ["b", "d"].map(|run| bench.json(&format!("{run}/design.json")));
    assert_eq!(b, d);
}

#[test]
fn a_robot_that_is_not_decided_goes_through_the_whole_schedule() {
    let bench = bench();
    bench.run("soft", &["--iterations", "10"]);
    bench.run("b", &["--from", "soft"]);
    assert!(iterations(&bench, "b").into_iter().eq(1..=24));
    assert!(is_the_start(&bench, ["soft", "b"]));
    assert_eq!(bench.json("b/summary.json")["entered"], 0);
    // It is another start than the scene's.
    bench.run("plain", &[]);
    let [b, plain] = ["b", "plain"].map(|run| bench.json(&format!("{run}/design.json")));
    assert_ne!(b, plain);
    assert!(!bench.path("plain/start.json").exists());
}

/// Stops a run after so many iterations.
struct StopsAfter(usize);

impl Observer for StopsAfter {
    fn begin(&mut self, _: &Run) {}

    fn iteration(&mut self, _: &Run, _: &Record) -> ControlFlow<()> {
        self.0 -= 1;
        match self.0 {
            0 => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    }
}

#[test]
fn an_interrupted_run_goes_on_to_the_same_bytes() {
    let bench = bench();
    bench.run("a", &[]);
    bench.run("whole", &["--from", "a"]);
    let plan = Plan {
        name: "tiny".into(),
        scene: Scene::read(Path::new(&bench.scene)).unwrap(),
        seed: 0,
        starts: NonZeroUsize::MIN,
        iterations: None,
        search: Search::Full,
    };
    let file = bench.path("a/design.json");
    let design = DesignFile::read(&file).unwrap();
    let controller = design.robot(&plan.scene, "a").unwrap();
    for stop in [1, 3] {
        let run = format!("stopped-{stop}");
        let robot = (design.z.clone(), controller.clone());
        let observer = &mut StopsAfter(stop);
        let stopped = optimise_from(&bench.path(&run), &plan, robot, observer);
        assert_eq!(stopped.unwrap_err().exit_code(), 75);
        assert_eq!(bench.cosmic(&["resume", &run]).code, 0);
        assert_eq!(bench.results(&run), bench.results("whole"));
    }
}

#[test]
fn what_cannot_be_begun_with_is_refused() {
    let bench = bench();
    bench.run("a", &[]);
    bench.run("soft", &["--iterations", "10"]);
    let refused = |arguments: &[&str], says: &[&str]| {
        let arguments = [&["optimize"], arguments, &["--out", "b"]].concat();
        let said = bench.cosmic(&arguments);
        assert_eq!(said.code, 2, "{said:?}");
        for text in says {
            assert!(said.error.contains(text), "{text}: {}", said.error);
        }
        assert!(!bench.path("b").exists());
    };
    let tiny = &bench.scene[..];
    // Of another lattice, with the place in the file.
    refused(
        &["--from", "a"],
        &["a/design.json", "number of `edges`", "110", "20"],
    );
    refused(&[tiny, "--from", "a", "--starts", "2"], &["--starts"]);
    let write = |name: &str, text: &str| {
        fs::write(bench.path(name), text).unwrap();
    };
    let mut far = bench.json("soft/design.json");
    far["z"][3][1] = 1.5.into();
    write("far.json", &far.to_string());
    refused(
        &[tiny, "--from", "far.json"],
        &["`z[3]`", "1.5", "from 0 to 1"],
    );
    let text = scene(24, 64, "");
    let layout = "[start]\nkind = \"layout\"\nlayout = \"filled\"\n";
    let alone = text.replace("snap_at = 19", "snap_at = 0") + layout;
    write("alone.toml", &alone);
    refused(
        &["alone.toml", "--from", "soft"],
        &["not decided", "snap_at"],
    );
    write(
        "short.toml",
        &text.replace("iterations = 24", "iterations = 19"),
    );
    refused(&["short.toml", "--from", "a"], &["no fine-tuning", "19"]);
    assert_eq!(bench.optimize("b", &["--from", "nowhere"]).code, 4);
}
