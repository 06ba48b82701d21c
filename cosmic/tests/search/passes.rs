use crate::small::{records, tiny};
use autodiff::Real;
use cosmic::objective::Loss;
use cosmic::scene::{BinarisationMethod, ClockKind, GradientPrecision, Scene};
use cosmic::search::{CoDesign, Record};
use cosmic::world::Trajectory;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A loss whose gradient overflows in f32 but not in f64.
struct Steep;

impl Loss for Steep {
    fn observed(&self, steps: usize) -> Vec<usize> {
        vec![steps]
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        let heights = trajectory.states[0].x.iter().map(|x| x.up());
        R::sum_of(&heights.collect::<Vec<_>>()) * R::lit(1e25) * R::lit(1e25)
    }
}

#[test]
fn a_gradient_that_overflows_in_f32_is_skipped_and_the_run_goes_on() {
    let mut scene = tiny();
    scene.gradient.cotangent_bound = None;
    let skipped = |scene: &Scene| {
        let mut codesign = CoDesign::with_loss(scene, Steep).unwrap();
        let mut progress = codesign.begin(0).unwrap();
        while !codesign.is_done(&progress) {
            codesign.iterate(&mut progress);
        }
        progress.skipped
    };
    scene.gradient.precision = GradientPrecision::F32;
    let beyond = skipped(&scene);
    scene.gradient.precision = GradientPrecision::F64;
    assert!(beyond > skipped(&scene), "{beyond}");
}

/// A loss that is minus the height of the payload. It counts the rollouts in which a gradient is computed, and is
/// NaN in those whose number is in the range. Its gradient is always finite.
struct Failing(Range<usize>, AtomicUsize);

impl Loss for Failing {
    fn observed(&self, steps: usize) -> Vec<usize> {
        vec![steps]
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        let height = trajectory.payload(0).x.up();
        // Only rollouts of gradients count; other rollouts use plain numbers.
        let is_of_gradient = size_of::<R>() > size_of::<f64>();
        let call = self
            .1
            .fetch_add(usize::from(is_of_gradient), Ordering::Relaxed);
        let fails = is_of_gradient && self.0.contains(&call);
        -height + R::lit(if fails { f64::NAN } else { 0.0 })
    }
}

/// The records and the result of a run with the loss [`Failing`] and one gradient per iteration.
fn failing(calls: Range<usize>) -> (CoDesign, Vec<Record>, cosmic::Result<()>) {
    let mut scene = tiny();
    (scene.schedule.stability_share, scene.schedule.polish_trials) = (0.0, 0);
    scene.schedule.iterations = 14;
    let loss = Failing(calls, AtomicUsize::new(0));
    let mut codesign = CoDesign::with_loss(&scene, loss).unwrap();
    let mut records = Vec::new();
    let ended = codesign.optimise(1, |record| records.push(record.clone()));
    (codesign, records, ended.map(drop))
}

/// The gradient of a loss that is NaN may look finite. It must not be used.
#[test]
fn a_nan_loss_moves_nothing_and_is_counted() {
    let (_, records, ended) = failing(3..5);
    ended.unwrap();
    let skipped: Vec<_> = records.iter().map(|record| record.skipped).collect();
    assert_eq!(skipped[..6], [0, 0, 0, 1, 1, 0]);
    assert_eq!(records.iter().map(|r| r.skipped).sum::<usize>(), 2);
    for (record, skipped) in records.iter().zip(skipped) {
        let is_finite = record.loss_horizon.is_none_or(f64::is_finite);
        assert_eq!(is_finite, skipped == 0, "{record:?}");
    }
}

#[test]
fn a_loss_that_was_always_nan_ends_the_run() {
    let (_, records, ended) = failing(0..usize::MAX);
    let error = ended.unwrap_err();
    assert_eq!((records.len(), error.exit_code()), (10, 3));
    let says = error.to_string();
    for words in ["the loss", "after iteration 10", "NaN"] {
        assert!(says.contains(words), "{says}");
    }
    // One finite loss is enough to continue.
    let (codesign, records, ended) = failing(1..usize::MAX);
    ended.unwrap();
    assert_eq!(records.len(), codesign.scene().schedule.iterations);
}

