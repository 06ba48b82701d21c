use crate::small::{LIVELY, after, begun, tiny};
use cosmic::codesign::{Candidate, CoDesign, Quantiles, Schedule, settle};
use cosmic::design::Material;
use cosmic::scene::Scene;
use cosmic::simulator::{BarLoad, Span};
use std::cell::Cell;

#[test]
fn a_delivery_stops_between_its_parts() {
    let (evaluator, progress) = begun(&tiny());
    let asked = Cell::new(0);
    let stops_at = |question: usize| {
        asked.set(0);
        let is_stopped = || {
            asked.set(asked.get() + 1);
            asked.get() == question
        };
        evaluator.deliver_unless(&progress, &is_stopped)
    };
    assert_eq!(stops_at(0), Some(evaluator.deliver(&progress)));
    let questions = asked.get();
    assert!(questions > 3);
    for question in 1..=questions {
        assert_eq!(stops_at(question), None);
        assert_eq!(asked.get(), question);
    }
}

/// The delivered strains and speeds are equal to those of a rollout that is observed at every step.
#[test]
fn delivered_loads_cover_every_step() {
    let scene = Scene::parse("lively", &[LIVELY, "iterations = 9"].concat()).unwrap();
    let (codesign, progress) = after(&scene, 9, 1);
    let delivery = codesign.evaluator().deliver(&progress);
    let design = codesign.evaluator().design(&progress);
    let loads = |every: usize| {
        let observed = (0..=scene.physics.steps).step_by(every).collect();
        let span = Span::from_start(observed);
        let task = codesign.task();
        let seen = task.rollout(
            &design,
            &delivery.controller,
            &codesign.evaluator().start,
            &span,
        );
        let moments = task.moments(&design, &delivery.controller, &seen);
        let bar = |(edge, m): (usize, &Material)| m.is_solid().then(|| BarLoad::of(edge, &moments));
        let materials = delivery.materials.iter().enumerate();
        materials.map(bar).collect::<Vec<_>>()
    };
    for (bar, other) in delivery.bars.iter().zip(loads(1)) {
        assert_eq!(bar.is_some(), other.is_some());
        let (Some(bar), Some(other)) = (bar, other) else {
            continue;
        };
        let motion = |bar: &BarLoad| (bar.strains, bar.strain, bar.speed);
        assert_eq!(motion(bar), motion(&other));
    }
    let peak = |bars: &[Option<BarLoad>]| {
        let actuators = bars.iter().zip(&delivery.materials);
        let actuators = actuators.filter(|(_, m)| **m == Material::Actuator);
        let peaks = actuators.filter_map(|(bar, _)| Some(bar.as_ref()?.speed.peak));
        peaks.fold(0.0, f64::max)
    };
    let told = delivery.loads.unwrap().speed.peak;
    assert_eq!(told, peak(&loads(1)));
    // The steps that `trajectory` keeps do not include the peak.
    assert!(told > peak(&loads(16)));
}

#[test]
fn an_undecided_design_has_neither_structure_nor_loads() {
    let codesign = CoDesign::new(&tiny()).unwrap();
    let delivery = codesign.evaluator().deliver(&codesign.begin(1).unwrap());
    assert!(delivery.along.is_finite());
    assert_eq!((delivery.structure, delivery.loads), (None, None));
    assert!(delivery.bars.is_empty());
}

#[test]
fn the_last_iterate_is_measured_once_if_it_is_also_a_candidate() {
    let (evaluator, mut progress) = begun(&tiny());
    let plain = evaluator.deliver(&progress);
    progress.note_candidate(1.0, evaluator.scene.selection.candidates);
    assert_eq!(evaluator.entrants(&progress).len(), 1);
    assert_eq!(evaluator.deliver(&progress), plain);
    evaluator.judge_candidates(&mut progress);
    assert_eq!(
        evaluator.entrants(&progress)[0].spread,
        Some(plain.selection)
    );
    // After another update, the candidate and the controller of the last iteration are different entrants.
    progress.controller.numbers_mut()[0] += 0.1;
    assert_eq!(evaluator.entrants(&progress).len(), 2);
}

/// An unreliable candidate with the better median is chosen only if its 10 % quantile beats the median of the
/// reliable one.
#[test]
fn an_unreliable_candidate_is_delivered_only_for_its_lower_quantile() {
    let mut scene = tiny();
    scene.schedule.settle = 1.0;
    let (evaluator, mut progress) = begun(&scene);
    let mut candidate = |bias: f64, merit: f64, [p10, p50]: [f64; 2]| {
        progress.controller.numbers_mut()[0] += bias;
        let spread = Quantiles { p10, p50, p90: p50 };
        Candidate {
            iteration: progress.iteration,
            merit,
            controller: progress.controller.clone(),
            spread: Some(spread),
        }
    };
    let last = candidate(0.0, 0.1, [0.1, 0.1]);
    let steady = candidate(0.1, 2.0, [1.9, 2.0]);
    let chosen = |rival: Candidate| {
        let mut progress = progress.clone();
        progress.controller = last.controller.clone();
        progress.candidates = vec![rival.clone(), steady.clone(), last.clone()];
        let delivered = evaluator.deliver(&progress).controller;
        let is = |c: &Candidate| c.controller == delivered;
        assert!(is(&rival) || is(&steady));
        let mut settled = progress.clone();
        assert!(settle(
            &evaluator,
            &mut settled,
            &Schedule::at(&evaluator.scene, 12),
            0.1
        ));
        assert_eq!(settled.controller, delivered);
        is(&rival)
    };
    let rival = |merit, spread| {
        let spread = Some(Quantiles { p90: 9.0, ..spread });
        let mut controller = steady.controller.clone();
        controller.numbers_mut()[0] += 0.1;
        Candidate {
            merit,
            controller,
            spread,
            ..steady.clone()
        }
    };
    let of = |p10, p50| Quantiles { p10, p50, p90: 9.0 };
    assert!(chosen(rival(3.0, of(2.9, 3.0))));
    // Both rivals are unreliable: the first because its 10 % quantile is low, the second because its unperturbed
    // rollout differs from the median.
    assert!(!chosen(rival(3.0, of(1.4, 3.0))));
    assert!(!chosen(rival(-4.2, of(1.8, 3.0))));
    assert!(chosen(rival(5.0, of(2.4, 5.0))));
}
