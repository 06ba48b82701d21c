use super::{Accuracy, DOUBLE, FINER, Method, PRECISIONS, Reference, Run, errors, order};
use crate::table::{Cell, Standing, Table};
use crate::verify::probe::{Probe, small};
use cosmic::case::Case;
use cosmic::lattice::State;
use cosmic::scene::Integrator;
use cosmic::simulator::Trajectory;

/// A 2x2 robot in the air, silent: motion without contact.
fn falling() -> Case {
    let mut case = small([2, 2], |scene| {
        (scene.lattice.drop, scene.physics.steps) = (1.0, 64);
        scene.controller.gain = [0.0; 2];
    });
    for (i, v) in case.start.v.iter_mut().enumerate() {
        *v = [0.1 * i as f64, 0.2 - 0.1 * i as f64];
    }
    case
}

#[test]
fn orders_rounding_and_energy_are_as_the_integrators_are() {
    let mut accuracy = Accuracy::of(&falling());
    assert_eq!(accuracy.marks, [4, 16, 32, 64]);
    let failures = accuracy.section().failures;
    assert!(failures.is_empty(), "{failures:?}");
    for run in &accuracy.runs {
        assert!(run.time > 0.0);
        let order = match run.method.integrator {
            Integrator::SymplecticEuler => 1.0,
            Integrator::Leapfrog => 2.0,
        };
        // Hundreds of steps, each with some ten roundings of numbers near 1.
        let rounding = [1e-9..1e-3, 0.0..1e-12, 0.0..f64::MIN_POSITIVE];
        let of_type = &rounding[run.precision];
        assert!(of_type.contains(&run.rounding[3]), "{run:?}");
        if run.method.substeps == 1 && run.precision == DOUBLE && run.dt <= 0.001 {
            // Vibrations of dt omega = 0.3 and less: the next term is a tenth of the first.
            assert!((run.order.unwrap() - order).abs() < 0.15, "{run:?}");
            // The energy ripples by dt omega at most, and leaks nothing but ripples.
            assert!(run.energy.ripple < 0.4, "{run:?}");
            assert!(run.energy.drift.abs() < 0.5 * run.energy.ripple, "{run:?}");
        }
    }
    // Nothing is shown that is not resolved.
    for run in &mut accuracy.runs {
        (run.error, run.order) = ([None; 4], None);
    }
    let section = accuracy.section();
    let rows = &section.tables[0].rows;
    assert!(
        rows.iter()
            .all(|row| row.cells[4..9] == [const { Cell::Missing }; 5])
    );
    assert!(!section.figures.iter().any(|f| f.draw().contains("NaN")));
    assert!(section.failures.is_empty());
}

/// A run that diverges is a failure only if it was expected to stay finite. Its error tells nothing about
/// the time step: no order is taken from it, and no figure shows it.
#[test]
fn diverged_runs_are_failures_unless_they_were_expected() {
    // Too stiff for any of the time steps except the shortest ones; stable with the substeps of the
    // scene only; unstable without them.
    for (stiffness, substeps) in [(4e6, 1), (1e4, 16), (1e4, 1)] {
        let mut case = falling();
        (case.materials.stiffness, case.physics.substeps) = ([stiffness; 3], substeps);
        let accuracy = Accuracy::of(&case);
        let section = accuracy.section();
        let rows = accuracy.runs.iter().zip(&section.tables[0].rows);
        for (run, row) in rows {
            assert!(run.finite || !run.stable);
            let fails = run.is_default && !run.finite;
            assert_eq!(row.standing == Standing::Failed, fails, "{run:?}");
            let expected = !run.finite && !fails;
            let says = "diverged as expected: step beyond the stable one";
            assert_eq!(row.cells.last() == Some(&says.into()), expected, "{run:?}");
        }
        let own = accuracy.default_run().finite;
        assert_eq!(section.failures.is_empty(), own);
        let shown: String = section.tables[..2].iter().map(Table::to_html).collect();
        assert_eq!(shown.contains("failed"), !own);
        let (sound, astray): (Vec<&Run>, Vec<_>) =
            accuracy.runs.iter().partition(|run| run.is_sound());
        assert!(!astray.is_empty() && astray.iter().all(|run| run.order.is_none()));
        let mut orders = sound.iter().filter_map(|run| run.order);
        assert!(orders.all(|order| order.abs() < 10.0));
        let lines = accuracy.lines(0..PRECISIONS.len(), |run| [run.dt, run.time]);
        let points: usize = lines.iter().map(|line| line.points.len()).sum();
        assert_eq!(points, sound.len());
    }
}

/// Every row is compared with one motion. A run of the row's own method with steps 64 times shorter would
/// not do where contacts decide: it differs from row to row, and hides the error of a long step.
#[test]
fn all_rows_are_compared_with_one_motion() {
    let mut case = falling();
    // From 0.01 m it lands before the last of the times.
    case.start.x.iter_mut().for_each(|x| x[1] -= 0.99);
    let accuracy = Accuracy::of(&case);
    let seen = |method: Method, share: f64| {
        let (case, at) = method.applied(&case, accuracy.marks, share);
        Probe::new(&case).run::<f64>(at)
    };
    let finest = Method {
        integrator: Integrator::SymplecticEuler,
        substeps: 4,
    };
    let truth = seen(finest, 1.0 / FINER as f64);
    for run in accuracy.runs.iter().filter(|run| run.precision == DOUBLE) {
        let seen = seen(run.method, run.dt / case.physics.dt);
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
}

#[test]
fn errors_are_at_least_three_uncertainties_and_orders_medians_of_what_is_known() {
    // One node so far along at each of the times.
    let along = |x: [f64; 4]| Trajectory {
        steps: vec![1, 2, 3, 4],
        states: x
            .map(|x| State {
                x: vec![[x, 0.0]],
                v: vec![[0.0; 2]],
            })
            .to_vec(),
    };
    let mut reference = Reference {
        uncertainty: [1.0, 1.0, 1.0, 0.0],
        seen: along([0.0; 4]),
    };
    // A row that went astray is wrong by any measure.
    let found = reference.errors(&along([2.5, 3.0, f64::NAN, 0.0]));
    assert!(found[2].is_some_and(f64::is_nan) && reference.is_sound());
    assert_eq!([found[0], found[1], found[3]], [None, Some(3.0), Some(0.0)]);
    // Against a reference that went astray, nothing is known of any row.
    reference.uncertainty = [f64::INFINITY; 4];
    let found = reference.errors(&along([9.0, 9.0, f64::NAN, 0.0]));
    assert!(found == [None; 4] && !reference.is_sound());

    let long = [Some(4.0), None, Some(8.0), Some(0.0)];
    let short = [Some(2.0), Some(1.0), Some(1.0), Some(0.0)];
    // Halved and an eighth: the mean of the middle two, 1 and 3.
    assert_eq!(order(&long, &short), Some(2.0));
    assert_eq!(order(&long, &[None, Some(1.0), None, None]), None);
}
