use super::reference::FINER;
use super::{Accuracy, Discretisation, Method, Precision, Run, errors, order};
use crate::table::{Cell, Row, Standing};
use crate::verify::probe::small;
use cosmic::case::Case;
use cosmic::scene::Integrator;

/// A 2x2 robot in the air, silent: motion without contact.
fn falling() -> Case {
    let mut case = small([2, 2], |scene| {
        (scene.lattice.drop, scene.physics.steps) = (1.0, 64);
        scene.controller.gain = [0.0; 2];
    });
    for (i, v) in case.start.v.iter_mut().enumerate() {
        *v = [0.1 * i as f64, 0.2 - 0.1 * i as f64].into();
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
    let failures = accuracy.section().failures;
    assert!(failures.is_empty(), "{failures:?}");
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
    let failed: Vec<_> = (accuracy.runs.iter().zip(&table.rows))
        .filter(|(_, row)| row.standing == Standing::Failed)
        .collect();
    // Among the runs that diverge, only the run with the scene's own time step was expected to stay finite.
    assert!(failed.len() == 1 && failed[0].0.is_default, "{failed:?}");
    assert!(!section.failures.is_empty());
    assert!(accuracy.runs.iter().all(|run| run.finite || !run.stable));
}

#[test]
fn a_run_that_is_expected_to_diverge_is_not_a_failure() {
    let mut case = falling();
    // Stable with the substeps of the scene, unstable without them.
    case.materials.stiffness = [1e4; 3];
    case.physics.substeps = 16;
    let accuracy = Accuracy::of(&case);
    let section = accuracy.section();
    let diverged = |run: &&Run| !run.finite;
    let expected = accuracy.runs.iter().filter(diverged).count();
    assert!(expected > 0 && accuracy.default_run().finite, "{expected}");
    let table = &section.tables[0];
    let says = |row: &&Row| {
        let status = row.cells.last().unwrap();
        *status == "diverged as expected: step beyond the stable one".into()
    };
    let rows: Vec<_> = table.rows.iter().filter(says).collect();
    assert_eq!(rows.len(), expected);
    assert!(rows.iter().all(|row| row.standing == Standing::Plain));
    for table in &section.tables[..2] {
        let text = table.to_html();
        assert!(!text.contains("failed"), "{text}");
    }
}

/// Errors of runs that went astray say nothing of the time step: no order is taken from them, and
/// no figure is drawn to their size.
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
    let lines = accuracy.lines(&Precision::ALL, |run| [run.dt, run.time].into());
    let points: usize = lines.iter().map(|line| line.points.len()).sum();
    assert_eq!(points, sound.len());
}

/// A row's own method with steps 64 times shorter is no truth where contacts decide: it differs
/// from row to row, and the error of a long step hides in it.
#[test]
fn all_rows_are_held_against_one_motion() {
    let mut case = falling();
    // From 0.01 m it lands before the last of the times.
    case.start.x.iter_mut().for_each(|x| x[1] -= 0.99);
    let accuracy = Accuracy::of(&case);
    let finest = Discretisation {
        method: Method {
            integrator: Integrator::SymplecticEuler,
            substeps: 4,
        },
        share: 1.0,
    };
    let fine = finest.case(&case, FINER, 1);
    let truth = finest.seen::<f64>(&fine, finest.marks(accuracy.marks, FINER));
    let double = |run: &&Run| run.precision == Precision::Double;
    for run in accuracy.runs.iter().filter(double) {
        let row = Discretisation {
            method: run.method,
            share: run.dt / case.physics.dt,
        };
        let seen = row.seen::<f64>(&row.case(&case, 1, 1), row.marks(accuracy.marks, 1));
        for (k, error) in errors(&seen, &truth).into_iter().enumerate() {
            // The uncertainty of the reference, and as much for the other run, whose steps are as fine.
            // An error that is left out is below three times the uncertainty.
            let one = accuracy.reference.uncertainty[k];
            match run.error[k] {
                Some(found) => assert!((found - error).abs() < 2.0 * one, "{k}: {error} {run:?}"),
                None => assert!(error < 5.0 * one, "{k}: {error} {run:?}"),
            }
        }
    }
    assert!(accuracy.default_run().error.iter().all(Option::is_some));
    let steps: Vec<f64> = accuracy.held.iter().map(|held| held.dt).collect();
    assert_eq!(steps, [0.004, 0.002, 0.001, 0.0005, 0.00025]);
    let substep = accuracy.reference.substep;
    assert!(accuracy.held.iter().all(|held| held.substep == substep));
}

#[test]
fn what_is_not_resolved_is_left_out() {
    let mut accuracy = Accuracy::of(&falling());
    for run in &mut accuracy.runs {
        (run.error, run.held, run.order) = ([None; 4], [None; 4], None);
    }
    let section = accuracy.section();
    let table = &section.tables[0];
    let errors = |name: &str| name.starts_with("error_") || name == "order";
    let empty: Vec<usize> = (0..table.columns.len())
        .filter(|&k| errors(&table.columns[k].name))
        .collect();
    assert_eq!(empty.len(), 5);
    let mut rows = table.rows.iter();
    assert!(rows.all(|row| empty.iter().all(|&k| row.cells[k] == Cell::Missing)));
    assert!(!section.figures.iter().any(|f| f.draw().contains("NaN")));
    assert!(section.failures.is_empty());
    // The references are told all the same, the common one and one for every time step.
    assert_eq!(section.tables[2].rows.len(), 6);
}

#[test]
fn an_order_is_that_of_errors_which_are_known() {
    let long = [Some(4.0), None, Some(8.0), Some(0.0)];
    let short = [Some(2.0), Some(1.0), Some(1.0), Some(0.0)];
    // Halved and an eighth: the mean of the middle two, 1 and 3.
    assert_eq!(order(&long, &short), Some(2.0));
    assert_eq!(order(&long, &[None, Some(1.0), None, None]), None);
}
