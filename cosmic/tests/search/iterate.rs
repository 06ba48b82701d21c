use crate::small::{MOBILE_ROBOT, after, begun, records};
use autodiff_programs::Memory;
use cosmic::design::{Design, flips};
use cosmic::scene::Scene;
use cosmic::search::Schedule;

#[test]
fn a_memory_budget_changes_no_bit() {
    let text = [MOBILE_ROBOT, "iterations = 9"].concat();
    let scene = Scene::parse("lively", &text).unwrap();
    let mut bounded = scene.clone();
    // This budget of 20 kB is too small for a horizon: each of its 64 steps takes more than 1 kB.
    bounded.gradient.memory = Some(0.02);
    let (codesign, progress) = begun(&bounded);
    let at = codesign.point(&progress, &Schedule::at(&bounded, 1));
    assert_eq!(at.horizon.memory, Memory::Bytes(20_000));
    let histories = [scene, bounded].map(|scene| records(&scene));
    let [all, within] = histories.map(|history| format!("{history:?}"));
    assert!(all == within);
}

/// The merit of the robot of a seed after a snap that compares `trials` alternative layouts.
fn after_the_snap(trials: usize, seed: u64) -> f64 {
    let mut scene = Scene::parse("snapped", &[MOBILE_ROBOT, "iterations = 8"].concat()).unwrap();
    scene.schedule.snap_trials = trials;
    let (mut codesign, mut progress) = after(&scene, scene.schedule.snap_at - 1, seed);
    let soft = codesign.design(&progress);
    codesign.iterate(&mut progress);
    let layout = progress.design.layout().unwrap();
    // The number of flips belongs to the chosen layout, not to one that it was compared with.
    assert_eq!(progress.flips, flips(&soft.mixtures(), layout));
    assert_eq!(codesign.design(&progress), Design::Layout(layout.to_vec()));
    codesign.evaluate(&progress).merit
}

#[test]
fn trials_at_the_snap_find_better_robots() {
    let merits = |seed| [0, 8].map(|trials| after_the_snap(trials, seed));
    let pairs: Vec<_> = (0..4).map(merits).collect();
    assert!(
        pairs.iter().all(|[plain, tried]| tried >= plain),
        "{pairs:?}"
    );
    assert!(
        pairs.iter().any(|[plain, tried]| tried > plain),
        "{pairs:?}"
    );
}
