//! Runs that begin with a given robot (`cosmic optimize --from`), and runs with a loss that the user's program adds.

use crate::common::{Bench, scene};
use crate::program::{Told, command, has};
use autodiff::Real;
use cosmic::Registry;
use cosmic::lattice::Truss;
use cosmic::objective::Loss;
use cosmic::outcome::DesignFile;
use cosmic::record::{Observer, Run, RunPlan, optimise, optimise_with, resume_with};
use cosmic::scene::Scene;
use cosmic::search::{CoDesign, Progress, Record};
use cosmic::world::Trajectory;
use std::fs;
use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::path::Path;

/// The number of every iteration in a run's history.
fn iterations(bench: &Bench, run: &str) -> Vec<u64> {
    let rows = bench.rows(&format!("{run}/history.jsonl")).into_iter();
    rows.map(|row| row["iteration"].as_u64().unwrap()).collect()
}

/// The commands in messages begin as the user began the command: with Cargo, with the name of a program of the user, or
/// with a path.
#[cfg(unix)]
#[test]
fn commands_in_messages_work_as_printed() {
    use std::os::unix::process::CommandExt;
    for (start, by_cargo, words) in [
        ("cosmic", false, "cosmic"),
        ("walker", false, "walker"),
        ("./walker", false, "./walker"),
        ("target/release/cosmic", false, "target/release/cosmic"),
        ("target/release/cosmic", true, "cargo run --release --"),
        (
            "/a/target/debug/examples/mud",
            true,
            "cargo run --release --example mud --",
        ),
    ] {
        let mut command = command("report earth");
        if by_cargo {
            command.env("CARGO_MANIFEST_DIR", "");
        }
        let told = Told::of(command.arg0(start).output().unwrap());
        told.fails(
            2,
            &[&format!("make one with: {words} optimize earth, then")],
        );
    }
}

fn is_the_start(bench: &Bench, [from, run]: [&str; 2]) -> bool {
    let read = |run, name| fs::read(bench.path(run).join(name)).unwrap();
    read(from, "design.json") == read(run, "start.json")
}

/// On Unix, the names of folders are bytes and need not be Unicode.
#[cfg(unix)]
#[test]
fn a_robot_may_come_from_a_folder_whose_name_is_not_unicode() {
    use std::os::unix::ffi::OsStrExt;
    let bench = Bench::default();
    bench.run("a", "--iterations 2");
    let name = |bytes: &'static [u8]| std::ffi::OsStr::from_bytes(bytes);
    let run = name(b"m\xfcnchen");
    fs::rename(bench.path("a"), bench.path("").join(run)).unwrap();
    let mut command = command("optimize --quiet --iterations 1 --from");
    let status = command.arg(run).current_dir(bench.path("")).status();
    assert!(status.unwrap().success());
    let folder = bench.path("runs").join(name(b"m\xfcnchen-on"));
    assert!(folder.join("summary.json").exists());
    // The run uses the scene beside the robot, not the default scene.
    let scene = |folder: &Path| fs::read(folder.join("scene.toml")).unwrap();
    assert_eq!(scene(&folder), scene(&bench.path("").join(run)));
}

#[test]
fn an_undecided_robot_goes_through_the_whole_schedule() {
    let bench = Bench::default();
    bench.unfinished("soft", 10);
    bench.run("b", "--from soft");
    assert!(iterations(&bench, "b").into_iter().eq(1..=24));
    assert!(is_the_start(&bench, ["soft", "b"]));
    assert_eq!(bench.json("b/summary.json")["entered"], 0);
    // The given start differs from the start that the scene describes.
    bench.run("plain", "");
    let [b, plain] = ["b", "plain"].map(|run| bench.json(&format!("{run}/design.json")));
    assert_ne!(b, plain);
    assert!(!bench.path("plain/start.json").exists());
    let layout = "--set start.kind=layout --set start.layout=filled --set schedule.snap_at=0";
    let late = bench.optimize("late", &format!("--from soft {layout}"));
    late.fails(2, &["undecided", "snap_at"]);
}

