//! The gradient checker must accept right gradients, catch wrong ones, and recognise kinks.

use crate::common::{Formula, Sym, formula};
use autodiff::check::{Claim, Options, Report, Verdict, check_directions, check_gradient};
use autodiff::custom::{Rule, apply};
use autodiff::{DoubleDouble, Element, Function, Real, gradient, lit};

fn point(n: usize) -> Vec<f64> {
    (0..n).map(|i| 0.4 + 0.3 * (i as f64).sin()).collect()
}

/// A chain of smooth functions over all variables.
struct Smooth;

impl Function for Smooth {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        x.windows(2).fold(R::zero(), |sum, x| {
            (sum + x[0] * x[1].exp()).tanh() + x[0].sin() * x[1]
        })
    }
}

/// The function `x^3` with a rule that is wrong on purpose: the slope with respect to argument `of` is `wrong` times
/// the right slope.
struct WrongCube {
    of: usize,
    wrong: f64,
}

#[derive(Clone)]
struct Cube(f64);

impl Rule for Cube {
    fn value<R: Real>(&self, x: &[R]) -> R {
        x[0].powi(3)
    }
    fn partials<R: Real>(&self, x: &[R], _: R) -> Vec<R> {
        vec![R::lit(3.0 * self.0) * x[0] * x[0]]
    }
}

impl Function for WrongCube {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let cube = |i: usize| apply(Cube(if i == self.of { self.wrong } else { 1.0 }), &x[i..=i]);
        R::sum_of(&(0..x.len()).map(cube).collect::<Vec<_>>())
    }
}

/// Returns the default options with several seeds.
fn seeds() -> impl Iterator<Item = Options> {
    (0..20).map(|seed| Options {
        seed,
        ..Options::default()
    })
}

fn checked(function: &impl Function, x: &[f64]) -> Report {
    check_gradient(function, x, &Options::default())
}

type Value<'a> = &'a dyn Fn(&[DoubleDouble]) -> DoubleDouble;

/// Checks a claimed gradient at a point by difference quotients, without forward mode.
fn claimed(value: Value, [x, gradient]: [&[f64]; 2], options: &Options) -> Report {
    check_directions(value, &Claim::new(x, gradient), options)
}

/// Asserts that every seed gives this verdict, and that no seed accepts the negative control.
#[track_caller]
fn is(verdict: Verdict, value: Value, x: &[f64], gradient: &[f64]) {
    for options in seeds() {
        let report = claimed(value, [x, gradient], &options);
        assert_eq!(report.verdict, verdict, "{options:?}\n{report}");
        let found_out = report.control.is_none_or(|said| said == Verdict::Wrong);
        assert!(found_out, "{options:?}\n{report}");
    }
}

/// The order of the remainder must be 2, and a gradient that is wrong on purpose must be called wrong. Along a direction of
/// small curvature, the remainder may drown in rounding errors.
#[test]
fn right_gradients_are_smooth() {
    for n in [2, 7, 50] {
        let mut orders: Vec<f64> = Vec::new();
        for options in seeds() {
            let report = check_gradient(&Smooth, &point(n), &options);
            assert_eq!(report.verdict, Verdict::Smooth, "{report}");
            assert_eq!(report.control, Some(Verdict::Wrong), "{report}");
            let table = report.to_string();
            let line =
                "negative control: a gradient that is wrong on purpose, by 1 %, is called wrong";
            assert!(table.contains(line), "{table}");
            let taylor = report.directions.iter().filter_map(|row| row.taylor);
            orders.extend(taylor);
        }
        assert!(
            orders.iter().all(|order| (order - 2.0).abs() < 0.1),
            "{orders:?}"
        );
        assert!(orders.len() >= 70, "{n}: {} of 80", orders.len());
    }
}

