use crate::small::small;
use cosmic::case::Case;
use cosmic::lattice::State;
use cosmic::scene::Integrator;
use cosmic_lab::table::{Cell, Standing};
use cosmic_lab::verify::accuracy::{Accuracy, DOUBLE, FINER, Method, Reference, Run, errors};
use cosmic_lab::verify::probe::Probe;

/// A robot of 2x2 nodes that falls without touching the ground, and whose controller does nothing.
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

/// The rounding error of a run is as large as expected for its number type. Errors that are not resolved are empty
/// cells, and figures leave them out.
#[test]
fn rounding_is_that_of_the_number_type_and_unresolved_errors_are_not_shown() {
    let case = falling();
    let mut accuracy = Accuracy::of(&case);
    assert_eq!(accuracy.marks, [4, 16, 32, 64]);
    let failures = accuracy.section().failures;
    assert!(failures.is_empty(), "{failures:?}");
    for run in &mut accuracy.runs {
        assert!(run.time > 0.0);
        // In each of hundreds of steps, some ten numbers near 1 are rounded.
        let rounding = [1e-9..1e-3, 0.0..1e-12, 0.0..f64::MIN_POSITIVE];
        assert!(
            rounding[run.precision].contains(&run.rounding[3]),
            "{run:?}"
        );
        run.error = [None; 4];
    }
    let section = accuracy.section();
    for row in &section.tables[0].rows {
        assert_eq!(row.cells[4..8], [const { Cell::Missing }; 4]);
    }
    assert!(!section.figures.iter().any(|f| f.draw().contains("NaN")));
    assert!(section.failures.is_empty());
}

/// A run that diverges is a failure only if it is the scene's own run. Figures do not show its error, which says
/// nothing about the time step.
#[test]
fn diverged_runs_are_failures_unless_they_were_expected() {
    // The first case is stable only with the shortest time steps, and the second only with substeps. The third is the
    // second case without substeps.
    for (stiffness, substeps) in [(4e6, 1), (1e4, 16), (1e4, 1)] {
        let mut case = falling();
        (case.materials.stiffness, case.physics.substeps) = ([stiffness; 3], substeps);
        let accuracy = Accuracy::of(&case);
        let section = accuracy.section();
        for (run, row) in accuracy.runs.iter().zip(&section.tables[0].rows) {
            assert!(run.finite || !run.stable);
            let fails = run.is_default && !run.finite;
            assert_eq!(row.standing == Standing::Failed, fails, "{run:?}");
            let expected = "diverged as expected: unstable time step".into();
            let is_expected = !run.finite && !fails;
            assert_eq!(row.cells.last() == Some(&expected), is_expected, "{run:?}");
        }
        let own = accuracy.default_run().finite;
        assert_eq!(section.failures.is_empty(), own);
        assert_eq!(section.tables[0].to_html().contains("failed"), !own);
        let sound = accuracy.runs.iter().filter(|run| run.is_sound()).count();
        assert!(sound < accuracy.runs.len());
        let point = |run: &Run| [run.fraction, run.time].into();
        let lines = accuracy.lines(0..3, &point);
        let points: usize = lines.iter().map(|line| line.points.len()).sum();
        assert_eq!(points, sound);
    }
}

/// All rows are compared with the same reference. Suppose that each row had its own reference, computed with the row's
/// method and steps 64 times shorter. These references would differ after contacts, which would hide the error of a
/// long step.
#[test]
fn all_rows_are_compared_with_one_motion() {
    let mut case = falling();
    // The robot falls from a height of 0.01 m, so that it lands before the last mark.
    case.start.x.iter_mut().for_each(|x| x[1] -= 0.99);
    let accuracy = Accuracy::of(&case);
    let states = |method: Method, fraction: f64| {
        let (case, at) = method.applied(&case, accuracy.marks, fraction);
        Probe::new(&case).run::<f64>(&at)
    };
    let finest = Method {
        integrator: Integrator::SymplecticEuler,
        substeps: 4,
    };
    let truth = states(finest, 1.0 / FINER as f64);
    for run in accuracy.runs.iter().filter(|run| run.precision == DOUBLE) {
        let states = states(run.method, run.fraction);
        for (k, error) in errors(&states, &truth).into_iter().enumerate() {
            // The tolerance is twice the uncertainty: once for the reference, and once for the run `truth`, whose steps
            // are as short. An unresolved error may be up to three times the uncertainty.
            let one = accuracy.reference.uncertainty[k];
            match run.error[k] {
                Some(found) => assert!((found - error).abs() < 2.0 * one, "{k}: {run:?}"),
                None => assert!(error < 5.0 * one, "{k}: {error} {run:?}"),
            }
        }
    }
    assert!(accuracy.default_run().error.iter().all(Option::is_some));
}

#[test]
fn errors_are_at_least_three_uncertainties() {
    // Returns states of a single node, which has the position `x[k]` at mark `k`.
    let along = |x: [f64; 4]| {
        x.map(|x| State::new(vec![[x, 0.0]], vec![[0.0; 2]]))
            .to_vec()
    };
    let mut reference = Reference {
        uncertainty: [1.0, 1.0, 1.0, 0.0],
        states: along([0.0; 4]),
        coarser: along([0.0; 4]),
    };
    // The NaN of a diverged run counts as an error that is resolved.
    let found = reference.errors(&along([2.5, 3.0, f64::NAN, 0.0]));
    assert!(found[2].is_some_and(f64::is_nan));
    assert_eq!([found[0], found[1], found[3]], [None, Some(3.0), Some(0.0)]);
    // If the reference diverged, no error is resolved.
    reference.uncertainty = [f64::INFINITY; 4];
    let found = reference.errors(&along([9.0, 9.0, f64::NAN, 0.0]));
    assert_eq!(found, [None; 4]);
}
