use super::plan::plan;
use cosmic::Registry;
use cosmic::scene::Scene;
use cosmic_lab::sweep::{PLAN, PlannedScene, SweepPlan};
use std::fs;

#[test]
fn a_frozen_plan_reads_back_and_a_study_may_replace_it() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut plan = plan(&["a", "b"], 0);
    let registry = Registry::default();
    plan.freeze(folder, &registry).unwrap();
    let read = SweepPlan::read(folder).unwrap();
    assert_eq!(read, plan);
    assert_eq!(read.run(4, &registry).unwrap().scene, Scene::paper());
    let mut scene = Scene::paper();
    scene.physics.gravity = 5.0;
    plan.scenes[0] = PlannedScene::new("a".to_owned(), &scene);
    plan.write(folder).unwrap();
    assert_eq!(SweepPlan::read(folder).unwrap(), plan);
    assert_eq!(plan.run(1, &registry).unwrap().scene, scene);
}

/// The refusal of edited plans is tested with the program, in `an_edited_plan_is_refused`.
#[test]
fn another_layout_of_the_file_is_no_edit_and_a_plan_needs_no_copy() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let plan = plan(&["a"], 0);
    plan.freeze(folder, &Registry::default()).unwrap();
    let text = fs::read_to_string(folder.join(PLAN)).unwrap();
    fs::write(folder.join(PLAN), text.replace(",\"seeds\"", ", \"seeds\"")).unwrap();
    assert_eq!(SweepPlan::read(folder).unwrap(), plan);
    let swapped = text.replace("\"first_seed\":0", "\"first_seed\":9");
    fs::write(folder.join(PLAN), swapped).unwrap();
    let error = SweepPlan::read(folder).unwrap_err().to_string();
    assert!(error.contains("`first_seed` is 9, but was 0"), "{error}");
    fs::remove_file(folder.join("claims/plan.json")).unwrap();
    assert_eq!(SweepPlan::read(folder).unwrap().first_seed, 9);
}
