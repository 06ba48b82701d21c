//! On the tape, a computed zero must not hide an infinite partial, and a chosen zero must stop it.

use crate::common::{Sym, assert_gradients, formula, forward_gradient, gradients};
use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::custom::{Rule, apply};
use autodiff::trace::first_non_finite;
use autodiff::{Elementary, Function, Real, Var, gradient, hessian, lit, vjp};

const INF: f64 = f64::INFINITY;
const NAN: f64 = f64::NAN;

type Unary = fn(Sym) -> Sym;
type Choice = fn(Sym, Sym, Sym) -> Sym;

#[test]
fn an_intermediate_overflow_never_gives_a_wrong_zero() {
    assert_gradients(
        |x| lit(1.0) / (lit(1.0) / x[0] + lit(1.0) / x[1]),
        &[([0.0, 2.0], [NAN, 0.0])],
    );
    let overflows: [(Unary, f64); 6] = [
        (|x| x.recip().recip(), 0.0),
        (|x| x.ln().exp(), 0.0),
        (|x| (lit(1.0) / x).atan(), 0.0),
        (|x| (lit(1.0) + x.exp()).ln(), 1000.0),
        (|x| lit(1.0) / (lit(1.0) + (-x).exp()), -800.0),
        (|x| x.sqrt() - x.sqrt(), 0.0),
    ];
    for (function, at) in overflows {
        assert_gradients(|x| function(x[0]), &[([at], [NAN])]);
    }
    // The outer slope is that of a square at 0. It is 0, so it stops the infinity.
    assert_gradients(
        |x| Real::dot(&[x[0], x[1]], &[x[0], x[1]]).recip().recip(),
        &[([0.0, 0.0], [0.0, 0.0])],
    );
}

/// In the square of a square root, the operand of the root has a tangent of 0. Forward mode meets this zero before the
/// infinite partial, so the slope must be 0.
#[test]
fn an_operand_that_does_not_move_has_a_slope_of_zero() {
    let square = |root: Sym| root * root;
    assert_gradients(|x| square((x[0] * x[0]).sqrt()), &[([0.0], [0.0])]);
    let flat = [([0.0, 0.0], [0.0, 0.0])];
    assert_gradients(|x| square(Sym::dot(x, x).sqrt()), &flat);
    assert_gradients(|x| square((x[0] * x[0] + x[1] * x[1]).sqrt()), &flat);
    // The slope with respect to the second argument is 1. It cannot be computed from the root, whose partial is
    // infinite.
    assert_gradients(
        |x| square((x[0] * x[0] + x[1]).sqrt()),
        &[([0.0, 0.0], [0.0, NAN])],
    );
}

