//! The gradient checker must accept right gradients, catch wrong ones, and recognise kinks.

use crate::common::{Formula, Sym, formula};
use autodiff::check::{Claim, Options, Report, Verdict, check_directions, check_gradient};
use autodiff::custom::{Rule, apply};
use autodiff::{Function, Real, gradient};

pub(crate) fn point(n: usize) -> Vec<f64> {
    (0..n).map(|i| 0.4 + 0.3 * (i as f64).sin()).collect()
}

/// A chain of smooth functions over all variables.
pub(crate) struct Smooth;

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

/// Returns the default options with `count` different seeds.
pub(crate) fn seeds(count: u64) -> impl Iterator<Item = Options> {
    (0..count).map(|seed| Options {
        seed,
        ..Options::default()
    })
}

fn checked(function: &impl Function, x: &[f64]) -> Report {
    check_gradient(function, x, &Options::default())
}

/// Checks a claimed gradient at a point by difference quotients, without forward mode.
pub(crate) fn claimed(
    value: impl Fn(&[f64]) -> f64,
    [x, gradient]: [&[f64]; 2],
    options: &Options,
) -> Report {
    let claim = Claim {
        x,
        gradient,
        forward: None,
    };
    check_directions(value, &claim, options)
}

#[test]
fn right_gradients_are_smooth() {
    for n in [1, 2, 50] {
        let report = checked(&Smooth, &point(n.max(2)));
        assert_eq!(report.verdict, Verdict::Smooth, "{report}");
        let report = checked(&WrongCube { of: 0, wrong: 1.0 }, &point(n));
        assert_eq!(report.verdict, Verdict::Smooth, "{report}");
    }
}

