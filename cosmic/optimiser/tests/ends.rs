//! How runs end, mainly on problems that are infeasible, degenerate or not finite.

use autodiff::{Real, jacobian, lit};
use cosmic_optimiser::mma::{self, Options, Variant};
use cosmic_optimiser::{OptimiserError, Problem, Solution, Status, Stop, augmented};

use super::problems::DRIVERS;

/// Makes a problem from the bounds of its variables and its functions.
macro_rules! problem {
    ($bounds:expr, |$x:ident| $values:expr) => {{
        fn values<R: Real>($x: &[R]) -> Vec<R> {
            $values
        }
        let [lower, upper] = [0, 1].map(|side| $bounds.map(|bound: [f64; 2]| bound[side]));
        Problem::new(&lower, &upper, values, |x| jacobian(values, x).into_vec())
    }};
}

/// Runs every driver on a problem: GCMMA, plain MMA and the augmented Lagrangian. Checks that the results are finite and
/// within the bounds.
fn ends(mut problem: Problem<'_>, start: &[f64]) -> [Solution; 3] {
    DRIVERS.map(|(name, driver)| {
        let end = driver(&mut problem, start).expect("a well-posed problem");
        let lists = [&end.point, &end.constraints, &end.multipliers];
        let single = [end.objective, end.kkt, end.violation];
        let finite = lists
            .into_iter()
            .flatten()
            .chain(&single)
            .all(|number| number.is_finite());
        assert!(finite, "{name}: {end:?}");
        end
    })
}

/// Asserts the statuses of all drivers.
#[track_caller]
fn assert_ends(problem: Problem<'_>, start: &[f64], expected: [Status; 3]) -> [Solution; 3] {
    let ends = ends(problem, start);
    assert_eq!(
        ends.each_ref().map(|end| end.status.clone()),
        expected,
        "{ends:?}"
    );
    ends
}

use Status::{Converged, Infeasible, IterationLimit, SmallStep};

const ALL_CONVERGED: [Status; 3] = [const { Converged }; 3];
const ALL_INFEASIBLE: [Status; 3] = [const { Infeasible }; 3];

#[test]
fn the_conservative_version_is_the_remedy_for_cycles() {
    let bowl = problem!([[-2.0, 2.0]; 2], |x| vec![x[0] * x[0] + x[1] * x[1]]);
    let [conservative, plain, _] =
        assert_ends(bowl, &[1.0, 1.0], [Converged, IterationLimit, Converged]);
    // The KKT residual 1e-6 is x divided by half of the range and by a tenth of the slope at the start.
    assert!(
        conservative.point.iter().all(|x| x.abs() < 1e-6),
        "{conservative:?}"
    );
    assert!(plain.point.iter().all(|x| x.abs() > 1e-3), "{plain:?}");
}

#[test]
fn infeasible_problems_are_reported() {
    let beyond_the_bound = problem!([[0.0, 1.0]; 2], |x| {
        vec![x[0] * x[0] + x[1] * x[1], lit(2.0) - x[0]]
    });
    let [end, ..] = assert_ends(beyond_the_bound, &[0.3, 0.4], ALL_INFEASIBLE);
    assert_eq!((end.point[0], end.violation), (1.0, 1.0));
    let gradient_zero = problem!([[-1.0, 2.0]; 2], |x| vec![
        x[0] + x[1],
        R::one() + x[0] * R::zero()
    ]);
    let _ = assert_ends(gradient_zero, &[1.0, 1.0], ALL_INFEASIBLE);
    // The point of the least violation of two discs apart is in the middle. Plain MMA cycles around it.
    let apart = problem!([[-5.0, 5.0]; 2], |x| {
        let disc = |centre: f64| (x[0] - lit(centre)).powi(2) + x[1] * x[1] - lit(1.0);
        vec![x[0] + x[1], disc(2.0), disc(-2.0)]
    });
    let _ = assert_ends(apart, &[0.3, 0.4], [Infeasible, IterationLimit, Infeasible]);
    // A local minimum of the violation. There is a solution at 3.7, but the first step of plain MMA jumps over it.
    let valley = || problem!([[0.0, 10.0]], |x| vec![x[0], x[0].sin() + lit(0.5)]);
    let _ = assert_ends(valley(), &[1.0], ALL_INFEASIBLE);
    let _ = assert_ends(valley(), &[5.0], [Converged, Infeasible, Converged]);
}

