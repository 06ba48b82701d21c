use crate::small::{StopAfter, tiny};
use cosmic::Registry;
use cosmic::record::{Observer, Run, RunPlan, deliver_so_far, history, optimise, resume_of};
use cosmic::search::Record;
use std::collections::BTreeMap;
use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The files of a folder.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let file = |entry: fs::DirEntry| {
        let name = entry.file_name().into_string().unwrap();
        (name, fs::read(entry.path()).unwrap())
    };
    entries.map(file).collect()
}

#[test]
fn a_delivery_overwrites_no_files() {
    let folder = tempfile::tempdir().unwrap();
    let [run, foreign, into] = ["run", "foreign", "into"].map(|name| folder.path().join(name));
    let plan = RunPlan::new("tiny", tiny(), 1);
    optimise(&run, &plan, &mut StopAfter(4)).unwrap_err();
    fs::create_dir(&foreign).unwrap();
    fs::write(foreign.join("my.csv"), "my own").unwrap();
    let deliver = |into: &Path| deliver_so_far(&run, into, None, &Registry::default());
    // The folder of the run itself is refused too, because a delivery would end the run.
    for into in [&foreign, &run] {
        let before = files(into);
        let error = deliver(into).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains("not empty"), "{error}");
        assert_eq!(files(into), before);
    }
    assert_eq!(deliver(&into).unwrap().iterations, 4);
    // The run continues.
    resume_of(&run, &plan, &mut ()).unwrap();
}

/// Asks the run to stop while the iteration after `after` is computed: the flag is set when iteration `after` has ended.
struct StopsInside {
    after: usize,
    flag: Arc<AtomicBool>,
}

impl Observer for StopsInside {
    fn iteration(&mut self, _: &Run, record: &Record) -> ControlFlow<()> {
        assert!(
            record.iteration <= self.after,
            "an abandoned iteration is shown"
        );
        self.flag
            .store(record.iteration == self.after, Ordering::Relaxed);
        ControlFlow::Continue(())
    }

    fn stop(&self) -> Option<Arc<AtomicBool>> {
        Some(Arc::clone(&self.flag))
    }
}

/// An iteration that is interrupted inside its rollouts is abandoned. The run is saved as it was before the iteration, and
/// a resumed run ends with the same results.
#[test]
fn an_iteration_that_is_interrupted_inside_is_abandoned() {
    let folder = tempfile::tempdir().unwrap();
    let plan = RunPlan::new("tiny", tiny(), 1);
    let whole = folder.path().join("whole");
    optimise(&whole, &plan, &mut ()).unwrap();
    // Iteration 12 is the last one, so the flag stops the delivery.
    for after in 1..=12 {
        let run = folder.path().join(after.to_string());
        let flag = Arc::default();
        let error = optimise(&run, &plan, &mut StopsInside { after, flag }).unwrap_err();
        assert_eq!(error.exit_code(), 75, "{error}");
        let says = format!("after iteration {after}");
        assert!(error.to_string().contains(&says), "{error}");
        assert_eq!(history::read(&run, usize::MAX).unwrap().len(), after);
        resume_of(&run, &plan, &mut ()).unwrap();
        for file in ["design.json", "trajectory.json"] {
            let [resumed, whole] =
                [&run, &whole].map(|folder| fs::read(folder.join(file)).unwrap());
            assert!(resumed == whole, "{file} after {after}");
        }
    }
}

#[test]
fn a_run_of_another_plan_is_not_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let plan = RunPlan::new("tiny", tiny(), 1);
    optimise(&run, &plan, &mut StopAfter(4)).unwrap_err();
    let before = files(&run);
    let mut other = plan.clone();
    other.scene.physics.gravity = 1.0;
    let error = resume_of(&run, &other, &mut ()).unwrap_err();
    assert!(error.to_string().contains("is expected"), "{error}");
    assert_eq!(files(&run), before);
    let summary = resume_of(&run, &plan, &mut ()).unwrap();
    assert_eq!(summary.unwrap().iterations, 12);
    // The result for a finished run is `None`, so that two processes do not both report it.
    assert!(resume_of(&run, &plan, &mut ()).unwrap().is_none());
}