/// A wrong rule must be found although forward and reverse mode agree on it, because the differences disagree. The
/// report must name the argument.
#[test]
fn a_wrong_rule_is_wrong_and_named() {
    for (n, of) in [(1, 0), (7, 0), (7, 6), (64, 41)] {
        for wrong in [0.0, -1.0, 0.99, 1.001] {
            let report = checked(&WrongCube { of, wrong }, &point(n));
            assert_eq!(report.verdict, Verdict::Wrong, "{report}");
            assert_eq!(report.worst.index, of, "{report}");
            assert_eq!(report.worst.verdict, Verdict::Wrong, "{report}");
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
    for distance in [1e-3, -1e-4, 1e-5, -1e-6, 1e-7, -1e-8] {
        let function = rectifier(0.5 + distance);
        let x = [0.5, 0.2];
        let mut slopes = gradient(|x| function.eval(x), &x);
        for (factor, verdict) in [(1.0, Verdict::Smooth), (1.001, Verdict::Wrong)] {
            slopes[1] *= factor;
            for options in seeds(20) {
                let report = claimed(|x| function.eval(x), [&x, &slopes], &options);
                assert_eq!(
                    report.verdict, verdict,
                    "distance {distance}, {options:?}\n{report}"
                );
            }
        }
    }
}

/// Checks a claimed slope at a point against differences and against a second claimed slope, which stands for forward
/// mode.
fn with_forward(value: fn(f64) -> f64, x: f64, [reverse, forward]: [f64; 2]) -> Report {
    let forward = |direction: &[f64]| forward * direction[0];
    let claim = Claim {
        x: &[x],
        gradient: &[reverse],
        forward: Some(&forward),
    };
    check_directions(|x| value(x[0]), &claim, &Options::default())
}

#[test]
fn a_second_source_that_disagrees_is_wrong() {
    for slope in [2.1, f64::INFINITY, f64::NAN] {
        let report = with_forward(|x| x * x, 1.0, [2.0, slope]);
        assert_eq!(report.verdict, Verdict::Wrong, "{report}");
    }
}

/// Slopes must not be compared if they are too small to change the last digit of the value over a step as long as `x`.
/// Two sources of derivatives may both be right and still differ there, for example where `tanh` is saturated.
#[test]
fn sources_may_disagree_below_the_value_s_last_digit() {
    let verdict = |x, disagree| with_forward(|_| 0.1, x, [0.0, disagree]).verdict;
    assert_eq!(verdict(0.5, 1e-37), Verdict::Smooth);
    assert_eq!(verdict(0.5, 1e-15), Verdict::Wrong);
    assert_eq!(verdict(1e3, 1e-18), Verdict::Wrong);
}

/// If a slope is close to the rounding errors of the value, differences may agree with it by chance. The reported
/// uncertainty must show that.
#[test]
fn differences_say_how_sure_they_are() {
    let direction = |value: fn(f64) -> f64, slope: f64| {
        let report = claimed(|x| value(x[0]), [&[0.5], &[slope]], &Options::default());
        report.directions[0].clone()
    };
    let known = direction(f64::sin, 0.5f64.cos());
    assert!(
        known.error <= known.unsure && known.unsure < 1e-7,
        "{known:?}"
    );
    // The value is rounded to 1e-16 and steps are at most 3e-3. So the rounding error is a thirtieth of this slope.
    let drowned = direction(|x| 1.0 + 1e-12 * x, 1e-12);
    assert!(
        drowned.unsure > 1e-2 && drowned.unsure.is_finite(),
        "{drowned:?}"
    );
    let infinite = direction(|x| (x - 0.5).cbrt(), 1.0);
    assert_eq!(infinite.unsure, f64::INFINITY, "{infinite:?}");
}

#[test]
fn what_is_not_finite_never_passes() {
    let verdict = |gradient: f64| {
        claimed(|x| x[0] * x[0], [&[1.0], &[gradient]], &Options::default()).verdict
    };
    assert_eq!(verdict(f64::NAN), Verdict::Wrong);
    assert_eq!(verdict(f64::INFINITY), Verdict::Wrong);
    let root = formula(2, |x| x[0].sqrt() + x[1]);
    assert_ne!(checked(&root, &[0.0, 2.0]).verdict, Verdict::Smooth);
    assert_ne!(checked(&root, &[-1.0, 2.0]).verdict, Verdict::Smooth);
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
}

/// The report must name the component with the infinite slope as the worst.
#[test]
fn the_component_with_an_infinite_slope_is_the_worst() {
    let root = formula(3, |x| x[0].sqrt() + x[1] + x[2]);
    for options in seeds(10) {
        let report = check_gradient(&root, &[0.0, 2.0, 1.0], &options);
        assert_eq!(report.worst.index, 0, "{report}");
        assert_eq!(report.worst.gradient, f64::INFINITY);
        assert_ne!(report.verdict, Verdict::Smooth);
    }
}

/// In this claim the errors of two components cancel if all arguments move together. So the checker must look for the
/// worst component along the worst of the random directions.
#[test]
fn the_worst_direction_leads_to_the_worst_component() {
    for options in seeds(10) {
        let report = claimed(
            |x| x.iter().sum(),
            [&[0.3, 0.5, 0.7, 0.2], &[1.5, 0.5, 1.0, 1.001]],
            &options,
        );
        assert!(report.worst.index < 2, "{report}");
    }
}

/// The worst component must be the one that contributes most to the error along the worst direction. This need not be
/// the one with the largest error.
#[test]
fn components_weigh_as_the_direction_has_them() {
    // With this seed the only direction is along (0.30, 0.65).
    let options = Options {
        seed: 1234567,
        directions: 1,
        ..Options::default()
    };
    let report = claimed(|x| x[0] + x[1], [&[0.3, 0.5], &[2.0, 1.8]], &options);
    assert_eq!(report.worst.index, 1, "{report}");
}

/// An error in one component must be found even if the differences in another component are NaN.
#[test]
fn a_wrong_component_is_named_beside_one_that_cannot_be_judged() {
    let report = claimed(
        |x| x[0] * x[0] + x[1].sqrt(),
        [&[0.3, 0.0], &[0.7, 0.0]],
        &Options::default(),
    );
    assert_eq!(
        (report.worst.index, report.worst.verdict),
        (0, Verdict::Wrong)
    );
}

#[test]
fn an_error_is_a_share_of_the_slope() {
    let report = claimed(|x| 2.0 * x[0], [&[0.3], &[4.0]], &Options::default());
    // The function is linear, so its differences have only rounding errors: 1e-16 divided by the step.
    assert!((report.directions[0].error - 0.5).abs() < 1e-7, "{report}");
}

/// The tolerance must be relative to the slope.
#[test]
fn a_verdict_does_not_depend_on_the_unit() {
    for unit in [1e-12, 1.0, 1e12] {
        let check = |value: fn(f64) -> f64, at: f64, slope: f64| {
            claimed(
                |x| unit * value(x[0]),
                [&[at], &[unit * slope]],
                &Options::default(),
            )
        };
        let smooth = check(f64::sin, 0.3, 0.3_f64.cos());
        assert_eq!(smooth.verdict, Verdict::Smooth, "{unit}: {smooth}");
        assert_eq!(smooth.control, Some(Verdict::Wrong), "{unit}: {smooth}");
        let wrong = check(f64::sin, 0.3, 1.001 * 0.3_f64.cos());
        assert_eq!(wrong.verdict, Verdict::Wrong, "{unit}: {wrong}");
        for between in [-1.0, 0.5, 1.0] {
            let kink = check(f64::abs, 0.0, between);
            assert_eq!(kink.verdict, Verdict::Kink, "{unit}: {kink}");
        }
        let beyond = check(f64::abs, 0.0, 1.1);
        assert_eq!(beyond.verdict, Verdict::Wrong, "{unit}: {beyond}");
    }
}

/// A check must end with a verdict even at an infinite point, and if the ratio of the largest to the smallest step
/// overflows.
#[test]
fn any_point_and_any_span_of_steps_have_a_verdict() {
    let square = formula(1, |x| x[0] * x[0]);
    assert_eq!(checked(&square, &[f64::INFINITY]).verdict, Verdict::Kink);
    assert_eq!(checked(&square, &[f64::MAX]).verdict, Verdict::Kink);
    let options = Options {
        largest_step: f64::MAX,
        smallest_step: 1e-300,
        ..Options::default()
    };
    for x in [1.0, 1e3] {
        let report = check_gradient(&square, &[x], &options);
        assert_eq!(report.verdict, Verdict::Smooth, "{report}");
    }
}

#[test]
#[should_panic(expected = "it must be 1 or more")]
fn a_check_along_nothing_is_refused() {
    let options = Options {
        directions: 0,
        ..Options::default()
    };
    check_gradient(&Smooth, &[1.0, 2.0], &options);
}