#[test]
fn redundant_constraints_do_no_harm() {
    let thrice = problem!([[0.0, 5.0]; 2], |x| {
        let constraint = lit(1.0) - x[0] * x[1];
        vec![
            x[0] + lit(2.0) * x[1],
            constraint,
            constraint,
            lit(3.0) * constraint,
        ]
    });
    for end in assert_ends(thrice, &[3.0, 3.0], ALL_CONVERGED) {
        // The minimum 2 sqrt 2 is at x = 2 y. The objective is exact to the KKT residual 1e-6 times a few.
        assert!((end.objective - 8.0_f64.sqrt()).abs() < 1e-5, "{end:?}");
    }
    let constant = problem!([[-1.0, 2.0]; 2], |x| vec![
        x[0] + x[1],
        x[0] * R::zero() - lit(1.0)
    ]);
    let _ = assert_ends(constant, &[1.0, 1.0], ALL_CONVERGED);
}

/// Two opposite inequalities have no interior. MMA creeps along them, because its models are convex in both directions.
#[test]
fn an_empty_interior_costs_mma_many_iterations() {
    let line = || {
        problem!([[0.0, 5.0]; 2], |x| {
            let sum = x[0] + x[1] - lit(1.0);
            vec![x[0] * x[0] + lit(2.0) * x[1] * x[1], sum, -sum]
        })
    };
    for end in ends(line(), &[3.0, 3.0]) {
        assert!(matches!(end.status, Converged | IterationLimit), "{end:?}");
        // The minimum is 2/3 at (2/3, 1/3). MMA gets as far as 1.5e-5 in a thousand iterations.
        assert!(
            (end.objective - 2.0 / 3.0).abs() < 1e-4 && end.violation < 1e-6,
            "{end:?}"
        );
    }
    let equality = problem!([[0.0, 5.0]; 2], |x| {
        vec![x[0] * x[0] + lit(2.0) * x[1] * x[1], x[0] + x[1] - lit(1.0)]
    });
    let mut equality = equality.with_equalities(1);
    let end = augmented::minimise(&mut equality, &[3.0, 3.0], &Stop::default()).unwrap();
    assert!(end.status == Converged && end.iterations < 100, "{end:?}");
}

#[test]
fn fixed_variables_stay() {
    let functions = |upper: f64| {
        problem!([[2.0, 2.0], [3.0, upper]], |x| vec![
            x[0] * x[1] * x[1],
            x[1] - lit(4.0)
        ])
    };
    for end in assert_ends(functions(5.0), &[2.0, 4.5], ALL_CONVERGED) {
        assert_eq!(end.point, [2.0, 3.0]);
    }
    let _ = assert_ends(functions(3.0), &[2.0, 3.0], ALL_CONVERGED);
    let all = problem!([[2.0, 2.0]], |x| vec![x[0], x[0] - lit(1.0)]);
    let _ = assert_ends(all, &[2.0], ALL_INFEASIBLE);
}

/// The only point that satisfies `x^2 <= 0` has no multipliers.
#[test]
fn missing_multipliers_give_a_status() {
    let cusp = problem!([[-1.0, 2.0]; 2], |x| vec![x[0] + x[1], x[0] * x[0]]);
    for end in ends(cusp, &[1.0, 1.0]) {
        assert!(
            matches!(end.status, Converged | SmallStep | IterationLimit),
            "{end:?}"
        );
        // The tolerance 1e-6 of x^2 allows x = 1e-3. Plain MMA oscillates at the least distance of its asymptotes,
        // 0.03.
        assert!(end.point[0].abs() < 1e-2 && end.violation < 1e-4, "{end:?}");
    }
    let kink = problem!([[-1.0, 2.0]; 2], |x| vec![x[0].abs() + x[1].abs()]);
    let [end, ..] = assert_ends(kink, &[1.0, 0.7], [SmallStep, IterationLimit, SmallStep]);
    assert!(end.objective < 1e-6);
}

