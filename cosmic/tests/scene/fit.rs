//! Schedules that are fitted into another number of iterations.

use cosmic::scene::{BUILTIN, Scene, StartKind};
use cosmic::search::{Phase, Schedule};
use std::num::NonZeroUsize;

fn fitted(scene: &Scene, iterations: usize) -> Scene {
    let iterations = NonZeroUsize::new(iterations).unwrap();
    scene.fitted(iterations).unwrap()
}

/// `earth` without windows, whose phases are shares of the run.
fn in_phases() -> Scene {
    let earth = Scene::load("earth").unwrap();
    earth.set(&["schedule.window=off"]).unwrap()
}

fn built_in() -> impl Iterator<Item = Scene> {
    BUILTIN.iter().map(|scene| Scene::load(scene.name).unwrap())
}

#[test]
fn the_scene_s_own_number_of_iterations_changes_nothing() {
    for scene in built_in() {
        let same = fitted(&scene, scene.schedule.iterations);
        assert_eq!(same, scene);
        assert_eq!(same.to_toml(), scene.to_toml());
    }
}

/// Whether a scene states its numbers or derives them, they are the same shares of the run.
#[test]
fn every_phase_keeps_its_share_of_the_run() {
    let derived = in_phases();
    let stated = derived
        .registry()
        .parse("run", &derived.to_run_toml())
        .unwrap();
    assert!(stated.following().is_empty() && !derived.following().is_empty());
    for scene in [&stated, &derived] {
        let short = fitted(scene, 60);
        assert_eq!(short.schedule.iterations, 60);
        assert_eq!(short.schedule.attraction_from, 34);
        assert_eq!(short.schedule.snap_at, 48);
        assert_eq!(short.schedule.horizon_over, [16, 30]);
        assert_eq!(short.binarisation.threshold_over, [4, 20]);
        // The steps and the rates stay.
        assert_eq!(short.schedule.horizon, scene.schedule.horizon);
        assert_eq!(short.adam, scene.adam);
    }
    // A longer run stretches.
    assert_eq!(fitted(&stated, 900).schedule.snap_at, 720);
    // With windows the bars are decided at once, however long the run is.
    let windows = fitted(&Scene::load("earth").unwrap(), 900);
    assert_eq!(
        (windows.schedule.snap_at, windows.schedule.iterations),
        (1, 900)
    );
}

/// A key that a new setting adds must be fitted too: whatever counts iterations doubles.
#[test]
fn every_number_of_an_iteration_is_fitted() {
    let mut scene = Scene::paper();
    let limits = scene.field("schedule.snap_at").unwrap().limits;
    let mut doubled = fitted(&scene, 600);
    let numbers = |scene: &mut Scene| -> Vec<(String, Vec<f64>)> {
        let of_section = |section: &str, settings: &mut dyn cosmic::settings::Settings| {
            let fields = settings.fields().into_iter();
            let fields = fields.filter(|field| field.limits == limits);
            let number = |text: &str| text.parse::<f64>().ok();
            fields
                .map(|field| {
                    let text = field.value.toml();
                    let list = text.trim_matches(['[', ']']).split(", ");
                    (
                        format!("{section}.{}", field.key),
                        list.filter_map(number).collect(),
                    )
                })
                .collect::<Vec<_>>()
        };
        scene.of_sections(of_section).concat()
    };
    let before = numbers(&mut scene);
    assert!(before.len() >= 4, "{before:?}");
    for ((key, before), (_, after)) in before.into_iter().zip(numbers(&mut doubled)) {
        let twice: Vec<_> = before.iter().map(|at| 2.0 * at).collect();
        assert_eq!(after, twice, "{key}");
    }
}

/// However short a run is, its phases are in order, and it ends with a layout. From two iterations on, the controller is
/// tuned on this layout.
#[test]
fn the_shortest_runs_have_every_phase_in_order() {
    // The stable step of many nodes takes long.
    for scene in built_in().filter(|scene| scene.lattice.columns <= 6) {
        let mut before = 0;
        for iterations in [1, 2, 3, 5, 60] {
            let short = fitted(&scene, iterations);
            short.check().unwrap();
            let schedule = &short.schedule;
            if scene.start.kind == StartKind::Layout {
                assert_eq!(schedule.snap_at, 0);
                continue;
            }
            let snap_at = schedule.snap_at;
            assert!(snap_at >= 1 && snap_at >= before && schedule.attraction_from <= snap_at);
            assert!(snap_at < iterations || iterations == 1, "{iterations}");
            before = snap_at;
            let phase = Schedule::at(&short, iterations).phase();
            let expected = match iterations {
                1 => Phase::Snap,
                _ => Phase::FineTuning,
            };
            assert_eq!(phase, expected);
        }
    }
}

/// A run that begins with a layout has only its fine-tuning. Its iterations are counted after the snap, which stays.
#[test]
fn a_run_that_begins_after_the_snap_is_fitted_behind_it() {
    let after = |scene: &Scene, iterations: usize| {
        let iterations = NonZeroUsize::new(iterations).unwrap();
        scene.fitted_after_snap(iterations).unwrap()
    };
    let earth = in_phases();
    assert_eq!(after(&earth, 60).to_toml(), earth.to_toml());
    for iterations in [1, 7, 100] {
        let tuned = after(&earth, iterations);
        let schedule = &tuned.schedule;
        assert_eq!(
            (schedule.snap_at, schedule.iterations),
            (240, 240 + iterations)
        );
        assert_eq!(schedule.horizon_over, [80, 150]);
        // What is read again is what was planned.
        let again = tuned.registry().parse("run", &tuned.to_run_toml()).unwrap();
        assert_eq!(again, tuned);
        assert_eq!(Scene::parse("template", &tuned.to_toml()).unwrap(), tuned);
    }
    let late = earth.set(&["schedule.horizon_over=[200, 270]"]).unwrap();
    assert_eq!(after(&late, 20).schedule.horizon_over, [200, 250]);
    // A scene without a snap is all fine-tuning.
    let layout = Scene::load("baseline_tall").unwrap();
    assert_eq!(after(&layout, 50), fitted(&layout, 50));
}

/// A fitted number that the scene does not read would be warned about as a change without an effect.
#[test]
fn fitting_adds_no_warnings() {
    for scene in built_in() {
        let said = |scene: &Scene| {
            scene
                .warnings()
                .iter()
                .map(|d| d.to_string())
                .collect::<Vec<_>>()
        };
        assert_eq!(said(&fitted(&scene, 60)), said(&scene));
    }
}

#[test]
fn too_many_iterations_are_refused() {
    let earth = in_phases();
    let many = NonZeroUsize::new(100_001).unwrap();
    for (refused, number) in [
        (earth.fitted(many), "100001"),
        (earth.fitted_after_snap(many), "100241"),
        (
            earth.fitted_after_snap(NonZeroUsize::MAX),
            "18446744073709551615",
        ),
    ] {
        let said = refused.unwrap_err().to_string();
        assert!(
            said.contains(number) && said.contains("from 1 to 1e5"),
            "{said}"
        );
    }
}