/// A wrong rule must be found although forward and reverse mode agree on it, because the differences disagree. The
/// report must name the argument, also one of a thousand.
#[test]
fn a_wrong_rule_is_wrong_and_named() {
    for (n, of) in [(1, 0), (7, 0), (7, 6), (1000, 417)] {
        for wrong in [0.0, -1.0, 0.99, 1.001] {
            let report = checked(&WrongCube { of, wrong }, &point(n));
            assert_eq!(report.verdict, Verdict::Wrong, "{report}");
            let worst = report.worst.as_ref().expect("a wrong component");
            assert_eq!(
                (worst.index, worst.verdict),
                (of, Verdict::Wrong),
                "{report}"
            );
            // A direction that is nearly at right angles to the error does not show the error.
            for row in report.directions.iter().filter(|row| row.error > 1e-4) {
                let order = row.taylor.expect("a remainder above rounding errors");
                assert!((order - 1.0).abs() < 0.1, "{report}");
            }
        }
    }
}

/// Errors below the tolerance must pass and errors above it must not.
#[test]
fn the_tolerance_separates_right_from_wrong() {
    let function = WrongCube {
        of: 0,
        wrong: 1.001,
    };
    let verdict = |tolerance| {
        let options = Options {
            tolerance,
            ..Options::default()
        };
        check_gradient(&function, &[0.7], &options).verdict
    };
    assert_eq!(verdict(2e-3), Verdict::Smooth);
    assert_eq!(verdict(5e-4), Verdict::Wrong);
}

fn rectifier(at: f64) -> Formula {
    formula(2, |x| {
        let rectified = (x[0] - Sym::lit(at)).max(Sym::lit(0.0));
        x[1].sin() + rectified * x[1].exp() + x[0].abs() * x[0]
    })
}

#[test]
fn a_kink_at_the_point_is_a_kink() {
    let report = checked(&rectifier(0.5), &[0.5, 0.2]);
    assert_eq!(report.verdict, Verdict::Kink, "{report}");
    // In this case the central difference happens to equal the slope that the crate chose by convention. The verdict
    // must still be a kink.
    let report = checked(&formula(2, |x| x[0].abs() + x[1].exp()), &[0.0, 0.3]);
    assert_eq!(report.verdict, Verdict::Kink, "{report}");
}

#[test]
fn a_kink_beside_the_point_neither_alarms_nor_hides() {
    for distance in [1e-3, -1e-4, 1e-6, -1e-8, 1e-10] {
        let function = rectifier(0.5 + distance);
        let x = [0.5, 0.2];
        let mut slopes = gradient(|x| function.eval(x), &x);
        for (factor, verdict) in [(1.0, Verdict::Smooth), (1.001, Verdict::Wrong)] {
            slopes[1] *= factor;
            is(verdict, &|x| function.eval(x), &x, &slopes);
        }
    }
}

/// Checks a claimed slope at a point against differences and against a second claimed slope, which stands for forward
/// mode.
fn with_forward(value: Value, x: f64, [reverse, forward]: [f64; 2]) -> Report {
    let forward = |direction: &[f64]| forward * direction[0];
    let claim = Claim {
        x: &[x],
        gradient: &[reverse],
        forward: Some(&forward),
    };
    check_directions(value, &claim, &Options::default())
}

#[test]
fn a_second_source_that_disagrees_is_wrong() {
    for slope in [2.1, f64::INFINITY, f64::NAN] {
        let report = with_forward(&|x| x[0] * x[0], 1.0, [2.0, slope]);
        assert_eq!(report.verdict, Verdict::Wrong, "{report}");
    }
}

/// Slopes must not be compared if they are too small to change the last digit of the value over a step as long as `x`.
/// Two sources of derivatives may both be right and still differ there, for example where `tanh` is saturated.
#[test]
fn sources_may_disagree_below_the_value_s_last_digit() {
    let verdict = |x, disagree| {
        with_forward(&|_| lit(0.1) * DoubleDouble::lit(1.0), x, [0.0, disagree]).verdict
    };
    assert_eq!(verdict(0.5, 1e-37), Verdict::Smooth);
    assert_eq!(verdict(0.5, 1e-14), Verdict::Wrong);
    assert_eq!(verdict(1e3, 1e-17), Verdict::Wrong);
}