/// The multiplier 1e4 exceeds the elastic cost 1000.
#[test]
fn multipliers_may_exceed_the_elastic_cost() {
    let small = problem!([[-1.0, 2.0]; 2], |x| {
        vec![
            x[0] + x[1],
            lit(-1e-4) * (x[0] + lit(2.0) * x[1] - lit(1.0)),
        ]
    });
    for end in assert_ends(small, &[1.0, 1.0], ALL_CONVERGED) {
        // At (-1, 1) the derivative by y is 0 = 1 - 2e-4 times the multiplier.
        assert!((end.multipliers[0] - 5e3).abs() < 1.0, "{end:?}");
    }
}

#[test]
fn a_constant_objective_finds_a_feasible_point() {
    let constant = problem!([[-1.0, 2.0]; 2], |x| vec![
        x[0] * R::zero(),
        lit(1.0) - x[0] * x[1]
    ]);
    let _ = assert_ends(constant, &[0.5, 0.5], ALL_CONVERGED);
}

fn failure(end: &Solution) -> (&str, f64, &[f64]) {
    match &end.status {
        Status::Failed(OptimiserError::NotFinite { what, value, point }) => (what, *value, point),
        other => panic!("{other:?}"),
    }
}

/// The logarithm is NaN below 0. Line searches and conservative models avoid the place; plain MMA fails with its name.
#[test]
fn values_that_are_not_finite_are_avoided_or_named() {
    let barrier = problem!([[-1.0, 2.0]], |x| vec![x[0] - lit(0.1) * x[0].ln()]);
    for (k, end) in ends(barrier, &[1.0]).iter().enumerate() {
        if k == 1 {
            let (what, value, point) = failure(end);
            assert!(
                what == "objective" && value.is_nan() && point[0] < 0.0,
                "{end:?}"
            );
            assert_eq!((end.point[0], end.objective), (1.0, 1.0));
        } else {
            // The minimum is at 0.1.
            assert!(
                end.status == Converged && (end.point[0] - 0.1).abs() < 1e-5,
                "{end:?}"
            );
        }
    }
}

#[test]
fn a_start_that_is_not_finite_is_named() {
    for (_, driver) in DRIVERS {
        let run = |values: fn(&[f64]) -> Vec<f64>, gradients: fn(&[f64]) -> Vec<f64>| {
            driver(
                &mut Problem::new(&[0.0; 2], &[1.0; 2], values, gradients),
                &[0.5, 0.25],
            )
            .unwrap()
        };
        let end = run(|_| vec![1.0, f64::NEG_INFINITY], |_| vec![1.0; 4]);
        assert_eq!(
            failure(&end),
            ("constraint 0", f64::NEG_INFINITY, &[0.5, 0.25][..])
        );
        assert!(
            end.point == [0.5, 0.25] && end.objective.is_nan(),
            "{end:?}"
        );
        let end = run(|_| vec![1.0, 2.0], |_| vec![1.0, 1.0, 1.0, f64::INFINITY]);
        assert_eq!(
            failure(&end).0,
            "derivative of the constraint 0 by variable 1"
        );
        let Status::Failed(error) = end.status else {
            unreachable!()
        };
        let message = "derivative of the constraint 0 by variable 1 is inf at x = [0.5, 0.25]; it must be finite";
        assert_eq!(error.to_string(), message);
    }
}

/// Values and derivatives are finite, but numbers that the drivers compute from them are not.
#[test]
fn overflow_is_a_status() {
    let overflow = Status::Failed(OptimiserError::Overflow);
    // The scaled derivative of the objective, and the square of the constraint.
    let mut steep = Problem::new(
        &[-1e10],
        &[1e10],
        |x| vec![1e300 * x[0], 1e200],
        |_| vec![1e300, 0.0],
    );
    for (name, driver) in DRIVERS {
        let end = driver(&mut steep, &[0.5]).unwrap();
        assert_eq!(end.status, overflow, "{name}");
    }
    // The curvature of the dual.
    for (_, driver) in &DRIVERS[..2] {
        let functions = |x: &[f64]| vec![x[0], 1e300 - 1e303 * x[0]];
        let mut problem = Problem::new(&[-1.0], &[1.0], functions, |_| vec![1.0, -1e303]);
        assert_eq!(driver(&mut problem, &[0.5]).unwrap().status, overflow);
    }
}

