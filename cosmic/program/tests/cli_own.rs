//! Runs with a beginning or a loss of their own: `cosmic optimize --from`, and a user's program.

use crate::common::{Bench, scene};
use autodiff::Real;
use cosmic::codesign::{CoDesign, Record};
use cosmic::objective::Loss;
use cosmic::record::{DesignFile, Observer, Run, RunPlan, optimise, optimise_with, resume_with};
use cosmic::scene::Scene;
use cosmic::simulator::Trajectory;
use std::fs;
use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::path::Path;

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
    let bench = Bench::default();
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

/// Folders have names of bytes, and not all bytes are Unicode.
#[cfg(unix)]
#[test]
fn a_robot_may_come_from_a_folder_whose_name_is_no_unicode() {
    use std::os::unix::ffi::OsStrExt;
    let bench = Bench::default();
    bench.run("a", &["--iterations", "2"]);
    let name = |bytes: &'static [u8]| std::ffi::OsStr::from_bytes(bytes);
    let run = name(b"m\xfcnchen");
    fs::rename(bench.path("a"), bench.path("").join(run)).unwrap();
    let status = std::process::Command::new(env!("CARGO_BIN_EXE_cosmic"))
        .current_dir(bench.path(""))
        .args(["optimize", "--quiet", "--iterations", "1", "--from"])
        .arg(run)
        .status()
        .unwrap();
    assert!(status.success(), "{status}");
    let folder = bench.path("runs").join(name(b"m\xfcnchen-on"));
    assert!(folder.join("summary.json").exists());
    // In the scene beside the robot, and not in the default one.
    let scene = |folder: &Path| fs::read(folder.join("scene.toml")).unwrap();
    assert_eq!(scene(&folder), scene(&bench.path("").join(run)));
}