#[test]
fn what_is_not_finite_never_passes() {
    let verdict = |gradient: f64| {
        claimed(&|x| x[0] * x[0], [&[1.0], &[gradient]], &Options::default()).verdict
    };
    assert_eq!(verdict(f64::NAN), Verdict::Wrong);
    assert_eq!(verdict(f64::INFINITY), Verdict::Wrong);
    let root = formula(3, |x| x[0].sqrt() + x[1] + x[2]);
    for options in seeds() {
        let report = check_gradient(&root, &[0.0, 2.0, 1.0], &options);
        assert_ne!(report.verdict, Verdict::Smooth, "{report}");
        let worst = report.worst.expect("the component with the infinite slope");
        assert_eq!((worst.index, worst.gradient), (0, f64::INFINITY));
    }
    assert_ne!(checked(&root, &[-1.0, 2.0, 1.0]).verdict, Verdict::Smooth);
    // A check must end with a verdict even at an infinite point.
    let square = formula(1, |x| x[0] * x[0]);
    for x in [f64::INFINITY, f64::MAX] {
        assert_eq!(checked(&square, &[x]).verdict, Verdict::Kink);
    }
}

#[test]
fn the_table_says_it_all() {
    let report = checked(&WrongCube { of: 1, wrong: 2.0 }, &point(3));
    let table = report.to_string();
    assert_eq!(table.lines().count(), 1 + Options::default().directions + 3);
    assert!(table.contains("worst component 1:"), "{table}");
    assert!(table.contains("negative control: none"), "{table}");
    let header = table.lines().next().unwrap_or_default();
    assert!(header.contains("taylor"), "{table}");
    assert!(table.ends_with("verdict: wrong"), "{table}");
    let options = Options::named(["mass", "drag", "lift"].map(String::from).to_vec());
    let report = check_gradient(&WrongCube { of: 1, wrong: 2.0 }, &point(3), &options);
    let table = report.to_string();
    assert!(table.contains("worst component drag: "), "{table}");
}

/// In this claim the errors of two components cancel if all arguments move together. So the checker must look for the
/// worst component along the worst of the random directions.
#[test]
fn the_worst_direction_leads_to_the_worst_component() {
    for options in seeds() {
        let report = claimed(
            &|x| x.iter().sum(),
            [&[0.3, 0.5, 0.7, 0.2], &[1.5, 0.5, 1.0, 1.001]],
            &options,
        );
        assert!(
            report.worst.as_ref().is_some_and(|worst| worst.index < 2),
            "{report}"
        );
    }
}

/// An error in one component must be found even if the differences in another component are NaN.
#[test]
fn a_wrong_component_is_named_beside_one_that_cannot_be_judged() {
    let report = claimed(
        &|x| x[0] * x[0] + x[1].sqrt(),
        [&[0.3, 0.0], &[0.7, 0.0]],
        &Options::default(),
    );
    let worst = report.worst.expect("a wrong component");
    assert_eq!((worst.index, worst.verdict), (0, Verdict::Wrong));
}

/// The tolerance must be relative to the slope.
#[test]
fn a_verdict_does_not_depend_on_the_unit() {
    for unit in [1e-100, 1e-12, 1.0, 1e12, 1e100] {
        let is = |verdict, value: fn(DoubleDouble) -> DoubleDouble, at: f64, slope: f64| {
            is(
                verdict,
                &|x| lit(unit) * value(x[0]),
                &[at],
                &[unit * slope],
            );
        };
        is(Verdict::Smooth, Real::sin, 0.3, 0.3_f64.cos());
        is(Verdict::Wrong, Real::sin, 0.3, (1.0 + 3e-6) * 0.3_f64.cos());
        for between in [-1.0, 0.5, 1.0] {
            is(Verdict::Kink, Real::abs, 0.0, between);
        }
        is(Verdict::Wrong, Real::abs, 0.0, 1.1);
    }
}

