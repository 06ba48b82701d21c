//! Scenes that the tests share, and the tests of an iteration.

use autodiff::{Memory, Real};

use crate::codesign::{CoDesign, Evaluator, Progress, Record};
use crate::design::{Design, flips};
use crate::objective::Loss;
use crate::scene::{LossKind, Scene};
use crate::simulator::Trajectory;

/// A scene with a small robot that moves from the start and can get several layouts. The text ends in `[schedule]`
/// without `iterations`, so that tests can append that setting.
pub(super) const LIVELY: &str = "
    base = 'stability'
    [lattice]
    columns = 3
    rows = 3
    drop = 0.05
    [physics]
    steps = 256
    [controller]
    gain = [6.0, 6.0]
    [volume]
    widening = 0.2
    widening_over = [1, 2]
    [loss]
    window = 32
    [schedule]
    attraction_from = 4
    snap_at = 7
    horizon = [64, 64]
";

/// A user's loss: minus the mean of two heights of the payload, after half of the steps and at the end.
pub(crate) struct Up;

impl Loss for Up {
    fn observed(&self, steps: usize) -> Vec<usize> {
        vec![steps / 2, steps]
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        let heights: Vec<R> = trajectory.states.iter().map(|s| -s.x[0][1]).collect();
        R::sum_of(&heights) * R::lit(0.5)
    }
}

/// A scene with a robot of two squares, simulated for a few steps.
pub(crate) fn tiny() -> Scene {
    let mut scene = Scene::paper();
    (scene.lattice.columns, scene.lattice.rows) = (3, 2);
    (scene.physics.steps, scene.controller.hidden) = (24, 3);
    scene.schedule.iterations = 12;
    (scene.schedule.attraction_from, scene.schedule.snap_at) = (8, 11);
    scene.schedule.horizon = [24, 24];
    scene.loss.kind = LossKind::Final;
    scene
}

/// The evaluator of a scene, and the state before the first iteration.
pub(super) fn begun(scene: &Scene) -> (Evaluator, Progress) {
    let codesign = CoDesign::new(scene).unwrap();
    let progress = codesign.begin(1).unwrap();
    (codesign.evaluator, progress)
}

/// The optimisation of a seed, and its state after some iterations.
pub(super) fn after(scene: &Scene, iterations: usize, seed: u64) -> (CoDesign, Progress) {
    let mut codesign = CoDesign::new(scene).unwrap();
    let mut progress = codesign.begin(seed).unwrap();
    while progress.iteration < iterations {
        codesign.iterate(&mut progress);
    }
    (codesign, progress)
}

/// The records of an optimisation.
pub(crate) fn records(scene: &Scene) -> Vec<Record> {
    let mut records = Vec::new();
    let mut codesign = CoDesign::new(scene).unwrap();
    (codesign.optimise(0, |record| records.push(record.clone()))).unwrap();
    records
}

#[test]
fn a_memory_budget_changes_no_bit() {
    let text = [LIVELY, "iterations = 9"].concat();
    let scene = Scene::parse("lively", &text).unwrap();
    let mut bounded = scene.clone();
    // This budget of 20 kB is too small for a horizon: each of its 64 steps takes more than 1 kB.
    bounded.gradient.memory = Some(0.02);
    let task = CoDesign::new(&bounded).unwrap().task().clone();
    assert_eq!(task.simulator.memory, Memory::Bytes(20_000));
    let histories = [scene, bounded].map(|scene| records(&scene));
    let [all, within] = histories.map(|history| format!("{history:?}"));
    assert!(all == within);
}

/// The merit of the robot of a seed after a snap that compares `trials` alternative layouts.
fn after_the_snap(trials: usize, seed: u64) -> f64 {
    let mut scene = Scene::parse("snapped", &[LIVELY, "iterations = 8"].concat()).unwrap();
    scene.schedule.snap_trials = trials;
    let (mut codesign, mut progress) = after(&scene, scene.schedule.snap_at - 1, seed);
    let soft = codesign.evaluator.design(&progress);
    codesign.iterate(&mut progress);
    let layout = progress.design.layout().unwrap();
    // The number of flips belongs to the chosen layout, not to one that it was compared with.
    assert_eq!(progress.flips, flips(&soft.mixtures(), layout));
    assert_eq!(
        codesign.evaluator.design(&progress),
        Design::Layout(layout.to_vec())
    );
    codesign.evaluator.evaluate(&progress).merit
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
