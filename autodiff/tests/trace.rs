//! The reported origin of an infinity or NaN must agree with the results of the modes.

use crate::common::{Sym, formula};
use autodiff::custom::{Rule, apply};
use autodiff::implicit::{Residual, root};
use autodiff::simd::{Lane, Vectorized, kernel};
use autodiff::trace::{NonFinite, Traced, first_non_finite};
use autodiff::{Dual, Function, Real, gradient, value_and_gradient};

fn origin(function: &impl Function, x: &[f64]) -> Option<NonFinite> {
    first_non_finite(|x| vec![function.eval(x)], x)
}

struct Chain;

const LINE_OF_LN: u32 = line!() + 6;

impl Function for Chain {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let grown = x[0] * x[0] + x[1];
        // This operation takes the logarithm of a negative number.
        let lost = (grown - R::lit(5.0)).ln();
        let mut y = lost.sin() + x[0];
        y *= R::lit(2.0);
        y
    }
}

/// The closure of a gradient can be traced as it is, with floats beside numbers.
#[test]
fn a_closure_with_floats_is_traced() {
    let found = first_non_finite(|x| vec![2.0 * (x[0] * 0.5 - 3.0).ln() + 1.0], &[4.0]);
    let found = found.expect("a NaN");
    assert_eq!((found.operation, found.number), ("ln", 3));
}

#[test]
fn the_first_of_many_nans_is_named() {
    let found = origin(&Chain, &[1.0, 2.0]).expect("a NaN");
    let by: Vec<f64> = gradient(|x| Chain.eval(x), &[1.0, 2.0]);
    assert!(by[0].is_nan());
    assert_eq!((found.operation, found.number, found.step), ("ln", 4, None));
    assert_eq!(
        (found.place.file(), found.place.line()),
        (file!(), LINE_OF_LN)
    );
    assert_eq!(found.numbers, "of -2.0: value NaN, partial NaN");
    let text = found.to_string();
    assert!(text.starts_with("operation 4, ln, at "), "{text}");
    assert_eq!(origin(&Chain, &[3.0, 2.0]), None);
}

#[test]
fn an_argument_is_named_by_its_place() {
    let found = origin(&Chain, &[3.0, f64::NAN]).expect("a NaN");
    assert_eq!((found.operation, found.number), ("argument", 0));
    assert_eq!(found.numbers, "x[1] is NaN");
    assert_eq!(found.place.file(), file!());
}

#[test]
fn the_side_that_is_not_chosen_is_not_blamed() {
    // Returns a function that takes the square root of its argument. Below the bound `from` it chooses the argument
    // itself.
    let root = |from: f64| {
        formula(1, |x| {
            let root = Sym::select(x[0].less(Sym::lit(from)), x[0], x[0].sqrt());
            root + x[0].min(Sym::lit(f64::INFINITY))
        })
    };
    let guarded = root(1e-9);
    assert_eq!(origin(&guarded, &[0.0]), None);
    assert_eq!(gradient(|x| guarded.values(x)[0], &[0.0]), [2.0]);
    let bare = root(-1.0);
    let found = origin(&bare, &[0.0]).expect("an infinite partial");
    assert_eq!(found.operation, "sqrt");
    assert_eq!(gradient(|x| bare.values(x)[0], &[0.0]), [f64::INFINITY]);
}

type Unary = fn(Sym) -> Sym;

/// The names of operations, each with an argument at which its derivative or value is not finite, and the operation.
const KINKS: [(&str, f64, Unary); 14] = [
    ("sqrt", 0.0, |x| x.sqrt()),
    ("rsqrt", 0.0, |x| x.rsqrt()),
    ("recip", 0.0, |x| x.recip()),
    ("ln", 0.0, |x| x.ln()),
    ("exp", 1000.0, |x| x.exp()),
    ("powi", 0.0, |x| x.powi(-2)),
    ("powf", 0.0, |x| x.powf(Sym::lit(0.5))),
    ("quotient", 0.0, |x| Sym::lit(1.0) / x),
    ("product", 1e200, |x| x * x),
    ("sum", 1e308, |x| x + x),
    ("asin", 1.0, |x| x.asin()),
    ("cbrt", 0.0, |x| x.cbrt()),
    ("multiply-add", 1e200, |x| Sym::dot(&[x, x], &[x, x])),
    ("difference", 1.7e308, |x| x - Sym::lit(-1e308)),
];

