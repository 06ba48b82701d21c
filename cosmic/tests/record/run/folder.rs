use crate::small::tiny;
use cosmic::Registry;
use cosmic::record::{RunPlan, optimise, resume};
use cosmic::scene::LossKind;
use std::fs;

#[test]
fn a_refusal_leaves_no_lock() {
    let folder = tempfile::tempdir().unwrap();
    let resumed = resume(folder.path(), &Registry::default(), &mut ());
    assert_eq!(resumed.unwrap_err().exit_code(), 4);
    fs::write(folder.path().join("b"), "").unwrap();
    let begun = optimise(folder.path(), &RunPlan::new("tiny", tiny(), 0), &mut ());
    assert_eq!(begun.unwrap_err().exit_code(), 2);
    let files = fs::read_dir(folder.path()).unwrap();
    assert!(files.map(|file| file.unwrap().file_name()).eq(["b"]));
}

/// A scene that a program builds is checked like a scene file. Otherwise its run could not be resumed.
#[test]
fn a_scene_that_could_not_be_read_again_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let mut plan = RunPlan::new("tiny", tiny(), 0);
    plan.scene.schedule.horizon = [8, 8];
    plan.scene.loss.window = 16;
    plan.scene.loss.kind = LossKind::Mean;
    let refused = optimise(&run, &plan, &mut ()).unwrap_err();
    assert_eq!(refused.exit_code(), 2);
    let says = "the shortest horizon has only 8";
    assert!(refused.to_string().contains(says), "{refused}");
    assert!(!run.exists());
}
