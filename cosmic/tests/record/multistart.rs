use crate::small::{StopAfter, tiny};
use cosmic::Registry;
use cosmic::record::snapshot::SNAPSHOT;
use cosmic::record::{Observer, RunPlan, folder_of, optimise, resume};
use rayon::ThreadPoolBuilder;
use std::cell::Cell;
use std::fs;
use std::num::NonZeroUsize;
use std::path::Path;

fn plan() -> RunPlan {
    let mut scene = tiny();
    scene.schedule.iterations = 60;
    (scene.schedule.attraction_from, scene.schedule.snap_at) = (20, 40);
    RunPlan {
        starts: NonZeroUsize::new(3).unwrap(),
        ..RunPlan::new("test", scene, 3)
    }
}

/// The delivered designs of all starts and of the search.
fn designs(folder: &Path) -> Vec<Vec<u8>> {
    let starts = (3..6).map(|seed| folder_of(folder, seed));
    let folders = starts.chain([folder.to_owned()]);
    folders
        .map(|f| fs::read(f.join("design.json")).unwrap())
        .collect()
}

/// An observer that stops every run during its delivery.
struct StopsDelivery;

impl Observer for StopsDelivery {
    fn is_stopped(&self) -> bool {
        true
    }
}

#[test]
fn a_delivery_can_be_interrupted_and_resumed() {
    let folder = tempfile::tempdir().unwrap();
    for starts in [1, 3].map(|starts| NonZeroUsize::new(starts).unwrap()) {
        let plan = RunPlan { starts, ..plan() };
        let [whole, run] =
            ["whole", "run"].map(|name| folder.path().join(format!("{name}-{starts}")));
        optimise(&whole, &plan, &mut ()).unwrap();
        let stopped = optimise(&run, &plan, &mut StopsDelivery).unwrap_err();
        assert_eq!(stopped.exit_code(), 75, "{stopped}");
        assert!(!run.join("summary.json").exists());
        resume(&run, &Registry::default(), &mut ()).unwrap();
        for file in ["design.json", "trajectory.json"] {
            let [resumed, whole] =
                [&run, &whole].map(|folder| fs::read(folder.join(file)).unwrap());
            assert!(resumed == whole, "{file} of {starts} starts");
        }
    }
}

/// An observer that stops a run after some questions of its delivery.
struct StopsAfter(Cell<usize>);

impl Observer for StopsAfter {
    fn is_stopped(&self) -> bool {
        self.0.set(self.0.get().saturating_sub(1));
        self.0.get() == 0
    }
}

/// The measurements of an interrupted delivery are saved, and a resumed run has the results of a run without
/// interruption.
#[test]
fn the_measurements_of_an_interrupted_delivery_are_saved() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, run] = ["whole", "run"].map(|name| folder.path().join(name));
    let plan = RunPlan {
        starts: NonZeroUsize::MIN,
        ..plan()
    };
    optimise(&whole, &plan, &mut ()).unwrap();
    let saved = || {
        let text = fs::read_to_string(run.join(SNAPSHOT)).unwrap();
        let snapshot: serde_json::Value = serde_json::from_str(&text).unwrap();
        let known = snapshot["progress"]["measurements"].as_object().cloned();
        known.unwrap_or_default().len()
    };
    optimise(&run, &plan, &mut StopsAfter(Cell::new(2))).unwrap_err();
    let mut before = saved();
    for questions in [5, 7, 9] {
        let stopped = resume(
            &run,
            &Registry::default(),
            &mut StopsAfter(Cell::new(questions)),
        );
        assert_eq!(stopped.unwrap_err().exit_code(), 75);
        let now = saved();
        assert!(now > before, "{now} measurements after {before}");
        before = now;
    }
    resume(&run, &Registry::default(), &mut ()).unwrap();
    let [resumed, whole] = [&run, &whole].map(|folder| {
        let text = fs::read_to_string(folder.join("summary.json")).unwrap();
        let mut summary: serde_json::Value = serde_json::from_str(&text).unwrap();
        summary["seconds"].take();
        summary
    });
    assert_eq!(resumed, whole);
    // The snapshot of a finished run is that of a run without interruptions.
    assert_eq!(saved(), 0);
}

/// Begins the search in a folder, and stops it before the second start begins.
fn begin_search(folder: &Path) {
    let one = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let stopped = one.install(|| optimise(folder, &plan(), &mut StopAfter(1)));
    assert_eq!(stopped.unwrap_err().exit_code(), 75);
    assert!(folder_of(folder, 3).exists() && !folder_of(folder, 4).exists());
}

/// The error names the start that failed, not the starts that were interrupted because of it.
#[test]
fn a_failed_start_is_named_and_the_others_are_saved() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, run] = ["whole", "run"].map(|name| folder.path().join(name));
    optimise(&whole, &plan(), &mut ()).unwrap();
    begin_search(&run);
    let stray = folder_of(&run, 4).join("stray");
    fs::create_dir_all(folder_of(&run, 4)).unwrap();
    fs::write(&stray, "").unwrap();
    let three = ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let resumed = || three.install(|| resume(&run, &Registry::default(), &mut ()));
    let says = resumed().unwrap_err().to_string();
    let place = Path::new("starts").join("4").display().to_string();
    assert!(
        says.contains(&format!("{place}: the folder is not empty")),
        "{says}"
    );
    fs::remove_file(stray).unwrap();
    resumed().unwrap();
    assert_eq!(designs(&run), designs(&whole));
}

/// Another run in the folder of a start is neither resumed nor copied.
#[test]
fn another_run_in_the_folder_of_a_start_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    begin_search(folder.path());
    let start = folder_of(folder.path(), 4);
    let mut other = RunPlan::new("test", plan().scene, 4);
    other.scene.physics.gravity = 1.0;
    optimise(&start, &other, &mut StopAfter(1)).unwrap_err();
    let before = fs::read(start.join(SNAPSHOT)).unwrap();
    let error = resume(folder.path(), &Registry::default(), &mut ()).unwrap_err();
    let says = error.to_string();
    assert!(
        says.contains("is expected") && error.exit_code() == 2,
        "{says}"
    );
    assert_eq!(fs::read(start.join(SNAPSHOT)).unwrap(), before);
}

/// A start is ranked by its score, then by its median.
#[test]
fn the_best_start_is_chosen_by_its_score() {
    let folder = tempfile::tempdir().unwrap();
    let summary = optimise(
        &folder.path().join("a"),
        &RunPlan::new("test", tiny(), 3),
        &mut (),
    );
    let mut summary = summary.unwrap();
    let score = summary.displacement_selection_score;
    // The score does not depend on whether the robot gets far.
    assert!(summary.reliability.stays_in_place());
    assert_eq!(score, summary.displacement_selection_p50);
    summary.displacement_selection_score = Some(-1.0);
    assert_eq!(summary.rank(), [-1.0, score.unwrap()]);
    summary.displacement_selection_score = None;
    assert_eq!(summary.rank(), [f64::NEG_INFINITY, score.unwrap()]);
}