#[test]
fn every_operation_is_judged_by_value_and_partial() {
    for (operation, x, function) in KINKS {
        let kink = formula(1, |x| function(x[0]));
        let found = origin(&kink, &[x]).expect(operation);
        assert_eq!((found.operation, found.number), (operation, 1));
        let (value, gradient) = value_and_gradient(|x| kink.values(x)[0], &[x]);
        let sound = value.is_finite() && gradient[0].is_finite();
        assert!(!sound, "{operation}");
        // At an ordinary argument no operation must be reported.
        assert_eq!(origin(&kink, &[0.7]), None, "{operation}");
    }
}

#[test]
fn constants_and_detached_numbers_have_no_partials() {
    let of = |function: fn(Traced<f64>) -> Traced<f64>| {
        first_non_finite(|x| vec![function(x[0])], &[0.0])
    };
    assert_eq!(of(|x| x + Traced::lit(0.0).sqrt()), None);
    assert_eq!(of(|x| x + x.sqrt().detach()), None);
    assert_eq!(of(|x| x.signum().straight_through(x)), None);
    assert_eq!(
        of(|x| x.straight_through(x.sqrt()))
            .expect("soft")
            .operation,
        "sqrt"
    );
    let lost = of(|x| x + x.ln().detach()).expect("an infinite value");
    assert_eq!(lost.operation, "ln");
}

#[test]
fn tracing_nests_and_follows_derivatives_inside() {
    let x = Dual::<f64, 1>::variable(0.0, 0);
    let found = first_non_finite(
        |x| {
            let inner = first_non_finite(|y| vec![y[0].ln().ln()], &[1.0]);
            assert_eq!(inner.expect("ln of 0").number, 2);
            vec![x[0].sqrt()]
        },
        &[x],
    );
    assert_eq!(found.expect("a slope of sqrt").number, 1);
}

/// A rule for the absolute value. The value is computed by a square root, whose slope at 0 is infinite. The rule gives
/// another slope there.
#[derive(Clone)]
struct Magnitude {
    slope_at_zero: f64,
}

impl Rule for Magnitude {
    fn value<R: Real>(&self, x: &[R]) -> R {
        (x[0] * x[0]).sqrt()
    }
    fn partials<R: Real>(&self, x: &[R], _: R) -> Vec<R> {
        let zero = x[0].abs().less_equal(R::zero());
        vec![R::select(zero, R::lit(self.slope_at_zero), x[0].signum())]
    }
}

#[test]
fn a_custom_rule_is_judged_by_its_own_partials() {
    let of =
        |slope_at_zero, x| first_non_finite(|x| vec![apply(Magnitude { slope_at_zero }, x)], &[x]);
    assert_eq!(of(0.0, 0.0), None);
    assert_eq!(of(f64::NAN, 2.0), None);
    // If neither the root inside nor the slope of the rule is finite, the root must be reported.
    assert_eq!(of(f64::NAN, 0.0).expect("a kink").operation, "sqrt");
    #[derive(Clone)]
    struct Smooth;
    impl Rule for Smooth {
        fn value<R: Real>(&self, x: &[R]) -> R {
            x[0]
        }
        fn partials<R: Real>(&self, x: &[R], _: R) -> Vec<R> {
            vec![x[0].recip()]
        }
    }
    let found = first_non_finite(|x| vec![apply(Smooth, x)], &[0.0]).expect("1 / 0");
    assert_eq!(found.operation, "fused function");
    assert_eq!(found.place.file(), file!());
}

/// The equation `x^3 + x = p`.
#[derive(Clone)]
struct Cubic;

