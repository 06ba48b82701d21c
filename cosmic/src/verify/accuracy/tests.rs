use super::{Accuracy, Precision, Run};
use crate::case::Case;
use crate::report::sheet::Standing;
use crate::scene::{Integrator, Scene};

/// A 2x2 robot in the air, silent: motion without contact.
fn falling() -> Case {
    let mut scene = Scene::default();
    (scene.lattice.columns, scene.lattice.rows) = (2, 2);
    (scene.lattice.drop, scene.physics.steps) = (1.0, 64);
    (scene.controller.hidden, scene.controller.gain) = (2, [0.0; 2]);
    let mut case = Case::of_scene(&scene, 0).unwrap();
    for (i, v) in case.start.v.iter_mut().enumerate() {
        *v = [0.1 * i as f64, 0.2 - 0.1 * i as f64];
    }
    case
}

fn runs(accuracy: &Accuracy, integrator: Integrator, precision: Precision) -> Vec<&Run> {
    let belongs = |run: &&Run| {
        run.method.integrator == integrator
            && run.method.substeps == 1
            && run.precision == precision
    };
    accuracy.runs.iter().filter(belongs).collect()
}

#[test]
fn orders_rounding_and_energy_are_as_the_integrators_are() {
    let accuracy = Accuracy::of(&falling());
    assert_eq!(accuracy.marks, [4, 16, 32, 64]);
    assert!(accuracy.failures().is_empty(), "{:?}", accuracy.failures());
    for (integrator, order) in [
        (Integrator::SymplecticEuler, 1.0),
        (Integrator::Leapfrog, 2.0),
    ] {
        let double = runs(&accuracy, integrator, Precision::Double);
        assert_eq!(double.len(), 5);
        for run in &double[2..] {
            // Vibrations of dt omega = 0.3 and less: the next term is a tenth of the first.
            assert!((run.order.unwrap() - order).abs() < 0.15, "{run:?}");
            // The energy ripples by dt omega at most, and leaks nothing but ripples.
            assert!(run.energy.ripple < 0.4, "{run:?}");
            assert!(run.energy.drift.abs() < 0.5 * run.energy.ripple, "{run:?}");
        }
        for run in double {
            // Hundreds of steps, each with some ten roundings of numbers near 1.
            assert!(run.rounding.iter().all(|&e| e < 1e-12), "{run:?}");
        }
        let single = runs(&accuracy, integrator, Precision::Single);
        assert!(single.iter().all(|run| run.rounding[3] > 1e-9));
        let wide = runs(&accuracy, integrator, Precision::DoubleDouble);
        assert!(wide.iter().all(|run| run.rounding == [0.0; 4]));
    }
    assert!(accuracy.runs.iter().all(|run| run.time > 0.0));
}

#[test]
fn a_diverged_row_is_shown_as_failed() {
    let mut case = falling();
    // Stiff beyond any of the time steps but the shortest ones.
    case.materials.stiffness = [4e6; 3];
    let accuracy = Accuracy::of(&case);
    let section = accuracy.section();
    let table = &section.tables[0];
    let failed = table
        .rows
        .iter()
        .filter(|row| row.standing == Standing::Failed);
    assert!(failed.count() > 0);
    assert!(!section.failures.is_empty());
    assert!(accuracy.runs.iter().all(|run| run.finite || !run.stable));
}

/// Errors of runs that went astray say nothing of the time step: no order is taken from them, and no
/// figure is drawn to their size.
#[test]
fn what_went_astray_has_no_order_and_no_point() {
    let mut case = falling();
    case.materials.stiffness = [1e4; 3];
    let accuracy = Accuracy::of(&case);
    let (sound, astray): (Vec<_>, Vec<_>) = accuracy.runs.iter().partition(|run| run.is_sound());
    assert!(!sound.is_empty() && !astray.is_empty());
    assert!(astray.iter().all(|run| run.order.is_none()));
    assert!(sound.iter().any(|run| run.order.is_some()));
    let orders = sound.iter().filter_map(|run| run.order);
    assert!(orders.into_iter().all(|order| order.abs() < 10.0));
    let lines = accuracy.lines(&Precision::ALL, |run| [run.dt, run.error[0]]);
    let points: usize = lines.iter().map(|line| line.points.len()).sum();
    assert_eq!(points, sound.len());
}
