use crate::small::small;
use cosmic::case::Case;
use cosmic::judge::verdict::Level;
use cosmic::lattice::State;
use cosmic::scene::Integrator;
use cosmic_lab::check::accuracy::{Accuracy, FINER, Method, Reference, Run, errors};
use cosmic_lab::check::loads::{LoadsOfStep, accuracy, answers, loads_of_steps};
use cosmic_lab::report::sheet::Section;
use cosmic_lab::table::{Cell, Emphasis};

/// A robot of 2x2 nodes that falls from `height` (m), and whose controller does nothing.
fn falling(height: f64) -> Case {
    let mut case = small([2, 2], |scene| {
        (scene.lattice.drop, scene.physics.steps) = (height, 64);
        scene.controller.gain = [0.0; 2];
    });
    for (i, v) in case.start.v.iter_mut().enumerate() {
        *v = [0.1 * i as f64, 0.2 - 0.1 * i as f64].into();
    }
    case
}

/// In free flight, the errors of symplectic Euler and of implicit steps fall with the time step, and those of leapfrog are
/// smaller. Single precision adds its rounding.
#[test]
fn errors_fall_with_the_time_step_down_to_rounding() {
    let case = falling(1.0);
    let accuracy = Accuracy::of(&case);
    assert_eq!(accuracy.marks, [4, 64]);
    let section = accuracy.section();
    assert!(section.failures.is_empty(), "{:?}", section.failures);
    let runs = &accuracy.runs;
    assert!(runs.iter().all(|run| run.time > 0.0 && run.stable));
    let [euler, leapfrog, implicit, single] = [0, 4, 8, 12].map(|k| &runs[k..k + 4]);
    for runs in [euler, implicit] {
        let [first, last] = [&runs[0], &runs[3]].map(|run| run.error[1].unwrap());
        assert!((4.0..12.0).contains(&(first / last)), "{runs:?}");
    }
    let of = |runs: &[Run]| runs[0].error[1].unwrap();
    assert!(of(leapfrog) < 0.5 * of(euler), "{leapfrog:?}");
    assert!(single[0].is_single && euler[0].is_default);
    let rounding = (of(single) - of(euler)).abs();
    assert!((1e-9..1e-3).contains(&rounding), "{rounding:e}");
}

/// The order of a method is observed, and errors that do not fall are not called ok: in free flight they fall, after a
/// contact those of long steps do not.
#[test]
fn orders_of_convergence_are_observed() {
    let case = falling(1.0);
    let flying = Accuracy::of(&case);
    let [euler, leapfrog, implicit] = [0, 4, 8].map(|k| &flying.runs[k..k + 4]);
    for (runs, expected) in [(euler, 1.0), (implicit, 1.0), (leapfrog, 1.0)] {
        assert_eq!(runs[0].order, [None; 2]);
        for order in runs[1..].iter().filter_map(|run| run.order[1]) {
            // Higher terms of the error and the damping of the springs change the order by less than a third.
            assert!((0.67..2.4).contains(&(order / expected)), "{runs:?}");
        }
    }
    let section = flying.section();
    let says = |section: &Section, text: &str| {
        (section.answers.iter()).any(|answer| answer.text.contains(text))
    };
    assert!(
        says(&section, "symplectic euler: the errors converge: order "),
        "{:?}",
        section.answers
    );
    let status = |section: &Section, row: usize| section.tables[0].rows[row].cells.last().cloned();
    assert_eq!(status(&section, 0), Some(Cell::from("ok")));
    // Suppose that the errors of the implicit steps grow while the time step falls.
    let mut growing = flying;
    for (k, run) in growing.runs[8..12].iter_mut().enumerate() {
        run.error[1] = Some([8.2e-3, 9.2e-3, 9.8e-3, 9.9e-3][k]);
        run.order[1] = (k > 0).then_some(-0.1);
    }
    let section = growing.section();
    assert!(says(
        &section,
        "implicit: the errors do not converge at these time steps"
    ));
    assert!(says(&section, "order -0.1 at"), "{:?}", section.answers);
    for row in 8..12 {
        assert_eq!(
            status(&section, row),
            Some(Cell::from("errors do not fall"))
        );
    }
    assert!(section.failures.is_empty());
    // Suppose that those of leapfrog fall from the first to the last, but grow once, and that f32 does the same as f64.
    for (k, error) in [2.9e-3, 1.7e-4, 5.5e-4, 3.8e-4].into_iter().enumerate() {
        growing.runs[4 + k].error[1] = Some(error);
    }
    growing.runs[6].order[1] = Some(-1.7);
    growing.runs[2].order[1] = Some(0.2);
    growing.runs[14].order[1] = Some(0.2);
    growing.runs[15].order[1] = Some(0.2);
    let section = growing.section();
    let unsteady = "the errors fall, but not from every time step to the next";
    assert!(
        says(&section, &format!("leapfrog: {unsteady}")),
        "{:?}",
        section.answers
    );
    let shown = |row: usize| status(&section, row).unwrap();
    let slow = "errors do not fall";
    assert_eq!([5, 6, 7].map(shown), ["ok", slow, "ok"].map(Cell::from));
    assert_eq!(
        [14, 15].map(shown),
        [slow, "errors do not fall: rounding"].map(Cell::from)
    );
}

