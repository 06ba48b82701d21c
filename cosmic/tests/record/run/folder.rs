use crate::small::{StopAfter, tiny};
use cosmic::Registry;
use cosmic::record::{RunPlan, allow_unstable, deliver_so_far, optimise, resume};
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

/// A `scene.toml` that was changed after the run began is refused by all that reads or continues the run.
#[test]
fn a_changed_scene_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let [finished, begun] = ["finished", "begun"].map(|name| folder.path().join(name));
    let plan = RunPlan::new("tiny", tiny(), 0);
    optimise(&finished, &plan, &mut ()).unwrap();
    optimise(&begun, &plan, &mut StopAfter(2)).unwrap_err();
    let registry = Registry::default();
    let mut other = tiny();
    other.physics.gravity = 3.0;
    for run in [&finished, &begun] {
        fs::write(run.join("scene.toml"), other.to_run_toml()).unwrap();
    }
    let refusals = [
        resume(&finished, &registry, &mut ()).err(),
        resume(&begun, &registry, &mut ()).err(),
        deliver_so_far(&begun, &folder.path().join("so_far"), None, &registry).err(),
        allow_unstable(&begun, &registry).err(),
    ];
    for refusal in refusals {
        let refusal = refusal.unwrap().to_string();
        let says = "scene.toml: this is not the scene with which the run began; remove the file";
        assert!(refusal.contains(says), "{refusal}");
    }
    for run in [finished, begun] {
        fs::remove_file(run.join("scene.toml")).unwrap();
        resume(&run, &registry, &mut ()).unwrap();
    }
}