#[test]
fn a_robot_that_is_not_decided_goes_through_the_whole_schedule() {
    let bench = Bench::default();
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

/// A material that is held is none of an edge that is not decided, at the start as in the end.
#[test]
fn a_start_names_the_materials_of_its_mixture() {
    let held = scene(24, 64, "") + "[projection]\nhold_materials = 1.0\n";
    let bench = Bench::with(&held);
    bench.run("soft", &["--iterations", "1"]);
    bench.run("b", &["--from", "soft"]);
    assert!(is_the_start(&bench, ["soft", "b"]));
}

/// Stops a run after so many iterations.
struct StopsAfter(usize);

impl Observer for StopsAfter {
    fn iteration(&mut self, _: &Run, _: &Record) -> ControlFlow<()> {
        // Of several starts others are told of what they had at work.
        self.0 = self.0.saturating_sub(1);
        match self.0 {
            0 => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    }
}

fn plan(bench: &Bench) -> RunPlan {
    RunPlan::new("tiny", Scene::read(Path::new(&bench.scene)).unwrap(), 0)
}

#[test]
fn an_interrupted_run_goes_on_to_the_same_bytes() {
    let bench = Bench::default();
    bench.run("a", &[]);
    bench.run("whole", &["--from", "a"]);
    let plan = plan(&bench);
    let file = bench.path("a/design.json");
    let design = DesignFile::read(&file).unwrap();
    let controller = design.robot(&plan.scene, "a").unwrap();
    for stop in [1, 3] {
        let run = format!("stopped-{stop}");
        let observer = &mut StopsAfter(stop);
        let codesign = CoDesign::new(&plan.scene).unwrap();
        let progress = codesign.begin_with(plan.seed, design.z.clone(), controller.clone());
        let progress = progress.unwrap();
        let stopped = optimise_with(&bench.path(&run), &plan, codesign, progress, observer);
        assert_eq!(stopped.unwrap_err().exit_code(), 75);
        assert_eq!(bench.cosmic(&["resume", &run]).code, 0);
        assert_eq!(bench.results(&run), bench.results("whole"));
    }
}

/// Minus the height of the payload in the end.
struct Lift;

impl Loss for Lift {
    fn observed(&self, steps: usize) -> Vec<usize> {
        vec![steps]
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        -trajectory.states[0].x[0][1]
    }
}

/// The options that a run's summary names as departures.
fn departures(bench: &Bench, run: &str) -> Vec<String> {
    let summary = bench.json(&format!("{run}/summary.json"));
    let departures = summary["departures"].as_array().unwrap().iter();
    let options = departures.map(|d| d["option"].as_str().unwrap().to_string());
    options.collect()
}

#[test]
fn a_run_says_what_of_its_scene_was_not_in_force() {
    let bench = Bench::default();
    bench.run("a", &[]);
    bench.run("soft", &["--iterations", "10"]);
    bench.run("b", &["--from", "a"]);
    bench.run("c", &["--from", "soft"]);
    let [a, b, c] = ["a", "b", "c"].map(|run| departures(&bench, run));
    let has = |run: &[String], option: &str| run.iter().any(|o| o == option);
    for option in ["gradient.design_memory", "schedule.snap_trials"] {
        assert!(has(&a, option) && !has(&b, option) && has(&c, option));
    }
    assert!(!has(&a, "start") && has(&b, "start") && has(&c, "start"));
    let plan = plan(&bench);
    let codesign = CoDesign::with_loss(&plan.scene, Lift).unwrap();
    let progress = codesign.begin(0).unwrap();
    let observer = &mut StopsAfter(usize::MAX);
    optimise_with(&bench.path("own"), &plan, codesign, progress, observer).unwrap();
    let own = departures(&bench, "own");
    assert!(has(&a, "loss.kind") && !has(&own, "loss.kind") && has(&own, "loss"));
}

/// Without a scene a run goes on in the one of the run that it comes from, beside that run.
#[test]
fn a_run_goes_on_in_its_own_scene() {
    let bench = Bench::default();
    bench.run("runs/a", &[]);
    let said = bench.cosmic(&["optimize", "--from", "runs/a"]);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(
        said.out.contains("run: runs/a-on\n") && said.out.contains("tiny, seed 0"),
        "{}",
        said.out
    );
    let scene = |run: &str| fs::read_to_string(bench.path(run).join("scene.toml")).unwrap();
    assert_eq!(scene("runs/a"), scene("runs/a-on"));
    // The folder that the user is in has a name as well.
    let said = bench.cosmic_in("runs/a", &["optimize", "--from", "."]);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains("run: runs/a-on\n"), "{said:?}");
    let design = "runs/a/design.json";
    let said = bench.cosmic(&["optimize", "--from", design, "--out", "b"]);
    assert_eq!(said.code, 0, "{said:?}");
    assert_eq!(scene("runs/a"), scene("b"));
}

/// What no run can have written is refused, and not gone on with.
#[test]
fn a_snapshot_that_enters_where_no_run_does_is_refused() {
    let bench = Bench::default();
    bench.run("a", &[]);
    let plan = plan(&bench);
    let design = DesignFile::read(&bench.path("a/design.json")).unwrap();
    let controller = design.robot(&plan.scene, "a").unwrap();
    let codesign = CoDesign::new(&plan.scene).unwrap();
    let progress = codesign.begin_with(0, design.z, controller).unwrap();
    optimise_with(
        &bench.path("b"),
        &plan,
        codesign,
        progress,
        &mut StopsAfter(2),
    )
    .unwrap_err();
    let path = bench.path("b/snapshot.json");
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains("\"entered\":19,"));
    for wrong in ["3", "30", "18446744073709551615"] {
        fs::write(
            &path,
            text.replace("\"entered\":19,", &format!("\"entered\":{wrong},")),
        )
        .unwrap();
        let said = bench.cosmic(&["resume", "b"]);
        assert!(
            said.code == 2 && said.error.contains("`progress.entered`"),
            "{said:?}"
        );
    }
    fs::write(&path, text).unwrap();
    assert_eq!(bench.cosmic(&["resume", "b"]).code, 0);
}