/// With `hold_materials`, an undecided design can be the start of another run.
#[test]
fn a_start_names_the_materials_of_its_mixture() {
    let held = scene(24, 64, "") + "[projection]\nhold_materials = 1.0\n";
    let bench = Bench::with(&held);
    bench.unfinished("soft", 1);
    bench.run("b", "--from soft");
    assert!(is_the_start(&bench, ["soft", "b"]));
}

/// Stops a run after the given number of iterations.
struct StopsAfter(usize);

impl Observer for StopsAfter {
    fn iteration(&mut self, _: &Run, _: &Record) -> ControlFlow<()> {
        // If there are several starts, others may still report iterations after the first has stopped.
        self.0 = self.0.saturating_sub(1);
        match self.0 {
            0 => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    }
}

/// A run is also resumed to the same bytes after `resume` has refused a snapshot with an impossible `entered`.
#[test]
fn an_interrupted_run_with_a_given_start_resumes_to_the_same_bytes() {
    let bench = Bench::finished();
    bench.run("whole", "--from a");
    let plan = bench.plan();
    let design = DesignFile::read(&bench.path("a/design.json")).unwrap();
    let controller = design.robot(&plan.scene, "a").unwrap();
    for stop in [1, 3] {
        let run = format!("stopped-{stop}");
        let observer = &mut StopsAfter(stop);
        let codesign = CoDesign::new(&plan.scene).unwrap();
        let progress = codesign.begin_with(plan.seed, design.design(), controller.clone());
        let progress = progress.unwrap();
        let stopped = optimise_with(&bench.path(&run), &plan, codesign, progress, observer);
        assert_eq!(stopped.unwrap_err().exit_code(), 75);
        let snapshot = format!("{run}/snapshot.json");
        let text = bench.read(&snapshot);
        assert!(text.contains("\"entered\":19,"));
        for wrong in ["3", "30", "18446744073709551615"] {
            let wrong = format!("\"entered\":{wrong},");
            bench.write(&snapshot, text.replace("\"entered\":19,", &wrong));
            let refused = bench.cosmic(&format!("resume {run}"));
            refused.fails(2, &["`progress.entered`"]);
        }
        bench.write(&snapshot, text);
        bench.ok(&format!("resume {run}"));
        assert_eq!(bench.results(&run), bench.results("whole"));
    }
}

/// The loss: minus the final height of the payload.
struct Lift;

impl Loss for Lift {
    fn observed(&self, steps: usize) -> Vec<usize> {
        vec![steps]
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        -trajectory.payload(0).x.up()
    }
}

/// A run with a user's own loss has an ordinary folder, but only a program with this loss can resume it.
#[test]
fn a_run_with_a_loss_of_a_program_is_resumed_by_that_program() {
    let bench = Bench::default();
    let plan = bench.plan();
    let begin = |run: &str, observer: &mut dyn Observer| {
        let codesign = CoDesign::with_loss(&plan.scene, Lift).unwrap();
        let progress = codesign.begin(plan.seed).unwrap();
        optimise_with(&bench.path(run), &plan, codesign, progress, observer)
    };
    let whole = begin("whole", &mut StopsAfter(usize::MAX)).unwrap();
    let height = -whole.loss_p50.flatten().unwrap();
    assert!(height.is_finite() && height != whole.displacement_along);

    let stopped = begin("b", &mut StopsAfter(9)).unwrap_err().to_string();
    assert!(
        stopped.contains("record::resume_with") && !stopped.contains("cosmic resume"),
        "{stopped}"
    );
    bench.fails(
        "resume b",
        2,
        &["the loss of this run is code of the program"],
    );
    let go_on = |codesign: cosmic::Result<CoDesign>| {
        let observer = &mut StopsAfter(usize::MAX);
        resume_with(&bench.path("b"), codesign.unwrap(), observer)
    };
    let said = |codesign| go_on(codesign).unwrap_err().to_string();
    assert!(
        said(CoDesign::new(&plan.scene)).contains("the loss of this run is code of the program")
    );
    let other = CoDesign::with_loss(&Scene::paper(), Lift);
    assert!(said(other).contains("different scene"));
    let own = CoDesign::with_loss(&plan.scene, Lift);
    assert_eq!(go_on(own).unwrap().loss_p50, whole.loss_p50);
    assert_eq!(bench.results("b"), bench.results("whole"));
    bench.ok("report whole");

    begin_of_the_scene(&bench, &plan);
}

/// Begins a run with the scene's own objective. Asserts that resuming it with another loss is refused, and so are
/// arguments that do not fit together.
fn begin_of_the_scene(bench: &Bench, plan: &RunPlan) {
    let own = || CoDesign::new(&plan.scene).unwrap();
    let with_loss = || CoDesign::with_loss(&plan.scene, Lift).unwrap();
    let begin = |plan: &RunPlan, run: &str, codesign: CoDesign, progress: Progress| {
        let observer = &mut StopsAfter(3);
        let ended = optimise_with(&bench.path(run), plan, codesign, progress, observer);
        ended.unwrap_err()
    };
    let resumed = |run: &str, codesign: CoDesign| {
        let ended = resume_with(&bench.path(run), codesign, &mut StopsAfter(3));
        ended.unwrap_err().to_string()
    };
    let at_start = || own().begin(0).unwrap();
    let stopped = begin(plan, "c", own(), at_start());
    assert_eq!(stopped.exit_code(), 75);
    has(&resumed("c", with_loss()), &["has another loss"]);
    let mut later = at_start();
    own().iterate(&mut later);
    let seeded = RunPlan {
        seed: 1,
        ..plan.clone()
    };
    let many = RunPlan {
        starts: NonZeroUsize::new(2).unwrap(),
        ..plan.clone()
    };
    for (plan, codesign, progress, says) in [
        (&seeded, own(), at_start(), "the seed and the loss"),
        (plan, with_loss(), at_start(), "must be those of the plan"),
        (
            plan,
            own(),
            later,
            "must be at iteration 0, but 1 iterations are done",
        ),
        (&many, own(), at_start(), "must have one start"),
    ] {
        let refused = begin(plan, "d", codesign, progress);
        assert_eq!(refused.exit_code(), 2);
        has(&refused.to_string(), &[says]);
    }
    // A search needs an optimisation for each start, so one optimisation cannot resume it.
    optimise(&bench.path("e"), &many, &mut StopsAfter(3)).unwrap_err();
    has(&resumed("e", own()), &["several starts"]);
    assert!(!bench.path("e/summary.json").exists());
    assert!(!bench.path("d").exists());
}

/// Only this program knows the lattice, but every program can resume the run, because the run's folder contains a copy
/// of the lattice.
#[test]
fn a_lattice_of_a_program_is_copied_into_its_runs() {
    let gate = Truss::parse("gate", include_str!("pages/gate.json")).unwrap();
    let registry = Registry::default().with_lattice("gate", gate);
    let small = "columns = 3\nrows = 3\n";
    let bench = Bench::with(&scene(24, 64, "").replace(small, "file = \"gate\"\n"));
    let scene = registry.read(&bench.path("tiny.toml")).unwrap();
    assert_eq!(scene.lattice.name(), "gate");
    let plan = RunPlan::new("tiny", scene, 0);
    optimise(&bench.path("whole"), &plan, &mut ()).unwrap();
    optimise(&bench.path("a"), &plan, &mut StopsAfter(11)).unwrap_err();
    bench.ok("resume a");
    assert_eq!(bench.results("a"), bench.results("whole"));
    // The program `cosmic` does not have this lattice.
    bench.optimize("b", "").fails(4, &["gate"]);
}