#[test]
fn ill_posed_problems_are_refused() {
    fn refused(problem: &mut Problem<'_>, start: &[f64]) -> Vec<String> {
        let error = |(_, driver): (&str, super::problems::Driver)| {
            driver(problem, start).unwrap_err().to_string()
        };
        DRIVERS.map(error).to_vec()
    }
    fn make(values: Vec<f64>, gradients: Vec<f64>) -> Problem<'static> {
        Problem::new(
            &[0.0; 2],
            &[1.0; 2],
            move |_| values.clone(),
            move |_| gradients.clone(),
        )
    }
    let fine = || make(vec![1.0], vec![1.0, 1.0]);
    for (mut problem, start, message) in [
        (fine(), &[0.5][..], "start: expected 2 entries, found 1"),
        (
            fine(),
            &[0.5, f64::NAN],
            "start: entry 1 is NaN; it must be finite",
        ),
        (
            fine(),
            &[0.5, 2.0],
            "start: variable 1 is 2; it must be within its bounds 0 to 1",
        ),
        (
            make(vec![], vec![]),
            &[0.5; 2],
            "values: expected an objective and 0 equalities or more, found 0 entries",
        ),
        (
            make(vec![1.0, 1.0], vec![1.0; 2]),
            &[0.5; 2],
            "gradients: expected 4 entries, found 2",
        ),
    ] {
        assert_eq!(refused(&mut problem, start), [message; 3]);
    }
    let nothing = |_: &[f64]| vec![0.0];
    let mut crossed = Problem::new(&[1.0], &[0.0], nothing, nothing);
    assert!(
        refused(&mut crossed, &[0.5])
            .iter()
            .all(|message| message.contains("variable 0: the lower bound"))
    );
    let mut unequal = Problem::new(&[1.0], &[2.0, 3.0], nothing, nothing);
    assert_eq!(
        refused(&mut unequal, &[1.5]),
        ["upper bounds: expected 1 entries, found 2"; 3]
    );
    assert_eq!(
        refused(&mut Problem::new(&[], &[], nothing, nothing), &[]),
        ["the problem has no variables"; 3]
    );
    // MMA alone needs finite bounds and inequalities.
    let mut open = Problem::new(&[0.0], &[f64::INFINITY], nothing, nothing);
    let error = mma::minimise(&mut open, &[0.5], &Options::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "upper bounds: entry 0 is inf; it must be finite"
    );
    let stop = Stop {
        kkt: 0.0,
        ..Stop::default()
    };
    let error = augmented::minimise(&mut fine(), &[0.5; 2], &stop).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the tolerance `kkt` is 0; it must be finite and above 0"
    );
    let mut equality = make(vec![1.0, 1.0], vec![1.0; 4]).with_equalities(1);
    let error = mma::minimise(&mut equality, &[0.5; 2], &Options::default()).unwrap_err();
    assert!(
        error.to_string().contains("use augmented::minimise"),
        "{error}"
    );
}

/// The stopping rule has no units: with the objective and a variable in units of powers of two, runs of MMA have the
/// same bits.
#[test]
fn units_do_not_matter() {
    for variant in [Variant::Conservative, Variant::Plain] {
        let run = |unit: f64, money: f64| {
            let values = move |x: &[f64]| {
                let (x, y) = (x[0] / unit, x[1]);
                vec![money * (x + 2.0 * y + x * x * y), 1.0 - x * y]
            };
            let gradients = move |x: &[f64]| {
                let functions = jacobian(
                    |x| {
                        let (x, y) = (x[0] / unit, x[1]);
                        vec![money * (x + 2.0 * y + x * x * y), 1.0 - x * y]
                    },
                    x,
                );
                functions.into_vec()
            };
            let mut problem = Problem::new(&[0.0; 2], &[4.0 * unit, 4.0], values, gradients);
            let options = Options {
                variant,
                ..Options::default()
            };
            mma::minimise(&mut problem, &[3.0 * unit, 3.0], &options).unwrap()
        };
        let (one, other) = (run(1.0, 1.0), run(1024.0, 2.0_f64.powi(-30)));
        assert_eq!(one.status, Converged);
        assert_eq!(one.point, [other.point[0] / 1024.0, other.point[1]]);
        assert_eq!((one.kkt, one.iterations), (other.kkt, other.iterations));
    }
}