/// If every robot exceeds the speed bound, no displacement is recorded, but all gradients are used.
#[test]
fn a_robot_that_flies_apart_has_gradients_but_no_displacement() {
    let mut scene = tiny();
    scene.physics.speed_bound = Some(1e-3);
    let mut codesign = CoDesign::new(&scene).unwrap();
    let mut progress = codesign.begin(0).unwrap();
    let bounded: Vec<_> = (0..10).map(|_| codesign.iterate(&mut progress)).collect();
    let free = records(&tiny());
    for (record, free) in bounded.iter().zip(&free) {
        assert_eq!(record.displacement.is_some(), free.displacement.is_some());
        assert_eq!(record.diverged, free.displacement.is_some());
        for displacement in [record.displacement, record.displacement_horizon] {
            assert!(displacement.is_none_or(f64::is_nan), "{record:?}");
        }
        assert!(free.displacement_horizon.is_none_or(f64::is_finite));
        assert_eq!(record.design_gradient, free.design_gradient);
        assert_eq!(record.controller_gradient, free.controller_gradient);
        assert_eq!(record.skipped, 0);
    }
    assert!(bounded[9].diverged && bounded[9].displacement_horizon.is_some());
}

/// If a projection has no share in the update, its gradient is not computed, and the gradient of the other
/// projection does not change.
#[test]
fn a_projection_without_a_share_is_left_out() {
    let mut scene = tiny();
    let both = records(&scene);
    for (share, left, out) in [(0.0, 0, 1), (1.0, 1, 0)] {
        scene.schedule.stability_share = share;
        let alone = records(&scene);
        let designs = alone.iter().filter(|r| r.design_gradient[left].is_some());
        assert!(designs.count() > 0);
        let nothing = |r: &Record| r.design_gradient[out].is_none() && r.mma[out].is_none();
        assert!(alone.iter().all(nothing));
        // The first update has the same start in both runs.
        let gradient = |records: &[Record]| records[0].design_gradient[left].unwrap();
        assert_eq!(gradient(&alone), gradient(&both));
        assert!(alone[0].displacement_horizon.is_some());
    }
}

/// The tempo of a learned clock has its own bound, a third of that of the weights, so its large derivative does not change
/// their update. It moves at three times their rate.
#[test]
fn the_tempo_has_its_own_bound_and_rate() {
    let mut scene = tiny();
    scene.gradient.cotangent_bound = None;
    // The first update of the controller is that of the second iteration.
    let moved = |scene: &Scene| {
        let mut codesign = CoDesign::with_loss(scene, Steep).unwrap();
        let mut progress = codesign.begin(0).unwrap();
        (0..2).for_each(|_| _ = codesign.iterate(&mut progress));
        progress
    };
    let fixed = moved(&scene);
    scene.controller.clock = ClockKind::Learned;
    let learned = moved(&scene);
    // After one update, Adam's mean is a tenth of the bounded gradient.
    let count = fixed.controller.weights();
    let (weights, tempo) = learned.adam.mean.split_at(count);
    assert_eq!(weights, fixed.adam.mean);
    let norm = |mean: &[f64]| mean.iter().map(|g| g * g).sum::<f64>().sqrt();
    assert!((norm(weights) - 0.1).abs() < 1e-12, "{}", norm(weights));
    assert!((norm(tempo) - 0.1 / 3.0).abs() < 1e-12, "{}", norm(tempo));
    let steps = learned.controller.numbers()[count].abs() / scene.adam.rate;
    assert!((steps - 3.0).abs() < 1e-6, "{steps}");
}

#[test]
fn measures_can_be_constraints_beside_the_volumes() {
    let mut scene = tiny();
    let rows = |records: &[Record]| records[0].mma[0].as_ref().unwrap().elastic.len();
    assert_eq!(rows(&records(&scene)), 4);
    scene.binarisation.method = BinarisationMethod::Constraints;
    scene.binarisation.threshold_over = [0, 1];
    let strict = records(&scene);
    assert_eq!(rows(&strict), 8);
    let multipliers = |record: &Record| record.multipliers == [0.0; 4];
    assert!(strict.iter().all(multipliers));
    // Each edge comes closer to having one material.
    assert!(strict[9].measures[0] < strict[0].measures[0]);
}