/// In each of these choices, the side that is not chosen has an infinite partial. The functions take `x`, its square
/// root, and a mask that is 0 where `x` is 0.
#[test]
fn a_chosen_zero_stops_an_infinite_partial() {
    let choices: [(&str, Choice); 15] = [
        ("mask * root", |_, root, mask| mask * root),
        ("root * mask", |_, root, mask| root * mask),
        ("fma", |_, root, mask| {
            let one = Sym::lit(1.0);
            root.fma(mask, one) + mask.fma(root, one)
        }),
        ("dot", |_, root, mask| {
            Real::dot(&[mask, Sym::lit(1.0)], &[root, Sym::lit(1.0)])
        }),
        ("mask / root", |_, root, mask| mask / (lit(1.0) + root)),
        ("deep", |_, root, mask| {
            (mask * root).exp() + (lit(1.0) - mask)
        }),
        ("signum", |x, root, _| x.signum() * root),
        ("abs", |_, root, _| root.abs()),
        ("abs of a square", |_, root, _| {
            (root * root).abs() * root.abs()
        }),
        ("max", |_, root, _| (root - lit(1.0)).max(Sym::lit(0.0))),
        ("min", |_, root, _| (lit(1.0) - root).min(Sym::lit(0.0))),
        ("clamp", |_, root, _| {
            root.clamp(Sym::lit(1.0), Sym::lit(2.0))
        }),
        ("select", |x, root, _| {
            Real::select(x.less_equal(Sym::lit(0.0)), Sym::lit(1.0), root.recip())
        }),
        ("powi", |_, root, _| root.powi(0)),
        ("root * 0", |_, root, _| root * Sym::lit(0.0)),
    ];
    let passes = |what: &str, choice: &dyn Fn(&[Sym]) -> Sym| {
        for (mode, gradient) in gradients(&formula(1, choice), &[0.0]) {
            if mode.starts_with("reverse") {
                assert_eq!(gradient, [0.0], "{what}, {mode}");
            }
        }
    };
    for (what, choice) in choices {
        passes(what, &|x| {
            let [zero, one] = [0.0, 1.0].map(Sym::lit);
            let mask = Real::select(x[0].less_equal(zero), zero, one);
            choice(x[0], x[0].sqrt(), mask)
        });
    }
    // This makes the same choice by an `if`.
    let branch = |x: &[Var<f64>]| {
        if x[0].primal() > 0.0 {
            x[0].sqrt()
        } else {
            Var::lit(0.0)
        }
    };
    assert_eq!(gradient(branch, &[0.0]), [0.0]);
}

#[test]
fn a_cotangent_that_was_given_as_zero_stops() {
    let values = |x: &[Var<f64>]| vec![x[0].recip(), x[0]];
    assert_eq!(vjp(values, &[0.0], &[0.0, 1.0]).1, [1.0]);
}

/// A branch that is not taken must not change the other components of the gradient.
#[test]
fn other_components_are_bit_identical() {
    let clean = |x: &[Var<f64>]| (x[1] * x[2]).sin() / x[2] + x[1].exp();
    let doubtful = |x: &[Var<f64>]| clean(x) + x[0].recip().recip();
    let (plain, found) = (
        gradient(clean, &[0.0, 0.3, 0.7]),
        gradient(doubtful, &[0.0, 0.3, 0.7]),
    );
    assert!(found[0].is_nan());
    assert_eq!(found[1..], plain[1..]);
}

#[derive(Clone, Copy)]
struct Reciprocal;

impl Rule for Reciprocal {
    fn value<R: Real>(&self, x: &[R]) -> R {
        x[0].recip()
    }
    fn partials<R: Real>(&self, _: &[R], value: R) -> Vec<R> {
        vec![-(value * value)]
    }
}

/// A function in which a zero may still hide an infinity: behind a fused function.
struct Hidden;

impl Function for Hidden {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        apply(Reciprocal, &[x[0].recip()])
    }
}

#[test]
fn check_and_trace_find_an_infinity_that_a_zero_hides() {
    assert_eq!(gradient(|x| Hidden.eval(x), &[0.0]), [0.0]);
    let report = check_gradient(&Hidden, &[0.0], &Options::default());
    assert_eq!(report.verdict, Verdict::Wrong, "{report}");
    let found = first_non_finite(|x| vec![Hidden.eval(x)], &[0.0]).expect("1 / 0");
    assert_eq!(found.operation, "recip", "{found}");
}