/// Rosenbrock's function. At its minimum the value is zero and all arguments are one.
fn rosenbrock<R: Real>(x: &[R]) -> R {
    x.windows(2).fold(R::zero(), |sum, x| {
        let valley = x[1] - x[0] * x[0];
        sum + (R::one() - x[0]).powi(2) + R::lit(100.0) * valley * valley
    })
}

#[test]
fn gradients_at_stationary_points_are_judged() {
    let raised = |x: &[DoubleDouble]| rosenbrock(x) + lit(1e6);
    for n in [2, 10, 100] {
        for value in [&rosenbrock as Value, &raised] {
            is(Verdict::Smooth, value, &vec![1.0; n], &vec![0.0; n]);
        }
    }
    let one: [(Value, f64); 5] = [
        (&|x| x[0].powi(3), 0.0),
        (&|x| (x[0] - lit(0.3)).powi(3), 0.3),
        (&|x| x[0] * x[0].abs(), 0.0),
        (&|x| x[0].max(0.0).powi(2), 0.0),
        (&|_| DoubleDouble::lit(0.0), 0.3),
    ];
    for (value, x) in one {
        is(Verdict::Smooth, value, &[x], &[0.0]);
    }
    // A gradient that consists of rounding errors.
    let flat = |x: &[DoubleDouble]| lit(1e3) * (x[0].sin().powi(2) + x[0].cos().powi(2));
    is(Verdict::Smooth, &flat, &[0.7], &[1e-13]);
    for beside in [1e-12, 1e-8, 1e-3] {
        let x = [1.0 + beside, 1.0];
        is(Verdict::Smooth, &rosenbrock, &x, &gradient(rosenbrock, &x));
    }
    for wrong in [1e-8, 1e-3, 1.0] {
        is(Verdict::Wrong, &rosenbrock, &[1.0; 2], &[0.0, wrong]);
        is(Verdict::Wrong, &|x| x[0].powi(3), &[0.0], &[wrong]);
    }
}

#[test]
fn spikes_cusps_and_small_kinks_are_kinks() {
    for height in [1.0, 1e-6, 1e-9] {
        let spike = |x: &[DoubleDouble]| {
            let top = if x[0] == DoubleDouble::lit(0.0) {
                height
            } else {
                0.0
            };
            x[0] + x[1].sin() + lit(top)
        };
        is(Verdict::Kink, &spike, &[0.0, 0.3], &[1.0, 0.3f64.cos()]);
    }
    for power in [0.1, 1.0 / 3.0, 0.5, 0.9] {
        let cusp = |x: &[DoubleDouble]| x[0].abs().powf(power);
        is(Verdict::Kink, &cusp, &[0.0], &[0.0]);
        let joined = |x: &[DoubleDouble]| cusp(x) + x[1].exp();
        is(Verdict::Kink, &joined, &[0.0, 0.2], &[0.0, 0.2f64.exp()]);
    }
    is(Verdict::Kink, &|x| x[0].cbrt(), &[0.0], &[f64::INFINITY]);
    let small = |x: &[DoubleDouble]| lit(1e-3) * x[0].abs() + x[0] * x[0] + x[0];
    is(Verdict::Kink, &small, &[0.0], &[1.0]);
}

/// A smooth function plus a bump of the given width around `x[0] = 0`.
fn bump(x: &[DoubleDouble], width: f64) -> DoubleDouble {
    x[0] + x[1].sin() + (-(x[0] / lit(width)).powi(2)).exp()
}