/// Forces and power of a robot at rest on the ground do not depend on the time step; those of a robot that lands do.
#[test]
fn forces_and_power_are_compared_at_several_time_steps() {
    let case = falling(0.05);
    let found = loads_of_steps(&case);
    assert_eq!(found.len(), 4);
    assert!(
        found
            .iter()
            .all(|step| step.force > 0.0 && step.force_p99 <= step.force)
    );
    let section = accuracy(&case);
    let table = section
        .tables
        .iter()
        .find(|table| table.name == "loads")
        .unwrap();
    assert_eq!(table.rows.len(), 4);
    let at = |force: f64| LoadsOfStep { force, ..found[0] };
    let says =
        |forces: [f64; 2]| answers(&forces.map(at)).map(|answer| (answer.level, answer.text));
    let [(level, text), (power, _)] = says([34.6, 39.7]);
    assert_eq!((level, power), (Level::Doubtful, Level::Good));
    assert!(
        text.contains("largest force depends a little on the time step (by 15 %): 34.6 N at"),
        "{text}"
    );
    assert_eq!(says([34.6, 35.0])[0].0, Level::Good);
    assert_eq!(says([34.6, 50.0])[0].0, Level::Bad);
    assert_eq!(says([34.6, f64::NAN])[0].0, Level::Bad);
}

/// A run that diverges is a failure only if its time step is stable or if it is the scene's own run. Charts do not show
/// its error, which says nothing about the time step.
#[test]
fn diverged_runs_are_failures_unless_they_were_expected() {
    for (stiffness, substeps) in [(1e4, 16), (1e4, 1)] {
        let mut case = falling(1.0);
        (case.scene.materials.stiffness, case.scene.physics.substeps) = ([stiffness; 3], substeps);
        let accuracy = Accuracy::of(&case);
        let section = accuracy.section();
        for (run, row) in accuracy.runs.iter().zip(&section.tables[0].rows) {
            assert!(run.finite || !run.stable);
            let fails = run.is_default && !run.finite;
            assert_eq!(row.emphasis == Emphasis::Failed, fails, "{run:?}");
        }
        // Explicit steps take as many substeps as they need, so other runs than the own one are stable.
        let stable = accuracy.runs.iter().filter(|run| run.stable).count();
        assert!(stable >= 12, "{:?}", accuracy.runs);
        let own = accuracy.runs.iter().find(|run| run.is_default).unwrap();
        assert_eq!(own.finite, substeps == 16);
        assert_eq!(section.failures.is_empty(), own.finite);
        assert_eq!(section.tables[0].to_html().contains("failed"), !own.finite);
        let points = section.charts[0].lines.iter().map(|line| line.points.len());
        let resolved = |run: &&Run| run.stable && run.error[0].is_some();
        let resolved = accuracy.runs.iter().filter(resolved).count();
        assert_eq!(points.sum::<usize>(), resolved);
    }
}

/// All rows are compared with the same reference. Suppose that each row had its own reference, computed with the row's
/// method and steps 64 times shorter. These references would differ after contacts, which would hide the error of a
/// long step.
#[test]
fn all_rows_are_compared_with_one_motion() {
    // The robot lands before the last mark.
    let case = falling(0.01);
    let accuracy = Accuracy::of(&case);
    let finest = Method {
        integrator: Integrator::SymplecticEuler,
        substeps: 4,
    };
    let truth = finest.run::<f64>(&case, 1.0 / FINER as f64, accuracy.marks);
    for run in accuracy.runs.iter().filter(|run| !run.is_single) {
        let states = run.method.run::<f64>(&case, run.fraction, accuracy.marks);
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
    let own = accuracy.runs.iter().find(|run| run.is_default).unwrap();
    assert!(own.error.iter().all(Option::is_some));
}

#[test]
fn errors_are_at_least_three_uncertainties() {
    // Returns states of a single node, which has the position `x[k]` at mark `k`.
    let along = |x: [f64; 2]| {
        x.map(|x| State::new(vec![[x, 0.0]], vec![[0.0; 2]]))
            .to_vec()
    };
    let mut reference = Reference {
        uncertainty: [1.0, 1.0],
        states: along([0.0; 2]),
    };
    assert_eq!(reference.errors(&along([2.5, 3.0])), [None, Some(3.0)]);
    // The NaN of a diverged run counts as an error that is resolved.
    let found = reference.errors(&along([f64::NAN, 0.0]));
    assert!(found[0].is_some_and(f64::is_nan) && found[1].is_none());
    // If the reference diverged, no error is resolved.
    reference.uncertainty = [f64::INFINITY; 2];
    assert_eq!(reference.errors(&along([9.0, f64::NAN])), [None; 2]);
}