/// The table in the section *Zero times infinity* of `kinks.md`.
#[test]
fn forward_mode_stops_at_a_computed_zero_where_the_tape_is_nan() {
    let rows: [(Unary, f64); 5] = [
        (|x| (x * x * x).cbrt(), 0.0),
        (|x| (x * x * x).cbrt(), 1e-170),
        (|x| x.sigmoid().ln(), -800.0),
        (|x| x.erfc().ln(), 30.0),
        (|x| (x * x).sqrt(), 0.0),
    ];
    for (function, x) in rows {
        let function = formula(1, |x| function(x[0]));
        assert_eq!(forward_gradient(&function, &[x]), [0.0]);
        assert!(gradient(|x| function.eval(x), &[x])[0].is_nan());
        let found = first_non_finite(|x| vec![function.eval(x)], &[x]);
        assert!(found.is_some(), "an infinite partial at {x}");
    }
    for x in [0.0, 1e-170] {
        let cubic_root = formula(1, |x| (x[0] * x[0] * x[0]).cbrt());
        let report = check_gradient(&cubic_root, &[x], &Options::default());
        assert_eq!(report.verdict, Verdict::Wrong, "{report}");
    }
    let scaled = formula(1, |x| Sym::lit(0.0) * x[0].sqrt());
    assert!(forward_gradient(&scaled, &[0.0_f64])[0].is_nan());
    assert_eq!(gradient(|x| scaled.eval(x), &[0.0]), [0.0]);
    // What the table says to write instead.
    let logarithms = [
        (Sym::log_sigmoid as Unary, -800.0, 1.0),
        (Sym::ln_erfc, 30.0, -60.033296),
    ];
    for (function, x, slope) in logarithms {
        for (mode, found) in gradients(&formula(1, |x| function(x[0])), &[x]) {
            assert!((found[0] - slope).abs() < 1e-6, "{mode} at {x}: {found:?}");
        }
    }
}

/// Functions of one number: methods that have rules of their own, and all [`Elementary`] functions.
fn functions() -> Vec<Box<dyn Fn(Sym) -> Sym>> {
    let methods: [Unary; 17] = [
        |x| x.recip(),
        |x| lit(1.0) / x,
        |x| x.sqrt(),
        |x| x.rsqrt(),
        |x| x.exp(),
        |x| x.ln(),
        |x| x.sin(),
        |x| x.cos(),
        |x| x.tan(),
        |x| x.tanh(),
        |x| x.atan(),
        |x| x.powi(1),
        |x| x.powi(2),
        |x| x.powi(-3),
        |x| x.powf(Sym::lit(1.5)),
        |x| Sym::lit(2.0).powf(x),
        |x| x.hypot(x * x),
    ];
    let mut functions: Vec<Box<dyn Fn(Sym) -> Sym>> = Vec::new();
    for function in methods {
        functions.push(Box::new(function));
    }
    for &function in Elementary::ALL {
        functions.push(Box::new(move |x| x.elementary(function)));
    }
    functions
}

/// Forward mode is the reference. Where it gives NaN, no other mode may give a number, and elsewhere all modes must
/// agree. The tested functions are all pairs of two functions, one applied to the result of the other.
#[test]
fn no_mode_gives_a_number_where_forward_mode_gives_nan() {
    let points = [
        0.0, -0.0, 1.0, -1.0, 0.3, 2.0, 1000.0, -1000.0, 1e200, -1e200, 1e-200, 5e-324, INF, -INF,
        NAN,
    ];
    let functions = functions();
    let count = functions.len();
    for (outer, inner) in (0..count * count).map(|k| (k / count, k % count)) {
        let chained = formula(1, |x| functions[outer](functions[inner](x[0])));
        for x in points {
            let forward = forward_gradient(&chained, &[x])[0];
            for (mode, gradient) in gradients(&chained, &[x]) {
                let slope = gradient[0];
                // The modes multiply the same partials in a different order.
                let close = (slope - forward).abs() <= 4.0 * f64::EPSILON * forward.abs();
                let same = slope.is_nan() || !forward.is_nan() && (slope == forward || close);
                assert!(
                    same,
                    "{outer} of {inner} at {x}: {slope} {mode}, {forward} forward"
                );
            }
        }
    }
}

#[test]
fn a_computed_zero_has_no_second_derivative_either() {
    assert!(hessian(|x| x[0].recip().recip(), &[0.0_f64])[0][0].is_nan());
    let square_of_root = hessian(
        |x| {
            let root = (x[0] * x[0]).sqrt();
            root * root
        },
        &[0.0_f64],
    );
    assert!(square_of_root[0][0].is_nan());
}