#[test]
fn a_narrow_term_that_is_forgotten_is_wrong_and_named() {
    let cos = 0.4f64.cos();
    for width in [1e-2, 1e-4, 1e-6, 1e-8] {
        let value = |x: &[DoubleDouble]| bump(x, width);
        let at = [width, 0.4];
        is(Verdict::Wrong, &value, &at, &[1.0, cos]);
        let report = claimed(&value, [&at, &[1.0, cos]], &Options::default());
        assert_eq!(report.worst.map(|worst| worst.index), Some(0), "{width:e}");
        let slope = 1.0 - 2.0 / width * (-1f64).exp();
        is(Verdict::Smooth, &value, &at, &[slope, cos]);
        is(Verdict::Smooth, &value, &[0.0, 0.4], &[1.0, cos]);
    }
}

/// If a function varies over less than the step, the check is right only with a smaller step in the options. If a part of
/// it is computed in floats, only a larger step is right.
#[test]
fn the_step_suits_the_function() {
    let verdict = |value: Value, x: f64, slope: f64, step: f64| {
        let options = Options {
            step,
            ..Options::default()
        };
        claimed(value, [&[x], &[slope]], &options).verdict
    };
    let (x, inverse): (f64, Value) = (1e-13, &|x| x[0].recip());
    assert_ne!(verdict(inverse, x, -1.0 / x / x, 1e-11), Verdict::Smooth);
    for (factor, expected) in [(1.0, Verdict::Smooth), (1.001, Verdict::Wrong)] {
        assert_eq!(verdict(inverse, x, -factor / x / x, 1e-20), expected);
        let rounded: Value = &|x| DoubleDouble::from(x[0].to_f64().sin());
        assert_ne!(
            verdict(rounded, 0.3, factor * 0.3f64.cos(), 1e-11),
            Verdict::Smooth
        );
        assert_eq!(verdict(rounded, 0.3, factor * 0.3f64.cos(), 1e-5), expected);
    }
}

/// The negative control must be `None` where its verdict would prove nothing: if the gradient is zero or consists of
/// rounding errors, if it is wrong already, at a kink, or if the tolerance exceeds one hundredth.
#[test]
fn a_control_that_would_tell_nothing_is_none() {
    let coarse = Options {
        tolerance: 0.02,
        ..Options::default()
    };
    for (value, x, slope) in [
        (&|_| DoubleDouble::lit(1.0), 0.3, 0.0),
        (&|x| DoubleDouble::lit(1.0) + lit(1e-16) * x[0], 0.5, 1e-16),
        (&|x| x[0].exp(), 0.0, 1.1),
        (&|x| x[0].exp(), 0.0, f64::NAN),
        (&|x| x[0].exp() + x[0].abs(), 0.0, 1.0),
    ] as [(Value, f64, f64); 5]
    {
        for options in seeds() {
            let report = claimed(value, [&[x], &[slope]], &options);
            assert_eq!(report.control, None, "{report}");
        }
    }
    let report = claimed(&|x| x[0].exp(), [&[0.0], &[1.0]], &coarse);
    assert_eq!(report.control, None, "{report}");
}

/// The product of all numbers, which ends early at an exact zero and so loses the slopes of the later factors.
struct EarlyEnd {
    by_order: bool,
}

impl Function for EarlyEnd {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let mut product = R::one();
        for &x in x {
            product *= x;
            let held = Element(product);
            let by_order = held <= Element::lit(0.0) && held >= Element::lit(0.0);
            if by_order && self.by_order || product.primal() == 0.0 && !self.by_order {
                break;
            }
        }
        product
    }
}

#[test]
fn an_early_end_at_an_exact_zero_is_called_wrong() {
    for by_order in [true, false] {
        let early = EarlyEnd { by_order };
        let report = checked(&early, &[0.0, 2.0, 3.0]);
        assert_eq!(report.verdict, Verdict::Wrong, "{report}");
        assert_eq!(report.worst.expect("a component").index, 0);
        // Without a zero nothing is lost.
        assert_eq!(checked(&early, &[0.5, 2.0, 3.0]).verdict, Verdict::Smooth);
    }
}
