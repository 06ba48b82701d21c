use cosmic::Registry;
use cosmic::scene::Scene;
use cosmic_lab::sweep::{PlannedScene, SweepPlan};
use std::num::NonZeroUsize;
use std::path::Path;

pub(super) fn plan(names: &[&str], first_seed: u64) -> SweepPlan {
    let scene = |name: &&str| PlannedScene::new((*name).to_owned(), &Scene::paper());
    SweepPlan {
        study: None,
        first_seed,
        seeds: NonZeroUsize::new(3).unwrap(),
        iterations: None,
        scenes: names.iter().map(scene).collect(),
    }
}

#[test]
fn runs_are_numbered_scene_by_scene() {
    let plan = plan(&["a", "b"], 5);
    let folders: Vec<_> = (0..plan.runs())
        .map(|k| plan.folder(Path::new("s"), k))
        .collect();
    let expected = ["a-5", "a-6", "a-7", "b-5", "b-6", "b-7"];
    assert_eq!(folders, expected.map(|name| Path::new("s/runs").join(name)));
    let fifth = plan.run(4, &Registry::default()).unwrap();
    assert_eq!((fifth.seed, &fifth.name[..]), (6, "b"));
}

#[test]
fn plans_that_cannot_be_carried_out_are_refused() {
    let refusal = |plan: SweepPlan| plan.check(&Registry::default()).unwrap_err().to_string();
    assert!(refusal(plan(&[], 0)).contains("has no scene"));
    assert!(refusal(plan(&["../a"], 0)).contains("`../a` cannot be"));
    assert!(refusal(plan(&["a"], u64::MAX)).contains("too many"));
}