/// It has a folder as every run, and no program goes on with it that has another loss.
#[test]
fn a_run_for_an_own_loss_is_kept_and_gone_on_with_by_its_program() {
    let bench = Bench::default();
    let plan = plan(&bench);
    let begin = |run: &str, observer: &mut dyn Observer| {
        let codesign = CoDesign::with_loss(&plan.scene, Lift).unwrap();
        let progress = codesign.begin(plan.seed).unwrap();
        optimise_with(&bench.path(run), &plan, codesign, progress, observer)
    };
    let whole = begin("whole", &mut StopsAfter(usize::MAX)).unwrap();
    let height = -whole.loss_p50.unwrap();
    assert!(height.is_finite() && height != whole.displacement_along);

    let stopped = begin("b", &mut StopsAfter(9)).unwrap_err().to_string();
    assert!(
        stopped.contains("record::resume_with") && !stopped.contains("cosmic resume"),
        "{stopped}"
    );
    let said = bench.cosmic(&["resume", "b"]);
    assert!(
        said.code == 2 && said.error.contains("loss of its own"),
        "{said:?}"
    );
    let go_on = |codesign: cosmic::Result<CoDesign>| {
        resume_with(
            &bench.path("b"),
            codesign.unwrap(),
            &mut StopsAfter(usize::MAX),
        )
    };
    let said = |codesign| go_on(codesign).unwrap_err().to_string();
    assert!(said(CoDesign::new(&plan.scene)).contains("loss of its own"));
    let other = CoDesign::with_loss(&Scene::default(), Lift);
    assert!(said(other).contains("not of the run's scene"));
    let own = CoDesign::with_loss(&plan.scene, Lift);
    assert_eq!(go_on(own).unwrap().loss_p50, whole.loss_p50);
    assert_eq!(bench.results("b"), bench.results("whole"));
    assert_eq!(bench.cosmic(&["report", "whole"]).code, 0);

    begin_of_the_scene(&bench, &plan);
}

/// A run for the scene's objective is not gone on with for another loss.
fn begin_of_the_scene(bench: &Bench, plan: &RunPlan) {
    let begin = |plan: &RunPlan, run: &str| {
        let codesign = CoDesign::new(&Scene::read(Path::new(&bench.scene)).unwrap()).unwrap();
        let progress = codesign.begin(0).unwrap();
        let observer = &mut StopsAfter(3);
        optimise_with(&bench.path(run), plan, codesign, progress, observer)
    };
    assert_eq!(begin(plan, "c").unwrap_err().exit_code(), 75);
    let own = CoDesign::with_loss(&plan.scene, Lift).unwrap();
    let said = resume_with(&bench.path("c"), own, &mut StopsAfter(3)).unwrap_err();
    assert!(said.to_string().contains("no other loss"), "{said}");
    let other = RunPlan {
        seed: 1,
        ..plan.clone()
    };
    let said = begin(&other, "d").unwrap_err().to_string();
    assert!(said.contains("scene and seed"), "{said}");
    let codesign = CoDesign::with_loss(&plan.scene, Lift).unwrap();
    let of_the_scene = CoDesign::new(&plan.scene).unwrap().begin(0).unwrap();
    let observer = &mut StopsAfter(3);
    let said = optimise_with(&bench.path("d"), plan, codesign, of_the_scene, observer).unwrap_err();
    assert!(said.to_string().contains("of one loss"), "{said}");
    let mut codesign = CoDesign::new(&plan.scene).unwrap();
    let mut progress = codesign.begin(0).unwrap();
    codesign.iterate(&mut progress);
    let said = optimise_with(&bench.path("d"), plan, codesign, progress, observer).unwrap_err();
    assert!(
        said.to_string().contains("iterations behind it: 1"),
        "{said}"
    );
    let many = RunPlan {
        starts: NonZeroUsize::new(2).unwrap(),
        ..plan.clone()
    };
    assert_eq!(begin(&many, "d").unwrap_err().exit_code(), 2);
    // A search has an optimisation for each of its starts.
    optimise(&bench.path("e"), &many, &mut StopsAfter(3)).unwrap_err();
    let codesign = CoDesign::new(&plan.scene).unwrap();
    let said = resume_with(&bench.path("e"), codesign, &mut StopsAfter(3)).unwrap_err();
    assert!(said.to_string().contains("several starts"), "{said}");
    assert!(!bench.path("e/summary.json").exists());
    assert!(!bench.path("d").exists());
}

#[test]
fn what_cannot_be_begun_with_is_refused() {
    let bench = Bench::default();
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
        &["stability", "--from", "a"],
        &["a/design.json", "`edges`", "110", "20"],
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
    let mut other = bench.json("a/design.json");
    let material = other["materials"][7].as_u64().unwrap();
    other["materials"][7] = ((material + 1) % 3).into();
    write("other.json", &other.to_string());
    refused(
        &[tiny, "--from", "other.json"],
        &["`materials[7]`", "as in `z`"],
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