impl Residual for Cubic {
    fn eval<R: Real>(&self, x: &[R], p: &[R]) -> Vec<R> {
        vec![x[0].powi(3) + x[0] - p[0]]
    }
}

/// A rule that returns its argument and has no derivative.
#[derive(Clone)]
struct Held;

impl Rule for Held {
    fn value<R: Real>(&self, x: &[R]) -> R {
        x[0].detach()
    }
    fn partials<R: Real>(&self, _: &[R], _: R) -> Vec<R> {
        vec![R::one()]
    }
}

#[test]
fn the_trace_passes_through_roots_and_rules() {
    fn through<R: Real>(p: R, rule: bool) -> R {
        if rule {
            return apply(Held, &[p]);
        }
        root(Cubic, &[R::zero()], &[p]).expect("an increasing residual")[0]
    }
    for rule in [true, false] {
        let after = first_non_finite(|x| vec![through(x[0], rule).sqrt()], &[0.0]);
        let before = first_non_finite(|x| vec![through(x[0].sqrt(), rule)], &[0.0]);
        for found in [after, before] {
            assert_eq!(
                found.expect("an infinite slope").operation,
                "sqrt",
                "{rule}"
            );
        }
        assert_eq!(
            first_non_finite(|x| vec![through(x[0], rule)], &[0.0]),
            None
        );
    }
}

#[test]
fn results_of_constants_are_constants() {
    // The root has an infinite partial. It does not matter, because the root depends on no argument of the function.
    let held = |x: Traced<f64>| vec![x + apply(Held, &[Traced::lit(0.0)]).sqrt()];
    assert_eq!(first_non_finite(|x| held(x[0]), &[1.0]), None);
    let solved = |x: Traced<f64>| {
        let zero = Traced::lit(0.0);
        let solution = root(Cubic, &[zero], &[zero]).expect("an increasing residual");
        vec![x + solution[0].sqrt()]
    };
    assert_eq!(first_non_finite(|x| solved(x[0]), &[1.0]), None);
}

/// Returns the reported operations in four cases. Half of the lanes are zero and choose a square root, either before or
/// after it is taken. The other lanes choose a constant. The root is the first or the second operand of the choice.
struct ChoicesByLanes;

#[kernel]
impl Vectorized<f64> for ChoicesByLanes {
    type Output = Vec<Option<&'static str>>;
    fn run<L: Lane<f64>>(self) -> Self::Output {
        let x = L::load(&[0.0, 1.0].repeat(8));
        let (small, one) = (x.less(L::lit(0.5)), Traced::lit(1.0));
        type Choice<L> = fn(<L as Real>::Mask, Traced<L>, Traced<L>) -> Traced<L>;
        let choose: [Choice<L>; 2] = [Traced::select, |mask, x, y| Traced::select(!mask, y, x)];
        let mut blamed = Vec::new();
        for choose in choose {
            let of = |function: &dyn Fn(Traced<L>) -> Traced<L>| {
                first_non_finite(|x| vec![function(x[0])], &[x]).map(|found| found.operation)
            };
            // The square root is taken before the choice, and then after it.
            blamed.push(of(&|x| choose(small, x.sqrt(), one)));
            blamed.push(of(&|x| choose(small, x, one).sqrt()));
        }
        blamed
    }
}

#[test]
fn a_choice_by_lanes_is_blamed_for_either_side() {
    assert_eq!(f64::vectorize(ChoicesByLanes), [Some("sqrt"); 4]);
}

/// `is_zero` must answer as for the variables of a tape: it is never true for a variable, and may be true for a
/// constant.
#[test]
fn is_zero_answers_as_for_variables() {
    fn asks<R: Real>(x: &[R]) -> R {
        let zeros = [x[0].is_zero(), R::zero().is_zero(), R::one().is_zero()];
        assert_eq!(zeros, [false, true, false]);
        x[0].sqrt()
    }
    assert_eq!(gradient(asks, &[0.0]), [f64::INFINITY]);
    assert_eq!(
        first_non_finite(|x| vec![asks(x)], &[0.0])
            .expect("a slope")
            .operation,
        "sqrt"
    );
}
